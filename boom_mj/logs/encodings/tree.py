"""Messages that are decoded one by one into trees of mappings, lists and numbers: JSON, protobuf."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from boom_mj.logs.channel import Column, DecodingError, Group
from boom_mj.logs.fields import frame_of, select, stamp_leaves


class TreeDecoder:
    """Messages of one channel -> groups.

    Args:
        tree: one encoded message -> its tree.
    """

    def __init__(self, tree: Callable[[bytes], Any]) -> None:
        self._tree = tree

    def tree(self, message: bytes) -> Any:
        """One message as a tree."""
        try:
            return self._tree(message)
        except Exception as error:  # whatever broken bytes lead to
            raise DecodingError(0, error) from error

    def decode(self, messages: Sequence[bytes], fields: Sequence[str]) -> Iterator[Group]:
        groups: dict[Any, list[Any]] = {}
        for i, message in enumerate(messages):
            try:
                tree = self._tree(message)
                found = [select(tree, path) for path in fields]
                rows = [np.array(s.leaves, np.float64) for s in found]  # None becomes NaN
                stamp = stamp_leaves(tree)
                ns = None if stamp is None else np.int64(int(stamp[0]) * 10**9 + int(stamp[1]))
            except Exception as error:  # whatever broken bytes lead to
                raise DecodingError(i, error) from error
            key = (frame_of(tree), ns is None, tuple((s.names, len(s.leaves)) for s in found))
            groups.setdefault(key, []).append((i, ns, rows))
        for (frame_id, stampless, columns), members in groups.items():
            which, stamps, decoded = zip(*members)
            yield Group(
                np.array(which),
                None if stampless else np.array(stamps, np.int64),
                frame_id,
                {
                    path: Column(names, np.array([row[k] for row in decoded]).reshape(len(which), width))
                    for k, (path, (names, width)) in enumerate(zip(fields, columns))
                },
            )
