"""From recordings to what a diagnosis of a boom takes: data first, then the system and its dataset."""

from collections.abc import Sequence
from dataclasses import dataclass

from boom_mj.estimation.dataset import Dataset
from boom_mj.recording import Recording
from boom_mj.replay.quality import DataFinding, check_recordings
from boom_mj.systems.boom.system import BoomSystem
from boom_mj.systems.predictor import dataset_of
from boom_mj.systems.system import System


@dataclass(frozen=True, eq=False)
class CheckedData:
    """What is sound in a boom's recordings.

    Attributes:
        data: of the recordings that are used.
        names: of those, training first.
        findings: what is wrong with the data, and what was done about it.
    """

    data: Dataset
    names: tuple[str, ...]
    findings: tuple[DataFinding, ...]


def checked_data(
    boom: BoomSystem,
    recordings: Sequence[Recording],
    training: int,
    names: Sequence[str] = (),
    *,
    built: System | None = None,
    strict: bool = False,
) -> CheckedData:
    """The dataset of what is sound in recordings.

    Args:
        training: how many of them are for training; the first ones.
        names: of the recordings in findings and answers, such as their paths; their own if left out.
        built: the boom as it was built, if that is known.
        strict: whether any finding is refused.

    Raises:
        LogError: what no work may begin with: no time in common, held-out data that are training data.
    """
    names = tuple(names or (log.name for log in recordings))
    checked = check_recordings(boom.machine, recordings, training, names)
    checked.refuse(all_of_them=strict)
    data = dataset_of(built or boom, checked.recordings, checked.training, checked.noise)
    return CheckedData(data, tuple(names[k] for k in checked.kept), checked.findings)
