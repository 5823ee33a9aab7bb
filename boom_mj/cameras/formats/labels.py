"""The labels of a data set, read back frame by frame."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from boom_mj.cameras.dataset import Dataset
from boom_mj.errors import DatasetError
from boom_mj.files import read_json


def each_label(folder: Path, dataset: Dataset) -> Iterator[tuple[int, str, dict[str, Any]]]:
    """Number from 1, picture and label of every frame, in the order of the description."""
    for number, frame in enumerate(dataset.frames):
        path = folder / frame.file.replace("images/", "labels/", 1)
        yield number + 1, frame.file, read_json(path.with_suffix(".json"), DatasetError)
