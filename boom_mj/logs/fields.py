"""Where the numbers of a field stand in a message: paths such as "position", "wrench.force", "poses[].position".

A message is a tree of mappings, lists, strings and leaves; a leaf is a number, or a `Leaf`: the place of numbers
in an encoded message. `[]` goes through all elements of a list, `[2]` takes the third.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

STEP = re.compile(r"\[(\d*)\]|([^.\[\]]+)")
NAME_LISTS = ("name", "names", "joint_names")  # of a field's numbers, beside it or further up
AXES = ("x", "y", "z")
SECONDS, NANOSECONDS = ("sec", "secs", "seconds"), ("nanosec", "nsec", "nsecs", "nanos")


@dataclass(frozen=True)
class Leaf:
    """`count` numbers of a numpy type from byte `offset` of a message on."""

    offset: int
    dtype: str
    count: int = 1


@dataclass(frozen=True)
class Selection:
    """The numbers of a field: k names; leaves of k numbers in all, or none where the message leaves it empty."""

    names: tuple[str, ...]
    leaves: tuple[Any, ...]


def select(tree: Any, path: str) -> Selection:
    """The numbers at a path; a path that is not there is an empty field.

    Raises:
        ValueError: numbers and names that do not go together, or something that is no number.
    """
    nodes: list[tuple[str, Any]] = [("", tree)]
    names: tuple[str, ...] = ()
    for index, key in _steps(path):
        following: list[tuple[str, Any]] = []
        for label, node in nodes:
            if key:
                names = _names_beside(node) or names
                following.append((label, node.get(key) if isinstance(node, Mapping) else None))
            elif isinstance(node, list):
                chosen = [int(index)] if index else range(len(node))
                following += [(_label(node[i], i), node[i]) for i in chosen if i < len(node)]
        nodes = following
    labels: list[str] = []
    leaves: list[Any] = []
    for label, node in nodes:
        for sub, leaf in _numbers(node):
            labels.append("/".join(filter(None, (label, sub))) or path)
            leaves.append(leaf)
    if all(leaf is None for leaf in leaves):
        return Selection(names or tuple(labels), ())
    if isinstance(nodes[0][1], list) and len(nodes) == 1 and not isinstance(nodes[0][1][0], Mapping):
        count = sum(getattr(leaf, "count", 1) for leaf in leaves)
        if names and len(names) != count:
            raise ValueError(f"{count} values of {path} for the {len(names)} names {', '.join(names)}")
        return Selection(names or tuple(map(str, range(count))), tuple(leaves))
    return Selection(tuple(labels), tuple(leaves))


@cache
def _steps(path: str) -> tuple[tuple[str, str], ...]:
    """Index and key of every step of a path; one of them is empty."""
    return tuple(STEP.findall(path))


def _names_beside(node: Any) -> tuple[str, ...]:
    if isinstance(node, Mapping):
        for key in NAME_LISTS:
            if isinstance(value := node.get(key), list) and value and all(isinstance(name, str) for name in value):
                return tuple(value)
    return ()


def _label(node: Any, index: int) -> str:
    name = node.get("name") if isinstance(node, Mapping) else None
    return name if isinstance(name, str) else str(index)


def _numbers(node: Any) -> Iterator[tuple[str, Any]]:
    """Numbers of a node with their names in it; None for one that is absent."""
    if isinstance(node, Mapping):
        if not set(AXES) <= set(node):
            raise ValueError(f"it holds {', '.join(node)}: name one of them")
        yield from ((axis, node[axis]) for axis in (*AXES, "w") if axis in node)
    elif isinstance(node, list):
        for i, element in enumerate(node):
            for label, leaf in _numbers(element):
                yield "/".join(filter(None, (str(i), label))), leaf
    elif isinstance(node, str):
        raise ValueError(f"'{node[:40]}' is a text, not a number")
    else:
        yield "", node


def stamp_leaves(tree: Any) -> tuple[Any, Any] | None:
    """Seconds and nanoseconds of a message's own time, if it has one."""
    header = tree.get("header") if isinstance(tree, Mapping) else None
    for node in (header.get("stamp") if isinstance(header, Mapping) else None, tree.get("timestamp")):
        if isinstance(node, Mapping):
            sec = next((node[key] for key in SECONDS if key in node), None)
            nsec = next((node[key] for key in NANOSECONDS if key in node), None)
            if sec is not None or nsec is not None:
                return sec or 0, nsec or 0
    return None


def frame_of(tree: Any) -> str:
    """frame_id of a message's header, "" without one."""
    header = tree.get("header") if isinstance(tree, Mapping) else None
    for node in (header, tree):
        if isinstance(node, Mapping) and isinstance(node.get("frame_id"), str):
            return str(node["frame_id"])
    return ""


def numeric_fields(tree: Any, prefix: str = "") -> Iterator[str]:
    """Paths of all fields with numbers, vectors as one; times and covariances left aside."""
    if isinstance(tree, Mapping):
        if prefix and set(AXES) <= set(tree) and not any(isinstance(v, (Mapping, list)) for v in tree.values()):
            yield prefix
            return
        for key, node in tree.items():
            if key not in ("header", "timestamp", "stamp") and not key.endswith("covariance"):
                yield from numeric_fields(node, f"{prefix}.{key}" if prefix else key)
    elif isinstance(tree, list):
        if tree and isinstance(tree[0], Mapping):
            yield from numeric_fields(tree[0], f"{prefix}[]")
        elif tree and not isinstance(tree[0], (str, list)):
            yield prefix
    elif not isinstance(tree, str) and tree is not None:
        yield prefix
