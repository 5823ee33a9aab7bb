"""The boom as a subject of diagnosis: its logged joint angles drive the model, its other sensors are compared."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from threading import Lock
from typing import TYPE_CHECKING, Any

import numpy as np

from boom_mj.effects import AngleEffect, Effect, SignalEffect, effect_library, effects_of, make_effect
from boom_mj.machine import Machine
from boom_mj.mjcf import BoomModel, build
from boom_mj.recording import Recording, Signal
from boom_mj.sensors import apply_sensor_effects, driving_angles, ideal_signals, noise_levels, sample, true_angles
from boom_mj.sensors.blocks import BLOCK, group_of
from boom_mj.simulation import Plant, run, step_times
from boom_mj.simulation.plant import with_effects
from boom_mj.systems.boom.design import next_experiment
from boom_mj.systems.boom.residual_force import pushes
from boom_mj.systems.system import FidelityLadder, Hypothesis, Level, Nuisance, Refinement, ResidualForce, System, Words

if TYPE_CHECKING:
    from boom_mj.diagnosis.linearisation import Metric

Array = np.ndarray
ROUGH = COARSE = Level(4.0, 2)
MIDDLE, FINE, SHARP = Level(2.0, 3), Level(2.0, 4), Level(1.0, 3)  # more hinges, half the step: of first order in it
KEPT = 24  # compiled plants
STIFFNESS = {"v": 0.005, "w": 0.005, "torsion": 0.01}  # of all links
PLATES = 0.003  # of the stiffness of a single link
MASS, DAMPING = 0.003, 0.05  # of a link, of all of them
CHANGE = 0.002  # of those, for derivatives: one of 0.01 turns a vibration by half a radian until a recording ends
GAIN = 0.002  # of a pressure sensor
VISCOUS = 0.5  # of the machine file's, that may be missing or too much
ZERO_OFFSET, OFFSET_STEP = np.radians(0.6), 0.0005  # rad: prior of a joint's zero offset, step of its secant
NUISANCE = "joint_zero_offset"  # never a cause
MOVING = 1e-3  # rad/s
SHORT = 1.0  # s, of a start and around a reversal
AFTER = 12.0  # s, how long a stop is remembered
DRIVE = "joint/position"
LEARNT = 0.6  # of a recording, where none is held out


def tolerances() -> tuple[Nuisance, ...]:
    """What differs between healthy booms, all of it small."""
    found = [
        Nuisance((make_effect(NUISANCE, {f"joint{k}": OFFSET_STEP}),), ZERO_OFFSET / OFFSET_STEP) for k in range(1, 6)
    ]
    for number in (2, 3):
        slippery = make_effect("viscous_friction", {"joint": number, "factor": 0.0})
        found.append(Nuisance((slippery,), VISCOUS, still=True))
    for number in (2, 3):
        reading = make_effect("pressure_scale", {"cylinder": number, "factor": 1 + CHANGE})
        found.append(Nuisance((reading,), GAIN / CHANGE, still=True))
    for axis, deviation in STIFFNESS.items():
        softer = [make_effect("link_stiffness", {"link": k, "axis": axis, "factor": 1 - CHANGE}) for k in (2, 3, 4, 5)]
        found.append(Nuisance(tuple(softer), deviation / CHANGE))
    for link in (2, 3, 4, 5):
        places = [{"link": link, "axis": axis} for axis in STIFFNESS]
        thinner = [make_effect("link_stiffness", {**place, "factor": 1 - CHANGE}) for place in places]
        found.append(Nuisance(tuple(thinner), PLATES / CHANGE))
        found.append(Nuisance((make_effect("link_mass", {"link": link, "factor": 1 + CHANGE}),), MASS / CHANGE))
    damped = make_effect("structural_damping", {"factor": 1 + CHANGE})
    return (*found, Nuisance((damped,), DAMPING / CHANGE))


class BoomSystem(System):
    """A boom and the effects of `effects/library/`.

    Args:
        machine: nominal.
    """

    block, window, still = BLOCK, 5.0, MOVING
    bands = (("static", 0.2), ("first mode", 0.8), ("second mode", 2.5), ("above", np.inf))
    fidelity = FidelityLadder(
        ROUGH, COARSE, MIDDLE, (Refinement(FINE, 1.0, 1.0), Refinement(SHARP, 2.0, 1.0)), SHARP, alike=0.5
    )
    causes, slack, worth, spill = 2, 0.005, 0.5, 0.01
    hides = 1.01  # right ones leave 0.95 to 1.00
    words = Words(
        phases=("hold", "start", "move", "slew", "reversal", "after motion", "after release"),
        learnt=f"the first {LEARNT:.0%}",
        finer="more hinges",
        zero=NUISANCE,
        frames="Accelerometers and gyroscopes: x along the link, y up, z to the side. Markers: world, z up.",
    )
    swings = True
    listening = "imu/link5/specific_force"

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.levels = noise_levels(machine)
        self._booms: dict[Level, BoomModel] = {}
        self._plants: dict[tuple, Plant] = {}
        self._driven: dict[tuple[int, int], tuple[Array, Array]] = {}
        self._compiling = Lock()

    @property
    def name(self) -> str:
        return self.machine.name

    @property
    def provenance(self) -> Mapping[str, Any]:
        return {"hinges": {"contest": MIDDLE.hinges, "fidelity": FINE.hinges}}

    def library(self) -> list[tuple[type[Effect], dict]]:
        kinds = (kind for kind in effect_library().values() if kind.id != NUISANCE)
        return [(kind, place) for kind in kinds for place in kind.locations()]

    def tolerances(self) -> tuple[Nuisance, ...]:
        return tolerances()

    def noise(self) -> Mapping[str, Array]:
        """All that have noise but the joint angles, which drive the model."""
        return {name: np.asarray(level) for name, level in self.levels.items() if name != DRIVE}

    def clock(self, log: Recording) -> tuple[float, float]:
        time = log[DRIVE].time
        return time[0], float(time[-1] - time[0])

    def split(self, hypothesis: Hypothesis) -> tuple[Hypothesis, Hypothesis]:
        sensing = tuple(e for e in hypothesis if isinstance(e, SignalEffect))
        return tuple(e for e in hypothesis if not isinstance(e, SignalEffect)), sensing

    def simulate(self, hypothesis: Hypothesis, level: Level, index: int, log: Recording) -> dict[str, Signal]:
        hypothesis = (*effects_of(self.machine), *hypothesis)
        plant = self._plant(hypothesis, level)
        steps = step_times(plant, self.clock(log)[1])
        reading, force = self._inputs(index, steps, log)
        angle_errors = [e for e in hypothesis if isinstance(e, AngleEffect)]
        return ideal_signals(run(plant, true_angles(angle_errors, reading), force))

    def altered(self, effects: Hypothesis, signals: Mapping[str, Signal]) -> dict[str, Signal]:
        return apply_sensor_effects([e for e in effects if isinstance(e, SignalEffect)], dict(signals), self.machine)

    def group(self, signal: str, values: Signal, column: int) -> str:
        return group_of(signal, values, column)

    def place(self, group: str) -> tuple[str, str, str]:
        return sensor_place(group)

    def place_name(self, sensor: str, link: str) -> str:
        return f"cylinder {link[-1]}" if sensor == "cylinder" else f"{sensor}, link {link[-1]}"

    def group_name(self, group: str) -> str:
        sensor, link, direction = sensor_place(group)
        return f"{self.place_name(sensor, link)}, {direction}"

    def motion(self, log: Recording, time: Array) -> Array:
        joints = log[DRIVE]
        return np.stack([np.interp(time, joints.time - joints.time[0], column) for column in joints.values.T], axis=1)

    def phases(self, log: Recording) -> Array:
        """Hold, start, slew, move, reversal, after motion, after release."""
        start, duration = self.clock(log)
        time = np.arange(0, duration + BLOCK, BLOCK) + BLOCK / 2
        angles = driving_angles(log, self.levels[DRIVE][0], time + start)
        rate = np.gradient(angles, BLOCK, axis=0)
        moving = np.abs(rate) > MOVING
        names = np.full(len(time), "hold", dtype="<U14")
        load = sample(log["load"], time + start) if "load" in log else np.zeros((len(time), 3))
        dropped = np.flatnonzero(np.linalg.norm(np.diff(load, axis=0), axis=1) > 1.0)
        if dropped.size:
            names[dropped[0] :] = "after release"
        any_moving = moving.any(axis=1)
        for stop in np.flatnonzero(any_moving[:-1] & ~any_moving[1:]):
            names[stop : stop + int(AFTER / BLOCK)] = "after motion"
        names[any_moving] = np.where(moving[any_moving, 0], "slew", "move")
        for begin in np.flatnonzero(~any_moving[:-1] & any_moving[1:]):
            names[begin : begin + int(SHORT / BLOCK)] = "start"
        turned = np.flatnonzero((rate[:-1] * rate[1:] < 0).any(axis=1) & any_moving[1:])
        for turn in turned:
            names[max(0, turn - int(SHORT / BLOCK / 2)) : turn + int(SHORT / BLOCK / 2)] = "reversal"
        return names

    def next_experiment(self, explanations: Sequence[Hypothesis], done: Sequence[str]) -> str | None:
        return next_experiment(self.machine, explanations, done)

    def pushes(self, metric: "Metric", residual: Array) -> tuple[ResidualForce, ...]:
        return pushes(self.machine, metric, residual)

    def learns(self, time: Array, lasts: Array) -> Array:
        return time < LEARNT * lasts

    def shortcut(self, probe: Effect) -> Callable[["Metric"], Array] | None:
        return partial(_moved_by, probe) if isinstance(probe, AngleEffect) else None

    def _plant(self, hypothesis: Hypothesis, level: Level) -> Plant:
        """The compiled model of a hypothesis; the last few are kept, for its other recordings."""
        key = (frozenset(hypothesis), level)
        with self._compiling:
            if level not in self._booms:
                self._booms[level] = build(self.machine, level.hinges)
                self._booms[level].spec.option.timestep *= level.step
            if key not in self._plants:
                while len(self._plants) >= KEPT:
                    self._plants.pop(next(iter(self._plants)))
                self._plants[key] = plant = with_effects(self._booms[level], hypothesis)
                while not plant.stable(np.zeros(plant.model.nq)):
                    plant.model.opt.timestep /= 2
            plant = self._plants[key]
        return Plant(plant.boom, plant.model, plant.effects)  # its scratch is its own

    def _inputs(self, index: int, steps: Array, log: Recording) -> tuple[Array, Array]:
        """Smooth joint readings and the known load at the steps of the simulation."""
        key = (index, len(steps))
        if key not in self._driven:
            start = log[DRIVE].time[0]
            angles = driving_angles(log, self.levels[DRIVE][0], steps + start)
            force = sample(log["load"], steps + start) if "load" in log else np.zeros((len(steps), 3))
            self._driven[key] = (angles, force)
        return self._driven[key]


def sensor_place(group: str) -> tuple[str, str, str]:
    """Sensor, link and direction of a boom's channel group."""
    if group.startswith("imu/"):
        _, link, kind, direction = group.split("/")
        return {"specific_force": "accelerometer", "angular_rate": "gyroscope"}[kind], link, direction
    if group.startswith("markers/"):
        _, link, direction = group.split("/")
        return "marker", link, direction
    return "cylinder", "link" + group[-1], "force"


def _moved_by(error: AngleEffect, metric: "Metric") -> Array:
    """The whitened column of an error, (N,): it moves the boom as a zero offset of its size at that moment would."""
    campaign, column = metric.campaign, np.zeros(len(metric.base))
    for index, log in enumerate(campaign.recordings):
        joints, rows = log[DRIVE], campaign.recording_of == index
        errors = error.error(joints.values)
        for joint in np.flatnonzero(np.abs(errors).max(axis=0)):
            at = np.interp(campaign.time[rows] + joints.time[0], joints.time, errors[:, joint])
            deviation = metric.nuisances[joint].deviation
            column[rows] += metric.columns[rows, joint] / deviation * at / OFFSET_STEP
    return metric.white(column)
