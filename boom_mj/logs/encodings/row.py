"""Rows of a table: a message is one row of numbers, a field is one of its columns."""

from collections.abc import Iterator, Sequence

import numpy as np

from boom_mj.logs.channel import Array, Channel, Column, Group

ALL = "columns"  # the field that holds all columns of a table


class RowDecoder:
    """Rows of one table -> one group; the field "columns" is all of them."""

    def __init__(self, channel: Channel) -> None:
        self._names = tuple(channel.schema.decode().split("\n"))

    def decode(self, messages: Sequence[Array], fields: Sequence[str]) -> Iterator[Group]:
        if len(messages):
            rows = np.asarray(messages)
            yield Group(np.arange(len(rows)), None, "", {path: self._column(rows, path) for path in fields})

    def tree(self, message: Array) -> dict[str, object]:
        """A row as a message: the names of the columns and their values."""
        return {"names": list(self._names), ALL: list(message)}

    def _column(self, rows: Array, path: str) -> Column:
        if path == ALL:
            return Column(self._names, rows)
        present = [i for i, name in enumerate(self._names) if name == path]
        return Column(tuple(self._names[i] for i in present), rows[:, present])
