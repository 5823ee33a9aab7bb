"""Parquet tables as mappings, by pyarrow, which comes with `pip install boom_mj[parquet]`."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from boom_mj.errors import LogError


def read_parquet(path: Path) -> Mapping[str, Any]:
    """Columns by name, nested ones as mappings.

    Raises:
        LogError: pyarrow is not installed, or does not take the file.
    """
    try:
        from pyarrow import parquet  # type: ignore[import-not-found,import-untyped,unused-ignore]
    except ImportError as error:
        raise LogError(f"{path} needs pyarrow: pip install boom_mj[parquet]") from error
    try:
        table = parquet.read_table(path).flatten()
    except Exception as error:  # whatever its parser stumbles over
        raise LogError(f"{path} is no Parquet file: {error}") from error
    tree: dict[str, Any] = {}
    for name in table.column_names:
        *above, last = name.split(".")
        place = tree
        for part in above:
            place = place.setdefault(part, {})
        place[last] = table.column(name).to_pylist()
    return tree
