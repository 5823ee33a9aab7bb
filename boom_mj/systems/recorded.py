"""A machine with its recordings, as a diagnosis is given them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from boom_mj.estimation.dataset import Dataset
from boom_mj.replay.quality import DataFinding
from boom_mj.systems.system import System

Kind = TypeVar("Kind", bound=System, covariant=True)


@dataclass(frozen=True, eq=False)
class RecordedMachine(Generic[Kind]):
    """A system and its recordings, training first.

    Attributes:
        names: of the recordings as answers list them.
        findings: what is wrong with the logs.
    """

    system: Kind
    data: Dataset
    names: Sequence[str]
    findings: Sequence[DataFinding] = ()
