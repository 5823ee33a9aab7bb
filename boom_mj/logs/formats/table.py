"""Tables of numbers as text: CSV, also gzipped; comma, semicolon (with decimal comma) or tab between the columns.

A table is one topic, "table", whose times are those of its time column, if a topic map names it.
"""

import csv
import gzip
import os
import zlib
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import IO

import numpy as np

from boom_mj.errors import LogError
from boom_mj.logs.channel import Array, Batch, Channel, Format, Labels, Wanted
from boom_mj.logs.inflating import Inflater

TOPIC = "table"
SUFFIXES = (".csv", ".csv.gz", ".tsv", ".tsv.gz")
LONGEST = 2**20  # characters of a line
RATIO = 20  # to which text inflates
PADDING = 64  # bytes of zeros that no gzipped file ends in
BATCH = 8192  # rows that are handed on together


def _read(path: Path, wanted: Wanted) -> Iterator[Batch | Labels]:
    if wanted(TOPIC):
        yield from _rows(path, lines(path))


def lines(path: Path) -> Iterator[str]:
    """Lines of a text, also of a compressed one, within bounds.

    Raises:
        LogError: damage, a line longer than LONGEST, or what inflates to far more than it is.
    """
    try:
        inflater = Inflater(path.stat().st_size, RATIO)
        with _text(path) as stream:
            while line := stream.readline(LONGEST + 1):
                if len(line) > LONGEST:
                    raise LogError(f"{path} is no table: it has a line of more than {LONGEST} characters")
                inflater.count(len(line))
                yield line
    except (ValueError, EOFError, zlib.error, OSError) as error:
        raise LogError(f"{path} is damaged: {error}") from error


def _text(path: Path) -> IO[str]:
    if path.suffix == ".gz":
        with path.open("rb") as file:
            file.seek(-min(PADDING, path.stat().st_size), os.SEEK_END)
            if (end := file.read()) and not end.strip(b"\0"):
                raise ValueError("it ends in zeros")  # which gzip would skip one by one
        return gzip.open(path, "rt", encoding="utf-8-sig", newline="")
    return path.open(encoding="utf-8-sig", newline="")


def cells(path: Path, text: Iterable[str], between: str) -> Iterator[list[str]]:
    """Rows of a table but the empty ones.

    Raises:
        LogError: a cell that does not end.
    """
    try:
        yield from (row for row in csv.reader(text, delimiter=between) if row)
    except csv.Error as error:
        raise LogError(f"{path} is damaged: {error}") from error


def _rows(path: Path, text: Iterator[str]) -> Iterator[Batch]:
    first = next(text, "")
    if not first.strip():
        raise LogError(f"{path} is empty")
    between = max(",;\t", key=first.count)
    names = [name.strip() for name in next(cells(path, [first], between))]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise LogError(f"{path} has several columns called {', '.join(map(repr, twice))}")
    if not any(name and not _is_number(name) for name in names):
        raise LogError(f"{path} has no names in its first line, which begins {first[:40]!r}")
    channel = Channel(1, TOPIC, "columns", "row", "", "\n".join(names).encode())
    yield Batch(channel, np.empty(0, np.int64), [])
    reader, done = cells(path, text, between), 0
    while rows := list(islice(reader, BATCH)):
        yield Batch(channel, np.arange(done, done + len(rows)), _numbers(path, rows, names, between == ";", done))
        done += len(rows)


def _numbers(path: Path, rows: list[list[str]], names: list[str], comma: bool, done: int) -> Array:
    """Numbers of some rows; an empty cell is NaN."""
    for i, row in enumerate(rows):
        if len(row) != len(names):
            raise LogError(f"{path}, row {done + i + 1}: {len(row)} cells for the {len(names)} columns")
    if comma:
        rows = [[cell.replace(",", ".") for cell in row] for row in rows]
    try:
        return np.array(rows, dtype=np.float64)
    except ValueError:
        return np.column_stack([numbers(column) for column in zip(*rows)])


def numbers(cells: Sequence[str]) -> Array:
    """Values of a column; NaN where it is empty or a text, which only counts if the column is asked for."""
    try:
        return np.array(cells, dtype=np.float64)
    except ValueError:
        values = {cell: float(cell) if _is_number(cell) else np.nan for cell in set(cells)}  # texts repeat
        return np.array([values[cell] for cell in cells])


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


TABLE = Format("CSV table", lambda path, head: path.name.lower().endswith(SUFFIXES), _read)
