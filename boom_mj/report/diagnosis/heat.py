"""A heat map as a table: rows are sensors on links, blocks of columns are directions, bands and phases."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.colors import to_hex

from boom_mj.diagnosis.localisation import Cell
from boom_mj.report.diagnosis.view import View
from boom_mj.report.drawing import HEAT

ACROSS = ("direction", "band", "phase")


@dataclass(frozen=True)
class Shade:
    """A cell of the map: a share of the squared residual, its colour, and a text colour that can be read on it."""

    share: float
    colour: str
    ink: str


@dataclass(frozen=True)
class Block:
    """Columns of one kind; their shares add up to the row's."""

    title: str
    columns: tuple[str, ...]


@dataclass(frozen=True)
class Row:
    """A sensor on a link: its share of everything, and a shade per column, None where it measures nothing there."""

    sensor: str
    link: str
    total: Shade
    shades: tuple[Shade | None, ...]


@dataclass(frozen=True)
class HeatMap:
    """Blocks of columns, rows, and the totals of all columns."""

    blocks: tuple[Block, ...]
    rows: tuple[Row, ...]
    totals: tuple[Shade, ...]


def heat_map(view: View, cells: Sequence[Cell]) -> HeatMap:
    """Shares of every sensor on every link, by direction where there are several, by band and by phase."""
    table: dict[tuple[str, str, str, str], float] = defaultdict(float)
    column: dict[tuple[str, str], float] = defaultdict(float)
    row: dict[tuple[str, str], float] = defaultdict(float)
    for cell in cells:
        row[cell.sensor, cell.link] += cell.share
        for axis in ACROSS:
            name = getattr(cell, axis)
            table[cell.sensor, cell.link, axis, name] += cell.share
            column[axis, name] += cell.share
    blocks = [Block(axis, tuple(n for n in view.order[axis] if (axis, n) in column)) for axis in ACROSS]
    blocks = [block for block in blocks if any(block.columns)]
    columns = [(block.title, name) for block in blocks for name in block.columns]
    darkest = max([*table.values(), 1e-9])
    rows = tuple(
        Row(
            *place,
            shade(row[place], 1.0),
            tuple(shade(table[*place, *c], darkest) if (*place, *c) in table else None for c in columns),
        )
        for place in sorted(row, key=lambda place: [view.order[a].index(p) for a, p in zip(("sensor", "link"), place)])
    )
    return HeatMap(tuple(blocks), rows, tuple(shade(column[c], 1.0) for c in columns))


def shade(share: float, darkest: float) -> Shade:
    """The colour of a share, by its root: a quarter of the darkest is half as dark."""
    depth = float(np.sqrt(min(max(share, 0.0) / darkest, 1.0)))
    return Shade(share, to_hex(HEAT(depth)), "#ffffff" if depth > 0.8 else "#222222")
