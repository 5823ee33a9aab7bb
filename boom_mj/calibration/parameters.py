"""What a calibration may change: factors on numbers of the machine file, and zero offsets of the joint sensors.

A scaled parameter is the logarithm of a factor, 0 at the file's own value, or a zero offset in rad. Parameters that the
data cannot tell apart are tied, they share one: their ratio stays what the file says.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from boom_mj.effects import Effect, MachineEffect, make_effect
from boom_mj.errors import InputError
from boom_mj.machine import Machine

Array = np.ndarray
JOINTS = 5
FACTOR = (0.25, 4.0)  # bounds of a factor
OFFSET = 0.05  # rad, bound of a zero offset
STEP, OFFSET_STEP = 0.01, 0.002  # of secants: of a logarithm, rad


@dataclass(frozen=True)
class Kind:
    """A family of parameters: the fields of the machine file that it scales, in every link or in one section."""

    fields: tuple[str, ...]
    unit: str
    per_link: bool = True


KINDS = {
    "mass": Kind(("mass",), "kg"),
    "center_of_gravity": Kind(("center_of_gravity",), "m"),
    "youngs_modulus_y": Kind(("youngs_modulus_y",), "Pa"),
    "youngs_modulus_z": Kind(("youngs_modulus_z",), "Pa"),
    "shear_modulus": Kind(("shear_modulus",), "Pa"),
    "damping": Kind(("relaxation_time", "bending", "torsion"), "s", per_link=False),
}
"""What can be calibrated, by the name that `--free` takes."""
STIFFNESS = ("youngs_modulus_y", "youngs_modulus_z", "shear_modulus")
USUAL = ("mass", *STIFFNESS, "damping")
"""Kinds that are free unless asked otherwise."""


@dataclass(frozen=True)
class Parameter:
    """One number of the machine file, or the few of a section that are scaled together; `link` is 2..5 or None."""

    kind: str
    link: int | None

    @property
    def name(self) -> str:
        return self.kind if self.link is None else f"link{self.link}.{self.kind}"

    @property
    def unit(self) -> str:
        return KINDS[self.kind].unit

    def values(self, machine: Machine) -> dict[str, float]:
        """Values of its fields."""
        section = machine.damping if self.link is None else machine.links[self.link - 2]
        return {field: getattr(section, field) for field in KINDS[self.kind].fields}

    def value(self, machine: Machine) -> float:
        """The first of its values that is not zero."""
        return next((value for value in self.values(machine).values() if value), 0.0)

    def scaled(self, machine: Machine, factor: float) -> Machine:
        """The machine with this number times a factor."""
        values = {field: factor * value for field, value in self.values(machine).items()}
        if self.link is None:
            return machine.model_copy(update={"damping": machine.damping.model_copy(update=values)})
        links = list(machine.links)
        links[self.link - 2] = links[self.link - 2].model_copy(update=values)
        return machine.model_copy(update={"link": tuple(links)})

    def bounds(self, machine: Machine) -> tuple[float, float]:
        """Factors within which the machine file allows it."""
        if self.kind != "center_of_gravity":
            return FACTOR
        link = machine.links[int(self.link or 2) - 2]
        return -link.length / 2 / link.center_of_gravity + 1e-6, -link.length / 1.5 / link.center_of_gravity - 1e-6


@dataclass(frozen=True)
class Tied:
    """One or more parameters of a kind that share a factor."""

    parameters: tuple[Parameter, ...]

    @property
    def kind(self) -> str:
        return self.parameters[0].kind

    @property
    def name(self) -> str:
        if len(self.parameters) == 1:
            return self.parameters[0].name
        return f"link{'+'.join(str(p.link) for p in self.parameters)}.{self.kind}"


class OtherMachine(MachineEffect):
    """Another machine file in the place of the nominal one."""

    id = "other_machine"
    machine: Machine

    def __init__(self, machine: Machine):
        super().__init__()
        object.__setattr__(self, "machine", machine)

    @property
    def key(self) -> tuple[Any, ...]:
        return self.id, self.machine

    def change(self, machine: Machine) -> Machine:
        return self.machine


@dataclass(frozen=True)
class Variant:
    """A machine and the zero offsets of its joint sensors, q1..q5, rad: what predicts a recording."""

    machine: Machine
    offsets: tuple[float, ...] = (0.0,) * JOINTS

    @property
    def hypothesis(self) -> tuple[Effect, ...]:
        """As effects on the nominal machine."""
        return OtherMachine(self.machine), *self.sensor

    @property
    def sensor(self) -> tuple[Effect, ...]:
        """The zero offsets as the effects that a machine file holds."""
        offsets = enumerate(self.offsets)
        return tuple(make_effect("joint_zero_offset", {"joint": k + 1, "offset": value}) for k, value in offsets)


@dataclass(frozen=True)
class Parameterisation:
    """Scaled parameters of a calibration: one per tied group, then the five zero offsets.

    Attributes:
        machine: whose numbers are scaled.
        tied: in the order of the scaled parameters.
        joints: whose zero offsets are free: all, or none.
    """

    machine: Machine
    tied: tuple[Tied, ...]
    joints: int = JOINTS

    @property
    def size(self) -> int:
        return len(self.tied) + self.joints

    @property
    def names(self) -> tuple[str, ...]:
        return (*(group.name for group in self.tied), *(f"joint{k + 1}.zero_offset" for k in range(self.joints)))

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kind of every scaled parameter."""
        return (*(group.kind for group in self.tied), *("zero_offset",) * self.joints)

    @property
    def steps(self) -> Array:
        """Secant steps, (size,)."""
        return np.array([STEP] * len(self.tied) + [OFFSET_STEP] * self.joints)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Least and greatest scaled parameters, (size,) each."""
        ends = []
        for group in self.tied:
            low, high = zip(*(parameter.bounds(self.machine) for parameter in group.parameters))
            ends.append((np.log(max(low)), np.log(min(high))))
        low, high = np.array([*ends, *((-OFFSET, OFFSET),) * self.joints]).T
        return low, high

    def at(self, scaled: Array) -> Variant:
        """The machine and the offsets at scaled parameters (size,)."""
        machine = self.machine
        for group, size in zip(self.tied, scaled):
            for parameter in group.parameters:
                machine = parameter.scaled(machine, float(np.exp(size)))
        offsets = (*map(float, scaled[len(self.tied) :]), *(0.0,) * (JOINTS - self.joints))
        return Variant(machine, offsets)

    def subset(self, kinds: Sequence[str]) -> list[int]:
        """Numbers of the tied parameters of some kinds."""
        return [number for number, group in enumerate(self.tied) if group.kind in kinds]

    def gathering(self, finer: "Parameterisation") -> Array:
        """Matrix (finer.size, size) that takes these scaled parameters to those of another with more groups."""
        matrix = np.zeros((finer.size, self.size))
        for column, group in enumerate(self.tied):
            for row, fine in enumerate(finer.tied):
                matrix[row, column] = set(fine.parameters) <= set(group.parameters)
        matrix[len(finer.tied) :, len(self.tied) :] = np.eye(self.joints)
        return matrix

    def joined(self, first: int, second: int) -> "Parameterisation":
        """With two groups made one."""
        one = Tied(tuple(sorted((*self.tied[first].parameters, *self.tied[second].parameters), key=_order)))
        tied = [one if k == min(first, second) else group for k, group in enumerate(self.tied)]
        del tied[max(first, second)]
        return replace(self, tied=tuple(tied))

    def without(self, number: int) -> "Parameterisation":
        """With a group fixed."""
        return replace(self, tied=self.tied[:number] + self.tied[number + 1 :])


def _order(parameter: Parameter) -> int:
    return parameter.link or 0


def make_parameterisation(machine: Machine, kinds: Sequence[str] = USUAL) -> Parameterisation:
    """A group for every parameter of some kinds.

    Raises:
        InputError: no such kind, or a parameter that is zero and that no factor moves.
    """
    for kind in kinds:
        if kind not in KINDS:
            raise InputError(f"there is no parameter {kind!r} to calibrate; there are {', '.join(KINDS)}")
    numbers = range(2, 2 + len(machine.links))
    parameters = [
        Parameter(kind, link)
        for kind in KINDS
        if kind in kinds
        for link in (numbers if KINDS[kind].per_link else (None,))
    ]
    for parameter in parameters:
        if not parameter.value(machine):
            fields = ", ".join(parameter.values(machine))
            raise InputError(f"{parameter.name} of {machine.name} is zero and no factor moves it: give one of {fields}")
    return Parameterisation(machine, tuple(Tied((parameter,)) for parameter in parameters))
