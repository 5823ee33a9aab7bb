"""How machines with a channel map are recorded: NAME.plant.toml beside the map NAME.toml."""

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, FiniteFloat, ValidationError, model_validator
from scipy.signal import butter, lfilter, sosfilt, sosfilt_zi

from boom_mj.errors import InputError
from boom_mj.files import parse_toml
from boom_mj.machine.fields import NonNegative, Positive
from boom_mj.systems.mjcf.channel_map import ChannelMap

Array = np.ndarray
LEAD = 2.0  # s at rest before a log begins, and during which a reference comes into swing


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

    def __call__(self, true: Array, step: float, rows: Array, rng: np.random.Generator) -> Array:
        """What is logged at every so many rows (n,) of the truth at steps of so many seconds, (n,)."""
        values = true
        if self.cutoff is not None:
            sections = butter(2, self.cutoff, fs=1 / step, output="sos")
            values, _ = sosfilt(sections, true, zi=sosfilt_zi(sections) * true[0])
        noise = rng.normal(size=len(rows))
        if self.correlation:
            keep = float(np.exp(-step * (rows[1] - rows[0]) / self.correlation))
            noise = lfilter([np.sqrt(1 - keep**2)], [1, -keep], noise)
        values = values[rows] + self.noise * noise
        return np.round(values / self.resolution) * self.resolution if self.resolution else values


class Reference(_Part):
    """What is asked of a channel: rest in every knot (time, value), and sines (amplitude, Hz, phase) on top."""

    knots: tuple[tuple[FiniteFloat, FiniteFloat], ...] = ()
    sines: tuple[tuple[FiniteFloat, FiniteFloat, FiniteFloat], ...] = ()

    @model_validator(mode="after")
    def _goes_on(self) -> Self:
        if any(later <= before for (before, _), (later, _) in pairwise(self.knots)):
            raise ValueError("times of knots must increase")
        return self

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
    """A recording: what is asked of every channel that drives or controls; those left out stay at 0."""

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
    if sums := [entry.name for entry in channels.channel if not entry.field]:
        raise InputError(f"{source}: channel {sums[0]} of the map is a sum of fields, of which a plant knows no parts")
    asked = {entry.name for entry in channels.channel if entry.role in ("drive", "control")}
    known = {
        "servo": (set(channels.driven), set(plant.servo)),
        "sensor": ({entry.name for entry in channels.channel if entry.sensed}, set(plant.sensor)),
        "motion.reference": (asked, {name for motion in plant.motion for name in motion.reference}),
    }
    for where, (there, given) in known.items():
        if wrong := sorted(given - there):
            raise InputError(f"{source}: {where} names {wrong[0]}; the map has {', '.join(sorted(there)) or 'none'}")
    if missing := sorted(set(channels.driven) - set(plant.servo)):
        raise InputError(f"{source}: joint {missing[0]} is driven, but has no [servo.{missing[0]}]")
    if {motion.part for motion in plant.motion} != {"train", "holdout"}:
        raise InputError(f"{source}: there must be a motion for train, and one for holdout")
    return plant


def _eased(way: Array) -> Array:
    """0 to 1 as way goes from 0 to 1, with rest at both ends in speed and acceleration."""
    way = np.clip(way, 0, 1)
    return way**3 * (10 + way * (6 * way - 15))
