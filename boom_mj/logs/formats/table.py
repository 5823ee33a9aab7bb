"""Tables of numbers as text, also gzipped: comma, semicolon (with decimal comma), tab or spaces between the columns.

Names of the columns are the first line that is no comment, or the last comment before numbers begin; a line of units
below them is passed over. A table is one topic, "table", whose times are those of its time column, if a topic map names
it.
"""

import codecs
import csv
import gzip
import os
import re
import warnings
import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import chain, islice
from pathlib import Path
from typing import IO

import numpy as np

from boom_mj.errors import LogError, LogWarning
from boom_mj.logs.channel import Array, Batch, Channel, Format, Labels, Wanted
from boom_mj.logs.inflating import Inflater

TOPIC = "table"
SUFFIXES = tuple(end + packed for end in (".csv", ".tsv", ".txt", ".dat") for packed in ("", ".gz"))
COMMENTS = "#%"  # that a line begins with
DATE = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d")
TRUTH = {"true": 1.0, "false": 0.0}
LONGEST = 2**20  # characters of a line
RATIO = 20  # to which text inflates
HEAD = 4096  # bytes that tell how characters are written
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
        with gzip.open(path, "rb") as packed:
            encoding = _encoding(packed.read(HEAD))
        return gzip.open(path, "rt", encoding=encoding, newline="")
    with path.open("rb") as file:
        encoding = _encoding(file.read(HEAD))
    return path.open(encoding=encoding, newline="")


def _encoding(head: bytes) -> str:
    """UTF-8, or what spreadsheets and instruments write instead."""
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8-sig"


@dataclass(frozen=True)
class Table:
    """The cells of a text.

    Attributes:
        names: of the columns, (k,); empty where no line names them.
        rows: cells, k each.
    """

    names: list[str]
    rows: Iterator[list[str]]


def text_table(path: Path, text: Iterable[str]) -> Table:
    """Names and rows of a text.

    Raises:
        LogError: nothing in it; from the rows one that has not as many cells as the first, but for the last of a text
            that was cut, which is left out with a warning, or a cell that does not end.
    """
    text, marked, between, first = iter(text), "", "", ""
    for first in text:
        bare = first.strip()
        if bare.lower().startswith("sep=") and len(bare) == len("sep=;"):
            between = bare[-1]
        elif bare and bare[0] not in COMMENTS:
            break
        elif bare:
            marked = bare.lstrip(COMMENTS + " ")
    else:
        raise LogError(f"{path} is empty")
    between = between or max(",;\t ", key=lambda one: (first.strip().count(one) > 0 and one != " ", first.count(one)))
    whole = _cells(path, chain([first], (line for line in text if line.lstrip()[:1] not in (*COMMENTS,))), between)
    head = next(whole)
    if any(cell and not _is_number(cell) for cell in head):
        names, second = head, next(whole, None)
        rows = whole if second is None or _are_units(second) else chain([second], whole)
    else:
        told = next(_cells(path, [marked], between), [])
        names, rows = told if len(told) == len(head) else [], chain([head], whole)
    return Table([name.strip() for name in names], _even(path, rows, len(head)))


def _cells(path: Path, text: Iterable[str], between: str) -> Iterator[list[str]]:
    """Rows of a table but the empty ones."""
    if between == " ":
        yield from (cells for line in text if (cells := line.split()))
        return
    try:
        yield from (row for row in csv.reader(text, delimiter=between) if row)
    except csv.Error as error:
        raise LogError(f"{path} is damaged: {error}") from error


def _are_units(row: Sequence[str]) -> bool:
    return all(cell.strip() and not np.isfinite(_number(cell)) and not DATE.match(cell) for cell in row)


def _even(path: Path, rows: Iterator[list[str]], width: int) -> Iterator[list[str]]:
    for number, row in enumerate(rows, 1):
        if len(row) != width:
            if number > 1 and len(row) < width and next(rows, None) is None:
                warnings.warn(f"{path} ends within row {number}, which is left out", LogWarning, stacklevel=4)
                return
            raise LogError(f"{path}, row {number}: {len(row)} cells for the {width} columns")
        yield row


def _rows(path: Path, text: Iterator[str]) -> Iterator[Batch]:
    found = text_table(path, text)
    if not found.names:
        raise LogError(f"{path} has no names in its first line, nor in a comment before it")
    if twice := sorted({name for name in found.names if found.names.count(name) > 1}):
        raise LogError(f"{path} has several columns called {', '.join(map(repr, twice))}")
    channel = Channel(1, TOPIC, "columns", "row", "", "\n".join(found.names).encode())
    yield Batch(channel, np.empty(0, np.int64), [])
    done = 0
    while rows := list(islice(found.rows, BATCH)):
        yield Batch(channel, np.arange(done, done + len(rows)), _numbers(rows))
        done += len(rows)


def _numbers(rows: list[list[str]]) -> Array:
    """Numbers of some rows; an empty cell is NaN."""
    try:
        return np.array(rows, dtype=np.float64)
    except ValueError:
        return np.column_stack([numbers(column) for column in zip(*rows)])


def numbers(cells: Sequence[str]) -> Array:
    """Values of a column, of a date its s since 1970; NaN where it is empty or a text."""
    try:
        return np.array(cells, dtype=np.float64)
    except ValueError:
        values = {cell: _number(cell) for cell in set(cells)}  # texts repeat
        return np.array([values[cell] for cell in cells])


def _number(cell: str) -> float:
    bare = cell.strip()
    if _is_number(bare.replace(",", ".")):
        return float(bare.replace(",", "."))
    if DATE.match(bare):
        try:
            moment = datetime.fromisoformat(bare)
        except ValueError:
            return np.nan
        return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
    return TRUTH.get(bare.lower(), np.nan)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


TABLE = Format("CSV table", lambda path, head: path.name.lower().endswith(SUFFIXES), _read)
