"""A machine of algebra, diagnosed within a second: what its two sensors say is a sum of shapes in time.

The logged angle u(t) drives it; the first sensor says u, the second its rate. A cause adds its shape to one of them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from boom_mj.diagnosis import Diagnosis, diagnose
from boom_mj.diagnosis.linearisation import Linearisation, linearise
from boom_mj.effects import Effect, Parameter, Site
from boom_mj.errors import SimulationError
from boom_mj.recording import Recording, Signal
from boom_mj.systems.fidelity import FidelityLadder, Level, Refinement
from boom_mj.systems.predictor import Predictor, dataset_of
from boom_mj.systems.system import ChannelPlace, Hypothesis, Nuisance, SystemFacts, Timeline, Wording

Array = np.ndarray
NOISE, BLOCK_S, CORRELATION_S, LASTS_S = 0.01, 0.1, 1.0, 120.0
SAID = 1.02 * NOISE  # by the machine file: so many samples scatter by a hundredth
ROUGH, MIDDLE, FINE = Level(4.0), Level(2.0), Level(1.0)
SITES = (Site((("sensor", 1),), frozenset({"algebra"})), Site((("sensor", 2),), frozenset({"algebra"})))
TIME = np.arange(0.0, LASTS_S, 0.02)
STRETCH_S = 20.0  # after which a motion repeats


class Term(Effect):
    """A sensor says `size` times a shape more."""

    id = "term"
    at = ("sensor",)
    needs = frozenset({"algebra"})
    table = {"size": Parameter("1", 0.0, -5.0, 5.0, 0.05)}

    @property
    def sensors(self) -> tuple[int, ...]:
        """Numbers of those that say it."""
        return (int(self.location["sensor"]),)

    def shape(self, time: Array, angle: Array) -> Array:
        """(n,) of an angle (n,) at times."""
        raise NotImplementedError

    def adds(self, time: Array, angle: Array) -> Array:
        return self.values["size"] * self.shape(time, angle)


class Offset(Term):
    """What every log has."""

    id = "offset"
    competes = False

    def shape(self, time: Array, angle: Array) -> Array:
        return np.ones_like(time)


class Square(Term):
    id = "square"

    def shape(self, time: Array, angle: Array) -> Array:
        return angle**2


class Cube(Term):
    id = "cube"

    def shape(self, time: Array, angle: Array) -> Array:
        return angle**3


class Ramp(Term):
    id = "ramp"

    def shape(self, time: Array, angle: Array) -> Array:
        return time / LASTS_S


class Hum(Term):
    id = "hum"

    def shape(self, time: Array, angle: Array) -> Array:
        return np.sin(2 * np.pi * 0.9 * time)


class Common(Term):
    """What all sensors say alike."""

    id = "common"

    def shape(self, time: Array, angle: Array) -> Array:
        return np.cos(0.7 * time)

    @property
    def sensors(self) -> tuple[int, ...]:
        return 1, 2, 3


class Likeness(Term):
    """Almost a square."""

    id = "likeness"

    def shape(self, time: Array, angle: Array) -> Array:
        return angle**2 * (1 + 1e-3 * np.sin(time))


class Late(Term):
    """An echo of the angle: not linear in its size, and bounded on one side."""

    id = "late"
    table = {"size": Parameter("s", 0.0, 0.0, 2.0, 0.1)}

    def adds(self, time: Array, angle: Array) -> Array:
        return np.interp(time - self.values["size"], time, angle) - angle


class Broken(Term):
    """No machine with it moves."""

    id = "broken"

    def adds(self, time: Array, angle: Array) -> Array:
        if self.values["size"]:
            raise SimulationError("it does not move")
        return np.zeros_like(time)


class Gust(Term):
    """A step that a latent input may follow."""

    id = "gust"

    def shape(self, time: Array, angle: Array) -> Array:
        return (time > LASTS_S / 2).astype(float)

    def basis(self, time_s: float) -> "Gust":
        return self


class Tone(Term):
    """A tone of a pitch: a fit stays near the pitch where it begins. The last that screening tries is too high."""

    id = "tone"
    table = {"size": Parameter("Hz", 0.0, 0.0, 5.0, 0.5)}

    def adds(self, time: Array, angle: Array) -> Array:
        if self.values["size"] > 1.4:
            raise SimulationError("it does not move")
        return 0.02 * np.sin(2 * np.pi * self.values["size"] * time)

    @classmethod
    def screening(cls, site: Site, lines_hz: Sequence[float] = ()) -> list[list[dict[str, float]]]:
        return [[{"size": 0.35}], [{"size": 0.8}], [{"size": 1.5}]]

    @classmethod
    def combine(cls, site: Site, points: Sequence[Mapping[str, float]], weights: Array) -> dict[str, float]:
        return dict(points[0])


LIBRARY: Mapping[str, type[Effect]] = {
    kind.id: kind for kind in (Offset, Square, Cube, Ramp, Hum, Common, Likeness, Late, Broken, Gust)
}


def term(kind: type[Effect], sensor: int, size: float) -> Effect:
    return kind(SITES[sensor - 1], size=size)


class Algebra:
    """The machine, of seven members.

    Args:
        kind: by whose criteria it is diagnosed.
        oscillatory: whether it is said to vibrate.
        coarseness: error of a simulation per step of its level.
        third: whether a third sensor says half the angle, whatever the cause.
    """

    def __init__(
        self, kind: str = "boom", oscillatory: bool = True, coarseness: float = 0.0, third: bool = False
    ) -> None:
        self.coarseness = coarseness
        self.sensors = ("first", "second", "third")[: 3 if third else 2]
        self.facts = SystemFacts(
            kind=kind,
            name="algebra",
            block_s=BLOCK_S,
            correlation_s=CORRELATION_S,
            bands_hz=(("static", 0.2), ("above", np.inf)),
            fidelity=FidelityLadder(ROUGH, ROUGH, MIDDLE, (Refinement((FINE,), (2.0,), (1.0,)),), FINE),
            noise={name: np.array([SAID]) for name in self.sensors},
            still=0.01,
            max_causes=2,
            wording=Wording(("rest", "motion"), "the first 60%", "finer steps", "offset"),
            split=lambda time, lasts: time < 0.6 * lasts,
            oscillatory=oscillatory,
        )

    def sites(self) -> tuple[Site, ...]:
        return SITES

    def nuisances(self) -> tuple[Nuisance, ...]:
        return tuple(Nuisance((term(Offset, sensor, 0.01),), 3.0) for sensor in (1, 2))

    def timeline(self, log: Recording) -> Timeline:
        angle = log["angle"]
        blocks = int(LASTS_S / BLOCK_S)
        return Timeline(
            0.0,
            float(angle.time[-1]),
            lambda time: np.interp(time, angle.time, angle.values[:, 0])[:, None],
            lambda: np.full(blocks, "motion"),
        )

    def simulate(self, hypothesis: Hypothesis, level: Level, log: Recording) -> dict[str, Signal]:
        angle = log["angle"].values[:, 0]
        said = {1: angle + self.coarseness * level.step * np.cos(angle), 2: np.gradient(angle, TIME), 3: angle / 2}
        for effect in hypothesis:
            assert isinstance(effect, Term)
            for sensor in effect.sensors:
                said[sensor] += effect.adds(TIME, angle)
        return {name: _signal(said[sensor], name) for sensor, name in enumerate(self.sensors, 1)}

    def observe(self, hypothesis: Hypothesis, dense: Mapping[str, Signal]) -> dict[str, Signal]:
        return dict(dense)

    def channel(self, signal: str, column: int) -> ChannelPlace:
        return ChannelPlace(signal, "sensor", signal, "", signal, signal, signal)


def recorded(
    effects: Hypothesis, angle: Callable[[Array], Array], seed: int, coarseness: float = 0.0, third: bool = False
) -> Recording:
    """What a machine with effects would log of an angle in time, with noise."""
    log = Recording(f"log {seed}", "algebra", "", {"angle": _signal(angle(TIME), "angle")})
    plant, noise = Algebra(coarseness=coarseness, third=third), np.random.default_rng(seed)
    said = plant.simulate(effects, Level(0.0), log)
    noisy = {n: replace(s, values=s.values + NOISE * noise.standard_normal(s.values.shape)) for n, s in said.items()}
    return log.with_signals(noisy)


def swing(time: Array) -> Array:
    """An angle with one slow and one faster part."""
    return np.sin(0.7 * time) + 0.5 * np.sin(1.9 * time)


def sweep(time: Array) -> Array:
    """An angle that quickens."""
    time = time % STRETCH_S
    return np.sin(0.4 * time + 0.05 * time**2)


def lull(time: Array) -> Array:
    """A swing a third as wide."""
    return swing(time) / 3


def rest(time: Array) -> Array:
    """No angle at all."""
    return np.zeros_like(time)


def predictor(
    effects: Hypothesis,
    motions: Sequence[Callable[[Array], Array]] = (swing, sweep),
    training: int = 1,
    spoilt: Callable[[Recording], Recording] = lambda log: log,
    **facts,
) -> Predictor:
    """Of recordings of a machine with effects, the first of them for training."""
    system = Algebra(**facts)
    third = len(system.sensors) > 2
    logs = [spoilt(recorded(effects, motion, seed, system.coarseness, third)) for seed, motion in enumerate(motions)]
    return Predictor(system, dataset_of(system, logs, training), threads=1)


def model(effects: Hypothesis, **facts) -> Linearisation:
    return linearise(predictor(effects, **facts))


def _signal(values: Array, name: str) -> Signal:
    return Signal(TIME, values[:, None], (name,), "1", "")


SQUARE, HUM, RAMP, LATE = term(Square, 1, 0.05), term(Hum, 2, 0.05), term(Ramp, 2, -0.1), term(Late, 1, 0.3)
WEAK, WEAKER = term(Hum, 2, 0.003), term(Ramp, 2, -0.002)


def found(*effects: Effect, without: tuple[str, ...] = (), most: int | None = None, **machine) -> Diagnosis:
    return diagnose(predictor(effects, **machine), without, most=most)


def causes(answer: Diagnosis) -> set:
    assert answer.best is not None
    return {effect.cause for effect in answer.best.fit.effects}


def off(answer: Diagnosis, true: Effect) -> float:
    """By how many of its standard deviations the size of a cause is off."""
    assert answer.best is not None
    (k,) = [k for k, effect in enumerate(answer.best.fit.effects) if effect.cause == true.cause]
    scale = true.declared["size"].typical
    return (answer.best.fit.effects[k].values["size"] - true.values["size"]) / scale / answer.best.deviation[k]
