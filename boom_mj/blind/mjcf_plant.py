"""The machine of an MJCF case: another model than that of the diagnosis, and how its motions are recorded.

Servos follow references where the model is made to follow the measured motion, gears give where the model's do not,
another integrator takes shorter steps, sensors have noise, filters and a resolution (`plant_file`). Forces that effects
exert follow from the plant's own motion, those of `ResistEffect` too, which a diagnosis takes from the measured one.
"""

from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np

from boom_mj.blind.plant_file import LEAD, Motion, PlantFile, Reference, Sensor
from boom_mj.effects import ActuatorEffect, Effect, ForceEffect, InputEffect, ModelEffect, OutputEffect, is_output
from boom_mj.errors import EffectError, SimulationError
from boom_mj.recording import Recording, Signal
from boom_mj.systems.mjcf.channel_map import ChannelEntry, ChannelMap
from boom_mj.systems.mjcf.readout import inputs_of, pushed, said
from boom_mj.systems.mjcf.rollout import Run, drivable, joint_of, simulate

Array = np.ndarray
ASKED = "reference "  # of a servo, before the channel that it moves


class MjcfPlant:
    """A machine with effects, on the bench.

    Args:
        spec: the nominal model.
        effects: at places of the nominal machine.
    """

    def __init__(self, spec: mujoco.MjSpec, channels: ChannelMap, plant: PlantFile, effects: Sequence[Effect]) -> None:
        self.nominal, self.plant = channels, plant
        self.spec = spec.copy()
        self.spec.option.timestep *= plant.step
        self.spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{plant.integrator.upper()}")
        self.motors = {entry.joint: self._servo(entry.joint) for entry in channels.role("drive")}
        self.effects = tuple(map(_by_its_own_motion, effects))
        self.channels = ChannelMap(
            name=channels.name,
            time=channels.time,
            channel=tuple(e for entry in channels.channel for e in self._entries(entry)),
        )
        servos = self.motors.values()
        self.between = tuple(e for e in effects if isinstance(e, ActuatorEffect) and e.location["actuator"] in servos)
        beside = [e for e in self.effects if is_output(e) or _drives(e) or e in self.between]
        self.simulated = tuple(e for e in self.effects if e not in beside)
        edited = self.spec.copy()
        try:
            for effect in self.simulated:
                if isinstance(effect, ModelEffect):
                    effect.edit(edited, None)
            self.model = drivable(edited, (), pushed(self.simulated, self.channels))
        except ValueError as error:
            raise EffectError(f"{', '.join(map(str, effects))} makes no machine: {error}") from error

    def _servo(self, joint: str) -> str:
        """Make a servo of a driven joint's motor, or give it one; its name."""
        own = next((a for a in self.spec.actuators if joint_of(self.spec, a.name) == joint), None)
        if own is None:
            own = self.spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        gains, gear = self.plant.servo[joint], float(own.gear[0])
        own.gaintype, own.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
        own.gainprm[0], own.biasprm[:3] = gains.kp / gear, (0.0, -gains.kp / gear**2, -gains.kv / gear**2)
        return str(own.name)

    def _entries(self, entry: ChannelEntry) -> list[ChannelEntry]:
        """A channel in the plant; where the map makes a joint follow what was measured, a servo's reference, too."""
        if entry.role != "drive":
            return [] if entry.role == "temperature" else [entry.model_copy(update={"relative": False})]
        asked = ChannelEntry(name=ASKED + entry.name, role="control", actuator=self.motors[entry.joint], field="x")
        return [asked, ChannelEntry(name=entry.name, role="compare", joint=entry.joint, field="x", unit=entry.unit)]

    def record(self, motion: Motion, rng: np.random.Generator) -> dict[str, Array]:
        """A log of a motion by field of the map, (n,) each.

        Raises:
            SimulationError: it diverged.
        """
        step = self.model.opt.timestep
        time = step * np.arange(round((motion.duration + LEAD) / step) + 1)
        log = Recording(motion.name, self.channels.name, "", self._asked(motion, time))
        inputs = inputs_of(self.spec, self.channels, self.simulated, log, 0.0, time, _no_nominal)
        (run,) = simulate(self.model, [inputs])
        if isinstance(run, SimulationError):
            raise run
        read = self._read(run, log)
        rows = np.arange(round(LEAD / step), len(time), max(round(1 / (self.plant.rate * step)), 1))
        table = {self.nominal.time: (time[rows] - LEAD) / self.nominal.time_scale}
        for entry in self.nominal.channel:
            if entry.sensed:
                sensor = self.plant.sensor.get(entry.name, Sensor())
                values = sensor(read[entry.name].values[:, 0], step, rows, rng)
            else:
                values = log[entry.name].values[rows, 0]
            table[entry.field] = (values - entry.offset) / entry.scale
        return table

    def _asked(self, motion: Motion, time: Array) -> dict[str, Signal]:
        """References of what is controlled; a servo begins where its reference does."""
        asked, joints = dict[str, Signal](), {motor: joint for joint, motor in self.motors.items()}
        for entry in self.channels.role("control"):
            reference = motion.reference.get(entry.name.removeprefix(ASKED), Reference())
            values = reference(np.maximum(time - LEAD, 0))
            asked[entry.name] = Signal(time, values[:, None], (entry.name,), "1", "")
            if entry.actuator in joints:
                state = np.array([[values[0], 0.0]])
                asked[f"start/{joints[entry.actuator]}"] = Signal(time[:1], state, ("position", "velocity"), "1", "")
        return asked

    def _read(self, run: Run, log: Recording) -> dict[str, Signal]:
        """What channels read at every step, before their sensors."""
        read = {}
        for entry in self.channels.role("compare"):
            values = said(entry, run, self.model, self.spec, self.channels, (), log)
            for motor in reversed(self.between):  # a servo exerts what its log says, and effects
                values = motor.invert(run.time, values) if motor.location["actuator"] == entry.actuator else values
            read[entry.name] = Signal(run.time - LEAD, values[:, None], (entry.name,), "1", "")
        for effect in self.effects:
            if isinstance(effect, OutputEffect) and is_output(effect):
                read |= effect.observe(read, None)
            elif isinstance(effect, InputEffect) and _drives(effect):
                own = read[name := str(effect.location["channel"])]
                read[name] = replace(own, values=effect.apply(run.time, own.values[:, 0])[:, None])
        return read


def _drives(effect: Effect) -> bool:
    """Whether it stands between a joint's true motion and the reading that a diagnosis follows."""
    return isinstance(effect, InputEffect) and "driving" in effect.site.tags


def _by_its_own_motion(effect: Effect) -> Effect:
    """The same effect; what sees the measured motion sees the simulated one."""
    if not isinstance(effect, ForceEffect) or effect.sees == "simulated":
        return effect
    kind = type(effect)
    own = type(kind.__name__, (kind,), {"sees": "simulated", "remembers": False, "id": kind.id})
    return own(effect.site, **effect.values)


def _no_nominal() -> Run:
    raise AssertionError("no effect of a plant sees a nominal run")
