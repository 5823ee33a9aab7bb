"""Any MJCF machine as a subject of diagnosis: what its channel map compares, and the effects of `effects/general/`."""

from collections.abc import Mapping, Sequence
from threading import Lock
from typing import Any

import mujoco
import numpy as np

from boom_mj.diagnosis.linearisation import Metric
from boom_mj.effects import Effect
from boom_mj.effects.general_effect import ChannelEffect, CommandEffect, ResistEffect, SpecEffect, general_library
from boom_mj.errors import EffectError
from boom_mj.recording import Recording, Signal
from boom_mj.systems.mjcf.channel_map import ChannelEntry, ChannelMap
from boom_mj.systems.mjcf.checking import check
from boom_mj.systems.mjcf.rollout import Course, Run, drivable, simulate
from boom_mj.systems.mjcf.segments import smoothed
from boom_mj.systems.mjcf.sites import places_of
from boom_mj.systems.system import (
    Band,
    FidelityLadder,
    Hypothesis,
    Level,
    Nuisance,
    Refinement,
    ResidualForce,
    System,
    Words,
)

Array = np.ndarray
KEPT = 24  # compiled models
STILL = 0.02  # of a joint's fastest speed in a stretch
BASE, FINE = Level(1.0), Level(0.5)


class MjcfSystem(System):
    """An MJCF machine.

    Args:
        spec: nominal model.
        channels: what the log's fields are.
        recordings: stretches of logs to learn from, for the sizes that are typical of the machine.
        noise: per sample, by compared channel.
    """

    fidelity = FidelityLadder(
        BASE, BASE, BASE, (Refinement(FINE, 2.0, 2.0),), BASE
    )  # integrators are of first order in the step
    slack, worth, spill = 0.02, 0.2, 0.0

    def __init__(
        self,
        spec: mujoco.MjSpec,
        channels: ChannelMap,
        recordings: Sequence[Recording],
        noise: Mapping[str, float],
    ) -> None:
        check(spec, channels)
        self._noise = {name: np.array([level]) for name, level in noise.items()}
        self.spec, self.channels = spec, channels
        self.causes, self.repeat = channels.causes, channels.repeat
        self.block, self.window, self.still = channels.block_s, channels.independent, 1e-9
        self.bands: tuple[Band, ...] = (("static", 0.2), ("slow", 1.0), ("middle", 5.0), ("above", np.inf))
        self.words = Words(
            phases=("hold", "move", "reversal"),
            learnt=f"two of every three stretches of {self.window:g} s",
            finer="half the step",
            zero="sensor_offset",
        )
        self.entries = {entry.name: entry for entry in channels.channel}
        self._models: dict[tuple, mujoco.MjModel] = {}
        self._compiling = Lock()
        runs = [self.run((), BASE, log) for log in recordings]
        self._library = [
            (kind.at(name, typical), {kind.where: name} if kind.where else {})
            for kind in general_library().values()
            for name, tags, typical in places_of(self, kind.where, recordings, runs)
            if kind.needs <= tags
        ]

    @property
    def name(self) -> str:
        return self.channels.name

    @property
    def provenance(self) -> Mapping[str, Any]:
        return {"step_s": self.spec.option.timestep, "block_s": self.block, "stretch_s": self.channels.window}

    def library(self) -> list[tuple[type[Effect], dict]]:
        return list(self._library)

    def tolerances(self) -> tuple[Nuisance, ...]:
        """Zero offsets, of the channels that are given one."""
        offset = {place["channel"]: kind for kind, place in self._library if kind.id == "sensor_offset"}
        return tuple(
            Nuisance((offset[entry.name]({"channel": entry.name}, offset=entry.zero),), 1.0)
            for entry in self.channels.channel
            if entry.zero and entry.name in offset
        )

    def noise(self) -> Mapping[str, Array]:
        return self._noise

    def clock(self, log: Recording) -> tuple[float, float]:
        begin = float(log["start"].time[0])
        return begin, float(max(signal.time[-1] for signal in log.signals.values()) - begin)

    def split(self, hypothesis: Hypothesis) -> tuple[Hypothesis, Hypothesis]:
        sensing = tuple(e for e in hypothesis if isinstance(e, ChannelEffect) and self._compared(e))
        return tuple(e for e in hypothesis if e not in sensing), sensing

    def simulate(self, hypothesis: Hypothesis, level: Level, index: int, log: Recording) -> dict[str, Signal]:
        run, found = self.run(hypothesis, level, log), {}
        for entry in self.channels.role("compare"):
            said = self._said(entry, run, hypothesis)
            if entry.relative:
                said = said - said[0]
            if self.channels.driven:
                said = smoothed(run.time, said, self.channels.compared_cutoff)
            found[entry.name] = Signal(run.time, said[:, None], (entry.name,), "1", entry.place)
        return found

    def altered(self, effects: Hypothesis, signals: Mapping[str, Signal]) -> dict[str, Signal]:
        found = dict(signals)
        for effect in effects:
            if isinstance(effect, ChannelEffect):
                signal = found[effect.name]
                values = effect.read(signal.time, signal.values[:, 0])[:, None]
                found[effect.name] = Signal(signal.time, values, signal.channels, signal.unit, signal.frame)
        return found

    def group(self, signal: str, values: Signal, column: int) -> str:
        return signal

    def place(self, group: str) -> tuple[str, str, str]:
        entry = self.entries[group]
        vector = entry.sensor and self.spec.sensor(entry.sensor).get_data_size() == 3
        return entry.what, entry.place, "xyz"[entry.component] if vector else ""

    def place_name(self, sensor: str, link: str) -> str:
        return f"{sensor}, {link}"

    def group_name(self, group: str) -> str:
        return group

    def motion(self, log: Recording, time: Array) -> Array:
        begin = self.clock(log)[0]
        joints = [log[name] for name in self._motions(log)]
        if not joints:
            return np.zeros((len(time), 1))
        return np.stack([np.interp(time, s.time - begin, s.values[:, 0]) for s in joints], axis=1)

    def phases(self, log: Recording) -> Array:
        """Hold, move, reversal, by the measured joints."""
        time = np.arange(0, self.clock(log)[1] + self.block, self.block) + self.block / 2
        rate = np.gradient(self.motion(log, time), self.block, axis=0)
        moving = np.abs(rate) > STILL * np.maximum(np.abs(rate).max(axis=0), self.still)
        names = np.where(moving.any(axis=1), "move", "hold").astype("<U14")
        turned = np.flatnonzero((rate[:-1] * rate[1:] < 0).any(axis=1))
        for turn in turned:
            names[max(0, turn - 1) : turn + 2] = "reversal"
        return names

    def next_experiment(self, explanations: Sequence[Hypothesis], done: Sequence[str]) -> str | None:
        """In words, by the library's own advice: there is no catalogue of experiments for any machine."""
        told = {effect.told_by for explanation in explanations for effect in explanation if effect.told_by}
        return " and ".join(sorted(told)) or None

    def pushes(self, metric: Metric, residual: Array) -> tuple[ResidualForce, ...]:
        """None: channels of any machine do not tell where it is."""
        return ()

    def learns(self, time: Array, lasts: Array) -> Array:
        """Two of three windows of independence: a lone recording may have all that happens in its beginning."""
        return (time // self.window).astype(int) % 3 != 2

    def shortcut(self, probe: Effect) -> None:
        return None

    def run(self, hypothesis: Hypothesis, level: Level, log: Recording) -> Run:
        """A stretch under effects; those of compared channels are left to `altered`."""
        model = self._model(hypothesis, level)
        begin, duration = self.clock(log)
        time = model.opt.timestep * np.arange(int(np.ceil(duration / model.opt.timestep - 1e-9)) + 1)
        path, command, force = {}, {}, {}
        for entry in self.channels.role("drive"):
            values = log[entry.name].values[:, 0]
            clock = log[entry.name].time - begin
            for effect in _readings(hypothesis, entry.name):
                values = effect.true(clock, values)
            path[entry.joint] = _spline(clock, values, time)
        for entry in self.channels.role("control"):
            clock = log[entry.name].time - begin
            values = np.interp(time, clock, log[entry.name].values[:, 0])
            for motor in _commands(hypothesis, entry.actuator):
                values = motor.act(time, values)
            command[entry.actuator] = values
        for joint in self._by_hand(hypothesis):
            motion = log[f"motion/{joint}"]
            speed = np.gradient(_spline(motion.time - begin, motion.values[:, 0], time), time)
            load = sum((command[a] for a in command if self.joint_of(a) == joint), np.zeros(len(time)))
            resisting = [e.resist(speed, load) for e in _resistances(hypothesis, joint)]
            force[joint] = -np.sum(resisting, axis=0)
        start = {
            name.removeprefix("start/"): (float(signal.values[0, 0]), float(signal.values[0, 1]))
            for name, signal in log.signals.items()
            if name.startswith("start/")
        }
        start = {joint: state for joint, state in start.items() if joint not in path}
        return simulate(model, Course(time, path, command, force, start))

    def joint_of(self, actuator: str) -> str:
        """Joint that an actuator moves, "" if it moves none."""
        found = self.spec.actuator(actuator)
        return found.target if found is not None and found.trntype == mujoco.mjtTrn.mjTRN_JOINT else ""

    def corrected(self, effects: Sequence[Effect]) -> str:
        """The MJCF text with effects in it; those that MJCF does not hold stand in comments."""
        spec, others = self.spec.copy(), []
        for effect in effects:
            if isinstance(effect, SpecEffect):
                effect.edit(spec)
            else:
                others.append(f"<!-- not in the model: {effect} -->\n")
        spec.compile()
        return spec.to_xml() + "".join(others)

    def _said(self, entry: ChannelEntry, run: Run, hypothesis: Hypothesis) -> Array:
        if entry.sensor:
            sensor = self.model.sensor(entry.sensor)
            return run.sensordata[:, sensor.adr[0] + entry.component]
        if entry.joint:
            return (run.position if entry.what == "position" else run.velocity)[entry.joint]
        joint = self.joint_of(entry.actuator)
        if joint not in self.channels.driven:
            return run.force[entry.actuator]
        force = run.force[joint]
        for effect in _resistances(hypothesis, joint):
            force = force + effect.resist(run.velocity[joint], force)
        for motor in reversed(_commands(hypothesis, entry.actuator)):
            force = motor.command(run.time, force)
        return force

    @property
    def model(self) -> mujoco.MjModel:
        """Nominal, as it is simulated."""
        return self._model((), BASE)

    def _model(self, hypothesis: Hypothesis, level: Level) -> mujoco.MjModel:
        editing = tuple(e for e in hypothesis if isinstance(e, SpecEffect))
        hands = self._by_hand(hypothesis)
        key = (frozenset(editing), hands, level)
        with self._compiling:
            if key not in self._models:
                while len(self._models) >= KEPT:
                    self._models.pop(next(iter(self._models)))
                spec = self.spec.copy()
                spec.option.timestep *= level.step
                for effect in editing:
                    try:
                        effect.edit(spec)
                    except ValueError as error:
                        raise EffectError(f"{effect} cannot stand beside the other effects: {error}") from error
                try:
                    self._models[key] = drivable(spec, self.channels.driven, hands)
                except ValueError as error:
                    raise EffectError(f"{', '.join(map(str, editing))} makes no model: {error}") from error
            return self._models[key]

    def _by_hand(self, hypothesis: Hypothesis) -> tuple[str, ...]:
        """Joints that effects push by hand: those that are not driven."""
        resisted = {e.name for e in hypothesis if isinstance(e, ResistEffect)}
        return tuple(sorted(resisted - set(self.channels.driven)))

    def _compared(self, effect: ChannelEffect) -> bool:
        return self.entries[effect.name].role == "compare"

    def _motions(self, log: Recording) -> list[str]:
        drives = [entry.name for entry in self.channels.role("drive")]
        return drives + [name for name in log.signals if name.startswith("motion/")]


def _readings(hypothesis: Hypothesis, channel: str) -> list[ChannelEffect]:
    return [e for e in hypothesis if isinstance(e, ChannelEffect) and e.name == channel]


def _commands(hypothesis: Hypothesis, actuator: str) -> list[CommandEffect]:
    return [e for e in hypothesis if isinstance(e, CommandEffect) and e.name == actuator]


def _resistances(hypothesis: Hypothesis, joint: str) -> list[ResistEffect]:
    return [e for e in hypothesis if isinstance(e, ResistEffect) and e.name == joint]


def _spline(time: Array, values: Array, at: Array) -> Array:
    """Smooth values between samples, and up to a step beyond: a cubic spline, whose second derivative does not jump."""
    from scipy.interpolate import CubicSpline

    return CubicSpline(time, values)(at)
