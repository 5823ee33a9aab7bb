"""The boom as a system: its logged joint angles drive the model, its other sensors are compared."""

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from threading import Lock
from typing import Any

import numpy as np

from boom_mj.effects import (
    BOOM_SITES,
    AngleEffect,
    Effect,
    ForceEffect,
    MachineEffect,
    ModelEffect,
    Site,
    effects_of,
)
from boom_mj.errors import SimulationError
from boom_mj.estimation.dataset import Dataset
from boom_mj.machine import Machine
from boom_mj.mjcf import BoomModel, build
from boom_mj.recording import Recording, Signal, sample
from boom_mj.sensors import apply_sensor_effects, driving_angles, ideal_signals, noise_levels, true_angles
from boom_mj.simulation import Plant, Trajectory, run, step_times
from boom_mj.simulation.plant import with_effects
from boom_mj.systems.boom import design, residual_force
from boom_mj.systems.boom.channels import channel_place
from boom_mj.systems.boom.corrected import with_effects_text
from boom_mj.systems.boom.nuisances import OFFSET, OFFSET_STEP, individual, nuisances
from boom_mj.systems.boom.timeline import DRIVE, MOVING, PHASES, timeline
from boom_mj.systems.fidelity import FidelityLadder, Level, Refinement
from boom_mj.systems.system import (
    NO_REASONS,
    ChannelPlace,
    Hypothesis,
    Nuisance,
    Reasons,
    ResidualForce,
    SystemFacts,
    Timeline,
    Wording,
)

Array = np.ndarray
ROUGH = COARSE = Level(2.0, 2)  # flanks of play diverge at steps of 20 ms
MIDDLE, FINE, SHARP = Level(2.0, 3), Level(2.0, 4), Level(1.0, 3)  # more hinges, half the step: of first order in it
SHOWN = Level(1.0, 4)  # nearest to what both checks add up to, and what `replay --hinges 4` simulates
FIDELITY = FidelityLadder(
    ROUGH,
    COARSE,
    MIDDLE,
    (Refinement((FINE,), (1.0,), (1.0,)), Refinement((SHARP,), (2.0,), (1.0,))),
    SHOWN,
    along=0.5,
    simplest=Level(1.0, 1),
)
BLOCK_S, CORRELATION_S = 0.1, 5.0
BANDS_HZ = (("static", 0.2), ("first mode", 0.8), ("second mode", 2.5), ("above", np.inf))
MAX_CAUSES = 2  # unless asked otherwise
FIRST = 0.6  # of a recording, where none is held out
HALVINGS = 2  # of the step of a motion that diverges
KEPT = 24  # models, and compiled ones


class BoomSystem:
    """A boom.

    Args:
        machine: nominal.
        text: of its file, where a corrected one shall be written.
    """

    def __init__(self, machine: Machine, text: str = "") -> None:
        self.machine, self.text = machine, text
        self.levels = noise_levels(machine)
        self.facts = SystemFacts(
            kind="boom",
            name=machine.name,
            block_s=BLOCK_S,
            correlation_s=CORRELATION_S,
            bands_hz=BANDS_HZ,
            fidelity=FIDELITY,
            noise={name: np.asarray(level) for name, level in self.levels.items() if name != DRIVE},
            still=MOVING,
            max_causes=MAX_CAUSES,
            wording=Wording(
                phases=PHASES,
                first_part=f"the first {FIRST:.0%}",
                finer="more hinges",
                zero_offset=OFFSET,
                simplest="one hinge per elastic coordinate, as `simulate` makes it without --hinges 4,",
                frames="Accelerometers and gyroscopes: x along the link, y up, z to the side. Markers: world, z up.",
            ),
            split=lambda time, lasts: time < FIRST * lasts,
            oscillatory=True,
            line_signal="imu/link5/specific_force",
            provenance={"hinges": {"predictions": MIDDLE.hinges, "check": FINE.hinges}},
        )
        self._booms: dict[tuple[Machine, Level], BoomModel] = {}
        self._plants: dict[tuple, Plant] = {}
        self._driven: dict[tuple[int, int], tuple[Recording, Array, Array]] = {}
        self._compiling = Lock()

    def sites(self) -> tuple[Site, ...]:
        return BOOM_SITES

    def nuisances(self) -> tuple[Nuisance, ...]:
        return nuisances()

    def individual(self) -> tuple[Nuisance, ...]:
        """Nuisances as wide as booms are built apart."""
        return tuple(individual())

    def timeline(self, log: Recording) -> Timeline:
        return timeline(log, float(self.levels[DRIVE][0]), BLOCK_S)

    def simulate(self, hypothesis: Hypothesis, level: Level, log: Recording) -> dict[str, Signal]:
        return ideal_signals(self.run(hypothesis, level, log))

    def observe(self, hypothesis: Hypothesis, dense: Mapping[str, Signal]) -> dict[str, Signal]:
        return apply_sensor_effects(hypothesis, dict(dense), self.machine)

    def channel(self, signal: str, column: int) -> ChannelPlace:
        return channel_place(signal, column)

    def next_experiment(self, rivals: Sequence[Hypothesis], done: Sequence[str]) -> str | None:
        """Of the catalogue."""
        return design.next_experiment(self.machine, rivals, done)

    def forces(self, data: Dataset, white: Array, weight: Array) -> tuple[ResidualForce, ...]:
        """On the elastic coordinates, by the markers, and of the cylinders."""
        poses = [self.timeline(log).coordinates for log in data.recordings]
        return residual_force.forces(self.machine, data, poses, white, weight)

    def corrected(self, causes: Hypothesis, nuisances: Hypothesis = (), reasons: Reasons = NO_REASONS) -> str:
        """The machine file's text with effects in it."""
        note = f"\n\n# found with {SHOWN.hinges} hinges: simulate and replay with --hinges {SHOWN.hinges}"
        return with_effects_text(self.text.rstrip() + note * bool(causes or nuisances), causes, nuisances, reasons)

    def column(self, effect: Effect, data: Dataset, nuisances: Array) -> Array | None:
        """An angle error moves the boom as a zero offset of its size at that moment would."""
        if not isinstance(effect, AngleEffect):
            return None
        column, joint = np.zeros(len(nuisances)), int(effect.location["joint"]) - 1
        deviation = self.nuisances()[joint].deviation
        for index, log in enumerate(data.recordings):
            joints, rows, (moments, number) = log[DRIVE], data.rows(index), data.moments_of[index]
            error = effect.error(joints.values[:, joint])
            at = np.interp(moments + joints.time[0], joints.time, error)[number]
            column[rows] = nuisances[rows, joint] / deviation * at / OFFSET_STEP
        return column

    def run(self, hypothesis: Hypothesis, level: Level, log: Recording) -> Trajectory:
        """The motion of a recording under effects."""
        machine = self.machine
        for effect in hypothesis:
            if isinstance(effect, MachineEffect):
                machine = effect.change(machine)
        hypothesis = (*effects_of(machine), *hypothesis)
        plant = self._plant(machine, hypothesis, level)
        for _ in range(HALVINGS):
            try:
                return self._run(plant, log)
            except SimulationError:  # what is stable stretched need not be so elsewhere
                plant = replace(plant, model=copy(plant.model))
                plant.model.opt.timestep /= 2
        return self._run(plant, log)

    def _run(self, plant: Plant, log: Recording) -> Trajectory:
        """At the model's own step.

        Raises:
            EquilibriumError, SimulationError: the machine has no such motion.
        """
        joints = log[DRIVE]
        steps = step_times(plant, float(joints.time[-1] - joints.time[0]))
        reading, force = self._inputs(steps, log)
        angles = true_angles(plant.effects, reading)  # a constant may as well be taken out afterwards
        sensed = [e for e in plant.effects if isinstance(e, AngleEffect) and e.id != OFFSET]
        if bent := sorted({int(effect.location["joint"]) - 1 for effect in sensed}):
            at = steps + joints.time[0]
            angles[:, bent] = driving_angles(log, self.levels[DRIVE][0], at, plant.effects, bent)
        return run(plant, angles, force)

    def _plant(self, machine: Machine, hypothesis: Hypothesis, level: Level) -> Plant:
        """The compiled model of a hypothesis; the last few are kept, for its other recordings."""
        mechanical = tuple(effect for effect in hypothesis if isinstance(effect, ModelEffect | ForceEffect))
        made, key = (machine, level), (machine, level, frozenset(mechanical))
        with self._compiling:
            if made not in self._booms:
                _make_room(self._booms)
                self._booms[made] = build(machine, level.hinges, drawn=False)
                self._booms[made].spec.option.timestep *= level.step
            if key not in self._plants:
                _make_room(self._plants)
                self._plants[key] = plant = with_effects(self._booms[made], mechanical)
                while not plant.stable(np.zeros(plant.model.nq)):
                    plant.model.opt.timestep /= 2
            plant = self._plants[key]
        return Plant(plant.boom, plant.model, hypothesis)  # its scratch is its own

    def _inputs(self, steps: Array, log: Recording) -> tuple[Array, Array]:
        """Smooth joint readings and the known load at the steps of the simulation."""
        key = (id(log), len(steps))  # the log is kept, so that no other gets its id
        if key not in self._driven:
            start = log[DRIVE].time[0]
            angles = driving_angles(log, self.levels[DRIVE][0], steps + start)
            force = sample(log["load"], steps + start) if "load" in log else np.zeros((len(steps), 3))
            self._driven[key] = (log, angles, force)
        return self._driven[key][1:]


def _make_room(cache: dict[Any, Any]) -> None:
    while len(cache) >= KEPT:
        cache.pop(next(iter(cache)))
