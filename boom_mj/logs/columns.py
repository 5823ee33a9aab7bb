"""Any table of numbers by field: text (cells may be lists), MATLAB, NumPy, HDF5, JSON, Parquet, C3D, MCAP and bags.

A field is a path: `qm`, `ScopeData.signals.values[2]`, `positions[0]`, and of bags and MCAP
`/joint_states.position[0]`, whose time is `/joint_states.log_time`. A number in brackets counts columns from 0.
"""

import csv
import io
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from boom_mj.errors import LogError
from boom_mj.files import whole_file
from boom_mj.logs.arrays import read_hdf5, read_numpy
from boom_mj.logs.c3d import read_c3d
from boom_mj.logs.channel import Batch, Group
from boom_mj.logs.encodings import decoder_of
from boom_mj.logs.formats import format_of, log_file
from boom_mj.logs.formats.table import SUFFIXES, lines, numbers, text_table
from boom_mj.logs.json_table import read_json
from boom_mj.logs.matlab import read_matlab
from boom_mj.logs.parquet import read_parquet

Array = np.ndarray
FIELD = re.compile(r"^(?P<stem>.*?)(\[(?P<column>\d+)\])?$")
RECORDED, STAMPED = CLOCKS = "log_time", "header_time"


def read_columns(path: Path, fields: Iterable[str]) -> dict[str, Array]:
    """Numbers of some fields of a log, (n,) each; NaN where a cell is empty.

    Raises:
        LogError: a file that cannot be read, or a field that it lacks; the message lists what there is.
    """
    path = log_file(Path(path))
    if not path.exists():
        raise LogError(f"{path} cannot be read: there is no such file")
    for suffixes, read in TABLES.items():
        if path.name.lower().endswith(suffixes):
            table = read(path)
            return {field: _within(path, table, field) for field in fields}
    return _messages(path, tuple(fields))


def write_columns(path: Path, columns: Mapping[str, Array]) -> None:
    """Write numbers, (n,) each, as a CSV table."""
    with whole_file(path) as stream:
        text = io.TextIOWrapper(stream, newline="")
        table = csv.writer(text)
        table.writerow(columns)
        table.writerows([f"{value:.9g}" for value in row] for row in zip(*columns.values()))
        text.flush()
        text.detach()


def _within(path: Path, table: Mapping[str, Any], field: str) -> Array:
    """Goes down a path of names and takes a column; a name may look like a path."""
    found = None if field in table else FIELD.match(field)
    stem, column = (found["stem"], found["column"]) if found else (field, None)
    value: Any = table
    for part in [stem] if stem in table else stem.split("."):
        names = sorted(value) if isinstance(value, Mapping) else []
        if names == [""]:
            names = [f"[0] to [{len(value[''].T) - 1}], as it does not name its columns"]
        if not isinstance(value, Mapping) or part not in value:
            raise LogError(f"{path} has no field '{field}': '{part}' is none of {', '.join(names) or 'its parts'}")
        value = value[part]
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OSError) as error:
        raise LogError(f"{path}: '{field}' holds no numbers") from error
    if column is not None:
        if numbers.ndim != 2 or int(column) >= numbers.shape[1]:
            raise LogError(f"{path}: '{stem}' is {numbers.shape}, it has no column {column} (columns count from 0)")
        numbers = numbers[:, int(column)]
    if numbers.ndim != 1:
        raise LogError(f"{path}: '{field}' is {numbers.shape}; name a column, such as '{stem}[0]'")
    return numbers


def _text(path: Path) -> Mapping[str, Any]:
    """Columns by their names; of a text without names all, (n, k), under no name."""
    found = text_table(path, lines(path))
    columns = [_column(cells) for cells in zip(*found.rows)]
    if not columns:
        raise LogError(f"{path} is no table: it needs a line of names, and numbers below")
    return dict(zip(found.names, columns)) if found.names else {"": np.stack(columns, axis=1)}


def _column(cells: Sequence[str]) -> Any:
    """A column of numbers, or of lists of numbers (n, k); texts are NaN."""
    if cells[0].lstrip().startswith("["):
        try:
            return [json.loads(cell) for cell in cells]
        except (ValueError, RecursionError):
            return cells
    return numbers(cells)


TABLES: Mapping[tuple[str, ...], Callable[[Path], Mapping[str, Any]]] = {
    (".mat",): read_matlab,
    SUFFIXES: _text,
    (".json",): read_json,
    (".parquet",): read_parquet,
    (".c3d",): read_c3d,
    (".npz", ".npy"): read_numpy,
    (".h5", ".hdf5"): read_hdf5,
}


def _messages(path: Path, fields: tuple[str, ...]) -> dict[str, Array]:
    """Fields `TOPIC.path[k]` of messages; `TOPIC.log_time` and `TOPIC.header_time` are their times, s."""
    topics = {field: field.partition(".")[0] for field in fields}
    rows: dict[str, list[Array]] = {field: [] for field in fields}
    there: list[str] = []

    def wanted(topic: str) -> bool:
        there.append(topic)
        return topic in topics.values()

    for batch in format_of(path).read(path, wanted):
        if not isinstance(batch, Batch) or not len(batch.messages):
            continue
        mine = [field for field in fields if topics[field] == batch.channel.topic]
        stems = {f: str(FIELD.match(f.partition(".")[2])["stem"]) for f in mine}  # type: ignore[index]
        asked = tuple(dict.fromkeys(s for s in stems.values() if s not in CLOCKS))
        decoded = set(stems.values()) - {RECORDED}
        groups = list(decoder_of(batch.channel).decode(batch.messages, asked)) if decoded else []
        for field in mine:
            if stems[field] in CLOCKS:
                rows[field].append(_times(path, batch, groups, stems[field]) / 1e9)
                continue
            column = int(FIELD.match(field)["column"] or 0)  # type: ignore[index]
            values = np.full(len(batch.messages), np.nan)
            for group in groups:
                values[group.which] = group.columns[stems[field]].values[:, column]
            rows[field].append(values)
    for field, parts in rows.items():
        if not parts:
            raise LogError(f"{path} has no field '{field}'; its topics are {', '.join(sorted(set(there)))}")
    return {field: np.concatenate(parts) for field, parts in rows.items()}


def _times(path: Path, batch: Batch, groups: Iterable[Group], clock: str) -> Array:
    """When messages were recorded, or what their headers say, (n,), ns."""
    if clock == RECORDED:
        return np.asarray(batch.log_time, float)
    found = np.full(len(batch.messages), np.nan)
    for group in groups:
        if group.stamp is None:
            raise LogError(f"{path}: messages on {batch.channel.topic} have no header; their time is {RECORDED}")
        found[group.which] = group.stamp
    return found
