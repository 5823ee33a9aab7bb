"""JSON logs as mappings: an object of lists, nested as it likes, or a list of records."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from boom_mj.errors import LogError

MOST = 2**30  # bytes


def read_json(path: Path) -> Mapping[str, Any]:
    """Lists by name; of a list of records a list per key, None (so NaN) where a record lacks it.

    Raises:
        LogError: a file that cannot be read, or holds neither.
    """
    try:
        if path.stat().st_size > MOST:
            raise LogError(f"{path} is larger than {MOST} bytes")
        found = json.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError, RecursionError) as error:
        raise LogError(f"{path} is no JSON: {error}") from error
    if isinstance(found, list) and found and all(isinstance(record, dict) for record in found):
        return _columns(found)
    if not isinstance(found, dict):
        raise LogError(f"{path} holds neither an object of lists nor a list of records")
    return found


def _columns(records: list[dict[str, Any]]) -> dict[str, Any]:
    names = dict.fromkeys(name for record in records for name in record)
    columns: dict[str, Any] = {}
    for name in names:
        column = [record.get(name) for record in records]
        parts = [cell for cell in column if isinstance(cell, dict)]
        columns[name] = _columns(parts) if len(parts) == len(column) else column
    return columns
