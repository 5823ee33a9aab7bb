"""C3D files of motion capture as mappings: `time`, `points.LABEL` (n, 3) in the file's unit, `analog.LABEL` (n,).

A file is blocks of 512 bytes: a header, a tree of parameters, and frames of points (x, y, z, residual) and analog
samples, as integers with a scale or as floats. Points whose residual is negative were not seen.
"""

import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from boom_mj.errors import LogError

BLOCK, MAGIC = 512, 0x50
INTEL, DEC, SGI = 84, 85, 86  # processors; only the first writes what we read
SIZES = {-1: "S", 1: "i1", 2: "<i2", 4: "<f4"}
Parameters = dict[str, dict[str, Any]]


def read_c3d(path: Path) -> Mapping[str, Any]:
    """What the file holds, times from 0 at its first frame; analog channels as means over a frame.

    Raises:
        LogError: damage, or a file of a processor that is not Intel's.
    """
    try:
        content = path.read_bytes()
        return _tree(content, _parameters(content))
    except (OSError, struct.error, ValueError, KeyError, IndexError, TypeError) as error:
        raise LogError(f"{path} is no C3D file of an Intel processor: {type(error).__name__}: {error}") from error


def _tree(content: bytes, groups: Parameters) -> dict[str, Any]:
    if content[1] != MAGIC:
        raise ValueError("it does not begin as one")
    points, samples, first, last = struct.unpack_from("<4H", content, 2)
    (start,) = struct.unpack_from("<H", content, 16)
    scale, rate, point = float(groups["POINT"]["SCALE"]), float(groups["POINT"]["RATE"]), groups["POINT"]
    kind = np.dtype("<f4" if scale < 0 else "<i2")
    width, frames = 4 * points + samples, max(last - first + 1, 0)
    room = (len(content) - (start - 1) * BLOCK) // max(width * kind.itemsize, 1)
    frames = room if last == 0xFFFF else min(frames, room)
    if not width or frames < 1:
        raise ValueError("it has no frames")
    rows = np.frombuffer(content, kind, frames * width, (start - 1) * BLOCK).reshape(frames, width).astype(float)
    marks = rows[:, : 4 * points].reshape(frames, points, 4)
    seen = np.where(marks[:, :, 3:] < 0, np.nan, marks[:, :, :3]) * (1.0 if scale < 0 else scale)
    found: dict[str, Any] = {
        "time": np.arange(frames) / rate,
        "points": {label: seen[:, k] for k, label in enumerate(_labels(point, points))},
    }
    analog = groups.get("ANALOG", {})
    channels = int(np.ravel(analog.get("USED", 0))[0])
    if channels and samples % channels == 0:
        means = rows[:, 4 * points :].reshape(frames, -1, channels).mean(axis=1)
        gains = np.broadcast_to(np.ravel(analog.get("SCALE", 1.0)), channels) * float(analog.get("GEN_SCALE", 1.0))
        zero = np.broadcast_to(np.ravel(analog.get("OFFSET", 0.0)), channels)
        found["analog"] = dict(zip(_labels(analog, channels), ((means - zero) * gains).T))
    return found


def _labels(group: Mapping[str, Any], count: int) -> list[str]:
    given = [label.strip() for label in np.ravel(group.get("LABELS", []))]
    return [given[k] if k < len(given) and given[k] else f"{k + 1}" for k in range(count)]


def _parameters(content: bytes) -> Parameters:
    """Parameters by group and name: numbers, texts, or arrays of them."""
    at = (content[0] - 1) * BLOCK
    if content[at + 3] != INTEL:
        raise ValueError(f"processor {content[at + 3]} is not {INTEL}")
    names: dict[int, str] = {}
    values: list[tuple[int, str, Any]] = []
    at += 4
    while at + 2 < len(content) and (length := abs(struct.unpack_from("b", content, at)[0])):
        (group,) = struct.unpack_from("b", content, at + 1)
        name = content[at + 2 : at + 2 + length].decode("latin-1").upper()
        here = at + 2 + length
        (step,) = struct.unpack_from("<H", content, here)
        if group < 0:
            names[-group] = name
        else:
            values.append((group, name, _value(content, here + 2)))
        if not step:
            break
        at = here + step
    groups: Parameters = {}
    for group, name, value in values:
        groups.setdefault(names.get(group, ""), {})[name] = value
    return groups


def _value(content: bytes, at: int) -> Any:
    kind, axes = struct.unpack_from("bB", content, at)
    shape = tuple(content[at + 2 : at + 2 + axes])
    count = int(np.prod(shape)) if shape else 1
    if kind == -1:
        text = content[at + 2 + axes : at + 2 + axes + count].decode("latin-1")
        if len(shape) < 2:
            return text
        return [text[k : k + shape[0]] for k in range(0, count, shape[0] or 1)]
    found = np.frombuffer(content, SIZES[kind], count, at + 2 + axes)
    return found[0] if not shape else found
