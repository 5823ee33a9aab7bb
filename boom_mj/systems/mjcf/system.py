"""Any MJCF machine as a system: what its channel map compares."""

from collections.abc import Callable, Mapping, Sequence
from threading import Lock

import mujoco
import numpy as np

from boom_mj.effects import Effect, ForceEffect, ModelEffect, OutputEffect, Site, is_output, make_effect
from boom_mj.errors import EffectError, SimulationError
from boom_mj.recording import Recording, Signal
from boom_mj.systems.fidelity import FidelityLadder, Level, Refinement
from boom_mj.systems.mjcf.channel_map import ChannelMap
from boom_mj.systems.mjcf.checking import check
from boom_mj.systems.mjcf.readout import in_loop, inputs_of, joint_moved, pushed, said, temperature
from boom_mj.systems.mjcf.rollout import Inputs, Run, drivable, simulate
from boom_mj.systems.mjcf.segments import smoothed
from boom_mj.systems.mjcf.settings import with_settings
from boom_mj.systems.mjcf.sites import sites_of
from boom_mj.systems.system import (
    NO_REASONS,
    ChannelPlace,
    Hypothesis,
    Nuisance,
    Reasons,
    SystemFacts,
    Timeline,
    Wording,
)

Array = np.ndarray
BASE, FINE, FINEST = Level(1.0), Level(0.5), Level(0.25)
RICHARDSON = Refinement((FINE, FINEST), missing=(-1.0, 2.0), doubtful=(-3.0, 2.0))  # of first order in the step
NOISE = Refinement((Level(1.0, shaken=True),), missing=(0.0,), doubtful=(2**0.5,))  # variance: half of its square
BANDS_HZ = (("static", 0.2), ("slow", 1.0), ("middle", 5.0), ("above", np.inf))
STILL, NEVER = 0.02, 1e-9  # of a joint's fastest speed in a stretch; speed of what never moves
KEPT = 24  # compiled models
TOGETHER = 8  # hypotheses whose runs of all stretches are kept


class MjcfSystem:
    """An MJCF machine.

    Args:
        spec: nominal model.
        channels: what the log's fields are.
        recordings: stretches of logs to learn from, for the sizes that are typical of the machine.
        noise: per sample, by compared channel.
    """

    def __init__(
        self, spec: mujoco.MjSpec, channels: ChannelMap, recordings: Sequence[Recording], noise: Mapping[str, float]
    ) -> None:
        check(spec, channels)
        self.spec, self.channels = spec, channels
        self.entries = {entry.name: entry for entry in channels.channel}
        self.facts = SystemFacts(
            kind="mjcf",
            name=channels.name,
            block_s=channels.block_s,
            correlation_s=channels.independent,
            bands_hz=BANDS_HZ,
            fidelity=_ladder(channels),
            noise={name: np.array([level]) for name, level in noise.items()},
            still=NEVER,
            max_causes=channels.causes,
            wording=Wording(
                phases=("hold", "move", "reversal"),
                first_part=f"two of every three stretches of {channels.independent:g} s",
                finer="finer steps",
                zero_offset="sensor_offset",
            ),
            split=self._first,
            repeat_s=channels.repeat,
            provenance={"step_s": spec.option.timestep, "block_s": channels.block_s, "stretch_s": channels.window},
        )
        self._models: dict[tuple, mujoco.MjModel] = {}
        self._asked: dict[int, Recording] = {}
        self._trained = set(map(id, recordings))
        self._nominal: dict[tuple[int, Level], Run] = {}
        self._runs: dict[tuple, dict[int, Run | SimulationError]] = {}
        self._stepping = Lock()
        self._compiling = Lock()
        runs = [self.run((), BASE, log) for log in recordings]
        self._sites = sites_of(spec, channels, recordings, runs)

    def sites(self) -> tuple[Site, ...]:
        return self._sites

    def nuisances(self) -> tuple[Nuisance, ...]:
        """Zero offsets, of the channels that are given one."""
        entries = [entry for entry in self.channels.channel if entry.zero and not entry.actuator]
        offsets = ({"channel": entry.name, "offset": entry.zero} for entry in entries if entry.sensed)
        return tuple(Nuisance((make_effect("sensor_offset", offset, self._sites),), 1.0) for offset in offsets)

    def timeline(self, log: Recording) -> Timeline:
        begin = float(log["start"].time[0])
        duration = float(max(signal.time[-1] for signal in log.signals.values()) - begin)
        drives = [entry.name for entry in self.channels.role("drive")]
        joints = [log[name] for name in (*drives, *(name for name in log.signals if name.startswith("motion/")))]

        def coordinates(time: Array) -> Array:
            if not joints:
                return np.zeros((len(time), 1))
            return np.stack([np.interp(time, s.time - begin, s.values[:, 0]) for s in joints], axis=1)

        return Timeline(begin, duration, coordinates, lambda: self._phases(coordinates, duration))

    def simulate(self, hypothesis: Hypothesis, level: Level, log: Recording) -> dict[str, Signal]:
        run, found = self.run(hypothesis, level, log), {}
        for entry in self.channels.role("compare"):
            values = said(entry, run, self._model((), BASE), self.spec, self.channels, hypothesis, log)
            if entry.relative:
                values = values - values[0]
            if self.channels.driven:
                values = smoothed(run.time, values, self.channels.compared_cutoff)
            found[entry.name] = Signal(run.time, values[:, None], (entry.name,), "1", entry.place)
            warm = temperature(self.channels, joint_moved(self.spec, entry), log, run.time)
            if warm is not None:
                found[f"temperature/{entry.name}"] = Signal(run.time, warm[:, None], (entry.name,), "degC", entry.place)
        return found

    def observe(self, hypothesis: Hypothesis, dense: Mapping[str, Signal]) -> dict[str, Signal]:
        found = dict(dense)
        for effect in hypothesis:
            if isinstance(effect, OutputEffect) and is_output(effect):
                found |= effect.observe(found, None)
        return found

    def channel(self, signal: str, column: int) -> ChannelPlace:
        entry = self.entries[signal]
        vector = entry.sensor and self.spec.sensor(entry.sensor).get_data_size() == 3
        direction = "xyz"[entry.component] if vector else ""
        place = f"{entry.what}, {entry.place}"
        return ChannelPlace(signal, entry.what, entry.place, direction, signal, place, signal)

    def corrected(self, causes: Hypothesis, nuisances: Hypothesis = (), reasons: Reasons = NO_REASONS) -> str:
        """The MJCF text with effects in it; comments say why each is there, and which of them MJCF does not hold."""
        spec, why = self.spec.copy(), []
        for kind, effects in (("nuisance, as built", nuisances), ("cause", causes)):
            for effect in effects:
                if isinstance(effect, ModelEffect):
                    effect.edit(spec, None)
                said = [f"; {name}: {reasons[effect, name]}" for name in effect.values if (effect, name) in reasons]
                whole = reasons.get((effect, "id"), kind)
                why.append(f"<!-- {whole}{_missing(effect)}: {effect}{''.join(said)} -->\n")
        spec.compile()
        return spec.to_xml() + "".join(why)

    def run(self, hypothesis: Hypothesis, level: Level, log: Recording) -> Run:
        """A stretch under effects; those of compared channels are left to `observe`.

        Raises:
            SimulationError: it diverged.
        """
        self._asked[id(log)] = log
        if in_loop(hypothesis, self.channels):
            run = self._together(hypothesis, level, log)
        else:
            (run,) = simulate(self._model(hypothesis, level, log.description), [self._inputs(hypothesis, level, log)])
        if isinstance(run, SimulationError):
            raise run
        return run

    def _inputs(self, hypothesis: Hypothesis, level: Level, log: Recording) -> Inputs:
        line, spec = self.timeline(log), self._spec(log.description)
        step = spec.option.timestep * level.step
        time = step * np.arange(int(np.ceil(line.duration_s / step - 1e-9)) + 1)

        def nominal() -> Run:
            key = id(log), level
            if key not in self._nominal:
                self._nominal[key] = self.run((), level, log)
            return self._nominal[key]

        return inputs_of(spec, self.channels, hypothesis, log, line.start_s, time, nominal, level)

    def _together(self, hypothesis: Hypothesis, level: Level, log: Recording) -> Run | SimulationError:
        """Steps that wait for forces are taken at once in all stretches that train, or in all others."""
        settings = self.channels.of_log(log.description).set
        key = frozenset(hypothesis), level, tuple(settings.items())
        with self._stepping:
            known = self._runs.pop(key, {})
            if id(log) not in known:
                trained = id(log) in self._trained
                asked = [one for k, one in [*self._asked.items()] if k not in known and (k in self._trained) == trained]
                alike = [one for one in asked if self.channels.of_log(one.description).set == settings]
                inputs = [self._inputs(hypothesis, level, one) for one in alike]
                runs = simulate(self._model(hypothesis, level, log.description), inputs)
                known |= dict(zip(map(id, alike), runs))
            self._runs[key] = known
            if len(self._runs) > TOGETHER:
                self._runs.pop(next(iter(self._runs)))
            return known[id(log)]

    def _spec(self, log: str) -> mujoco.MjSpec:
        """The nominal model as it is in a log at a path."""
        settings = self.channels.of_log(log).set
        return with_settings(self.spec, settings) if settings else self.spec

    def _phases(self, coordinates: Callable[[Array], Array], duration: float) -> Array:
        """Hold, move, reversal, by the measured joints."""
        block = self.facts.block_s
        rate = np.gradient(coordinates(np.arange(0, duration + block, block) + block / 2), block, axis=0)
        moving = np.abs(rate) > STILL * np.maximum(np.abs(rate).max(axis=0), NEVER)
        names = np.where(moving.any(axis=1), "move", "hold").astype("<U14")
        for turn in np.flatnonzero((rate[:-1] * rate[1:] < 0).any(axis=1)):
            names[max(0, turn - 1) : turn + 2] = "reversal"
        return names

    def _first(self, time: Array, lasts: Array) -> Array:
        """Two of three windows of independence: a lone recording may have all that happens in its beginning."""
        return (time // self.channels.independent).astype(int) % 3 != 2

    def _model(self, hypothesis: Hypothesis, level: Level, log: str = "") -> mujoco.MjModel:
        """The compiled model of a hypothesis, as it is in a log at a path; the last few are kept."""
        settings = self.channels.of_log(log).set
        editing = tuple(e for e in hypothesis if isinstance(e, ModelEffect))
        hands = pushed(hypothesis, self.channels)
        key = (frozenset(editing), hands, level.step, tuple(settings.items()))
        with self._compiling:
            if key not in self._models:
                while len(self._models) >= KEPT:
                    self._models.pop(next(iter(self._models)))
                spec = self._spec(log).copy()
                spec.option.timestep *= level.step
                for effect in editing:
                    try:
                        effect.edit(spec, None)
                    except ValueError as error:
                        raise EffectError(f"{effect} cannot stand beside the other effects: {error}") from error
                try:
                    self._models[key] = drivable(spec, self.channels.driven, hands)
                except ValueError as error:
                    raise EffectError(f"{', '.join(map(str, editing))} makes no model: {error}") from error
            return self._models[key]


def _ladder(channels: ChannelMap) -> FidelityLadder:
    """Of steps, of what measured motion is like, and of measured states at the start."""
    starts = tuple(Level(1.0, start=1 + k) for k in range(2 * len(channels.started)))
    return FidelityLadder(BASE, BASE, BASE, (RICHARDSON, NOISE), BASE, starts=starts)


def _missing(effect: Effect) -> str:
    """What of an effect a model's text does not hold."""
    whole, part = isinstance(effect, ModelEffect), isinstance(effect, ForceEffect)
    return (", in part not in the model" if part else "") if whole else ", not in the model"
