"""All checks in turn, each on what the ones before have left."""

import warnings
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from boom_mj.errors import LogError
from boom_mj.machine import Machine
from boom_mj.recording import Recording
from boom_mj.replay.quality.edits import Edit, unchanged
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action, DataFinding

Array = np.ndarray


class Turn(IntEnum):
    """When a check looks.

    First what stamps say and what is dead. Then the joints, which drive the model, beside their commands, and the other
    sensors beside the model: unit, place, sign, in this order, as each is judged with those before mended. Then single
    samples, and last what recordings are beside each other.
    """

    STAMPS = 0
    DEAD = 1
    JOINT_UNITS = 2
    JOINT_PLACES = 3
    JOINT_SIGNS = 4
    JOINT_COURSE = 5
    LOADS = 6
    UNITS = 7
    PLACES = 8
    SIGNS = 9
    CLOCKS = 10
    SAMPLES = 11
    SET = 12


@dataclass(frozen=True)
class Found:
    """A finding and what follows from it.

    Attributes:
        index: of the recording.
        edit: of it.
        noise: levels that its signals now have, (k,).
        leave_out: whether the recording is not to be used at all.
    """

    index: int
    finding: DataFinding
    edit: Edit = unchanged
    noise: Mapping[str, Array] = field(default_factory=dict)
    leave_out: bool = False


class Check(ABC):
    """A kind of finding.

    A threshold stands in the check's file under one name with its reason: what clean logs show, or what noise does by
    chance. What a cause of the effect library can be - it has a size worth estimating - is no finding.
    """

    kind: ClassVar[str]
    turn: ClassVar[Turn]

    @abstractmethod
    def look(self, evidence: Evidence) -> Iterator[Found]:
        """What there is of its kind; `evidence` changes with every finding that is taken."""


@dataclass(frozen=True)
class CheckedRecordings:
    """What is sound in a set of recordings, and what is not.

    Attributes:
        recordings: those that are used, training first; NaN where samples are left out, without the signals that are.
        training: how many of them are for training.
        kept: their places among the recordings that were given.
        findings: in the order of the logs.
        noise: per recording that is kept, signal -> levels (k,), where they are above the machine file's.
    """

    recordings: tuple[Recording, ...]
    training: int
    kept: tuple[int, ...]
    findings: tuple[DataFinding, ...]
    noise: tuple[Mapping[str, Array], ...]

    def refuse(self, all_of_them: bool = False) -> None:
        """Raises LogError for what no work may begin with; with `all_of_them` for every finding."""
        if bad := [f for f in self.findings if all_of_them or f.action is Action.REFUSED]:
            raise LogError("\n".join(f.sentence for f in bad))


def check_recordings(
    machine: Machine, recordings: Sequence[Recording], training: int, names: Sequence[str] = ()
) -> CheckedRecordings:
    """Look for what is wrong with recordings of a boom.

    Args:
        machine: nominal.
        recordings: for training first; they stay as they are.
        training: how many of them are for training.
        names: of the recordings in findings, such as their paths; their own if left out.
    """
    evidence = Evidence(machine, recordings, names or _names(recordings), training)
    findings: list[tuple[int, DataFinding]] = []
    noise: dict[int, dict[str, Array]] = {}
    for found in _looked(evidence):
        findings.append((found.index, found.finding))
        evidence.recordings[found.index] = found.edit(evidence.recordings[found.index])
        for name, level in found.noise.items():
            before = noise.setdefault(found.index, {}).get(name, level)
            noise[found.index][name] = np.maximum(before, level)
        if found.leave_out:
            evidence.left_out.add(found.index)
    kept = evidence.indices
    return CheckedRecordings(
        recordings=tuple(evidence.recordings[k] for k in kept),
        training=sum(k < evidence.training for k in kept),
        kept=kept,
        findings=tuple(finding for _, finding in sorted(findings, key=lambda pair: pair[0])),
        noise=tuple(MappingProxyType(noise.get(k, {})) for k in kept),
    )


def _looked(evidence: Evidence) -> Iterator[Found]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of channels without any number, which numpy calls empty
        for check in all_checks():
            yield from check.look(evidence)


def _names(recordings: Sequence[Recording]) -> list[str]:
    """Names of recordings, numbered where they are alike."""
    names = [log.name for log in recordings]
    return [f"{name} ({names[: k + 1].count(name)})" if names.count(name) > 1 else name for k, name in enumerate(names)]


@cache
def all_checks() -> tuple[Check, ...]:
    """Every check of `kinds/`, in turn."""
    folder = "boom_mj.replay.quality.kinds"
    modules = [import_module(f"{folder}.{m.name}") for m in iter_modules(import_module(folder).__path__)]
    found = [
        kind()
        for module in modules
        for kind in vars(module).values()
        if isinstance(kind, type) and issubclass(kind, Check) and kind.__module__ == module.__name__
    ]
    return tuple(sorted(found, key=lambda check: (check.turn, check.kind)))
