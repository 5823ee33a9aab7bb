"""The machine of an MJCF case: another model than that of the diagnosis, and how its motions are recorded.

NAME.plant.toml beside a channel map NAME.toml says what no data sheet does: servos that follow what they are told
instead of motion that is imposed, give where the model has none, another integrator and shorter steps, sensors with
noise, filters and resolution, and the motions of every recording. Forces that effects exert follow from the plant's own
motion, those of `ResistEffect` too, which a diagnosis takes from the measured one.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

import mujoco
import numpy as np
from pydantic import BaseModel, ConfigDict, FiniteFloat, ValidationError
from scipy.signal import butter, lfilter, sosfilt, sosfilt_zi

from boom_mj.effects import ActuatorEffect, Effect, ForceEffect, InputEffect, ModelEffect, OutputEffect, is_output
from boom_mj.errors import EffectError, InputError, SimulationError
from boom_mj.files import parse_toml
from boom_mj.machine.fields import NonNegative, Positive
from boom_mj.recording import Recording, Signal
from boom_mj.systems.mjcf.channel_map import ChannelEntry, ChannelMap
from boom_mj.systems.mjcf.readout import inputs_of, pushed, said
from boom_mj.systems.mjcf.rollout import Run, drivable, joint_of, simulate

Array = np.ndarray
LEAD = 2.0  # s at rest before a log begins, and during which a reference comes into swing
ASKED = "reference "  # channel of what a servo is told, before the name of what it moves


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Servo(_Part):
    """F = kp (reference - position) - kv speed."""

    kp: Positive
    kv: NonNegative


class Sensor(_Part):
    """What a channel's log says of the truth: y = round(filtered + noise).

    Attributes:
        noise: standard deviation of a sample, SI.
        correlation: time in which the noise forgets itself, s; 0 is white.
        cutoff: of a low-pass of second order, Hz.
        resolution: of the converter, SI.
    """

    noise: NonNegative = 0.0
    correlation: NonNegative = 0.0
    cutoff: Positive | None = None
    resolution: NonNegative = 0.0


class Reference(_Part):
    """What a channel is told: at rest in every knot (time, value), and sines (amplitude, Hz, phase) on top."""

    knots: tuple[tuple[FiniteFloat, FiniteFloat], ...] = ()
    sines: tuple[tuple[FiniteFloat, FiniteFloat, FiniteFloat], ...] = ()

    def __call__(self, time: Array) -> Array:
        value = np.zeros(len(time))
        if self.knots:
            (at, to), number = np.array(self.knots).T, np.searchsorted([t for t, _ in self.knots], time, "right")
            before, after = np.clip(number - 1, 0, None), np.clip(number, None, len(at) - 1)
            way = (time - at[before]) / np.where(after > before, at[after] - at[before], 1)
            value += to[before] + (to[after] - to[before]) * _eased(way)
        for amplitude, frequency, phase in self.sines:
            value += amplitude * (np.sin(2 * np.pi * frequency * time + phase) - np.sin(phase)) * _eased(time / LEAD)
        return value


class Motion(_Part):
    """A recording: what every channel that drives or controls is told; those left out stay at 0."""

    name: str
    part: Literal["train", "holdout"]
    duration: Positive
    reference: Mapping[str, Reference]


class PlantFile(_Part):
    """What the plant has.

    Attributes:
        rate: of the log, Hz.
        step: of the integration, in steps of the model.
        integrator: of MuJoCo.
        effects: of every machine of this kind, such as give in its gears, as `ID:key=value,...`.
        servo: by joint that the map drives.
        sensor: by channel.
    """

    rate: Positive
    step: Positive = 0.2
    integrator: Literal["Euler", "implicit", "implicitfast"] = "implicit"
    effects: tuple[str, ...] = ()
    servo: Mapping[str, Servo] = {}
    sensor: Mapping[str, Sensor] = {}
    motion: tuple[Motion, ...]


def parse_plant(text: str, source: Path | str, channels: ChannelMap) -> PlantFile:
    """A plant file, checked against the map of its machine.

    Raises:
        InputError: what is wrong, and where.
    """
    try:
        plant = PlantFile.model_validate(parse_toml(text, source, InputError))
    except ValidationError as error:
        first = error.errors()[0]
        raise InputError(f"{source}: {'.'.join(map(str, first['loc']))}: {first['msg']}") from error
    told = {entry.name for entry in channels.channel if entry.role in ("drive", "control")}
    known = {
        "servo": (set(channels.driven), set(plant.servo)),
        "sensor": ({entry.name for entry in channels.channel if entry.sensed}, set(plant.sensor)),
        "motion.reference": (told, {name for motion in plant.motion for name in motion.reference}),
    }
    for where, (there, given) in known.items():
        if wrong := sorted(given - there):
            raise InputError(f"{source}: {where} names {wrong[0]}; the map has {', '.join(sorted(there)) or 'none'}")
    if missing := sorted(set(channels.driven) - set(plant.servo)):
        raise InputError(f"{source}: joint {missing[0]} is driven, but has no [servo.{missing[0]}]")
    if {motion.part for motion in plant.motion} != {"train", "holdout"}:
        raise InputError(f"{source}: there must be a motion for train, and one for holdout")
    return plant


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
        at_servos = [e for e in effects if isinstance(e, ActuatorEffect) and e.location["actuator"] in self._servos]
        self.between = tuple(at_servos)  # a servo's motor and what is logged of it
        self.simulated = tuple(e for e in self.effects if not is_output(e) and e not in at_servos and not _drives(e))
        edited = self.spec.copy()
        try:
            for effect in self.simulated:
                if isinstance(effect, ModelEffect):
                    effect.edit(edited, None)
            self.model = drivable(edited, (), pushed(self.simulated, self.channels))
        except ValueError as error:
            raise EffectError(f"{', '.join(map(str, effects))} makes no machine: {error}") from error

    @property
    def _servos(self) -> set[str]:
        return set(self.motors.values())

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
        """What is told and what is read in the plant, where the map may impose a motion."""
        if entry.role != "drive":
            return [] if entry.role == "temperature" else [entry.model_copy(update={"relative": False})]
        told = ChannelEntry(name=ASKED + entry.name, role="control", actuator=self.motors[entry.joint], field="x")
        return [told, ChannelEntry(name=entry.name, role="compare", joint=entry.joint, field="x", unit=entry.unit)]

    def record(self, motion: Motion, rng: np.random.Generator) -> dict[str, Array]:
        """A log of a motion by field of the map, (n,) each.

        Raises:
            SimulationError: it diverged.
        """
        step = self.model.opt.timestep
        time = step * np.arange(round((motion.duration + LEAD) / step) + 1)
        told = {}
        for entry in self.channels.role("control"):
            reference = motion.reference.get(entry.name.removeprefix(ASKED), Reference())
            told[entry.name] = Signal(time, reference(np.maximum(time - LEAD, 0))[:, None], ("x",), "1", "")
        first = {self.motors[joint]: joint for joint in self.motors}
        for entry in self.channels.role("control"):
            if entry.actuator in first:  # a servo begins where it is told to be
                state = np.array([[told[entry.name].values[0, 0], 0.0]])
                told[f"start/{first[entry.actuator]}"] = Signal(time[:1], state, ("position", "velocity"), "1", "")
        log = Recording(motion.name, self.channels.name, "", told)
        inputs = inputs_of(self.spec, self.channels, self.simulated, log, 0.0, time, _no_nominal)
        (run,) = simulate(self.model, [inputs])
        if isinstance(run, SimulationError):
            raise run
        every = max(round(1 / (self.plant.rate * step)), 1)
        rows = np.arange(round(LEAD / step), len(time), every)
        dense = {
            e.name: Signal(time - LEAD, self._said(e, run, log)[:, None], (e.name,), "1", "")
            for e in self.channels.role("compare")
        }
        for effect in self.effects:
            if isinstance(effect, OutputEffect) and is_output(effect):
                dense |= effect.observe(dense, None)
            elif isinstance(effect, InputEffect) and _drives(effect):
                name = str(effect.location["channel"])
                read = effect.apply(time, dense[name].values[:, 0])
                dense[name] = Signal(dense[name].time, read[:, None], (name,), "1", "")
        table = {self.nominal.time: (time[rows] - LEAD) / self.nominal.time_scale}
        for entry in self.nominal.channel:
            if entry.sensed:
                values = self._sensed(entry, dense[entry.name].values[:, 0], rows, step, rng)
            else:
                values = told[entry.name].values[rows, 0]
            table[entry.field] = (values - entry.offset) / entry.scale
        return table

    def _said(self, entry: ChannelEntry, run: Run, log: Recording) -> Array:
        values = said(entry, run, self.model, self.spec, self.channels, (), log)
        for effect in reversed(self.between):
            if effect.location["actuator"] == entry.actuator:
                values = effect.invert(run.time, values)
        return values

    def _sensed(self, entry: ChannelEntry, true: Array, rows: Array, step: float, rng: np.random.Generator) -> Array:
        sensor, values = self.plant.sensor.get(entry.name, Sensor()), true
        if sensor.cutoff is not None:
            sections = butter(2, sensor.cutoff, fs=1 / step, output="sos")
            values, _ = sosfilt(sections, true, zi=sosfilt_zi(sections) * true[0])
        values = values[rows]
        white = rng.normal(size=len(rows))
        if sensor.correlation:
            keep = float(np.exp(-1 / (self.plant.rate * sensor.correlation)))
            white = lfilter([np.sqrt(1 - keep**2)], [1, -keep], white)
        values = values + sensor.noise * white
        return np.round(values / sensor.resolution) * sensor.resolution if sensor.resolution else values


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


def _eased(way: Array) -> Array:
    """0 to 1 as way goes from 0 to 1, with rest at both ends in speed and acceleration."""
    way = np.clip(way, 0, 1)
    return way**3 * (10 + way * (6 * way - 15))
