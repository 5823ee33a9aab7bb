"""MATLAB files as mappings, up to version 7.2 by scipy; a process of its own tries it first: damage can kill it."""

import signal
import struct
import subprocess
import sys
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from boom_mj.errors import LogError
from boom_mj.logs.arrays import read_hdf5
from boom_mj.logs.inflating import Inflater

HDF5 = b"MATLAB 7.3 MAT-file"  # as which later versions begin
HEAD, COMPRESSED = 128, 15  # bytes before the elements of version 5 and later; type of an element
TRY = "import sys, scipy.io; scipy.io.loadmat(sys.argv[1])"  # damage can end scipy's parser in a signal


def read_matlab(path: Path) -> Mapping[str, Any]:
    """Variables by name, structures as mappings.

    Raises:
        LogError: no such file, or one that does harm.
    """
    from scipy.io import loadmat

    try:
        with path.open("rb") as stream:
            if stream.read(len(HDF5)) == HDF5:
                return read_hdf5(path, matlab=True)
        _look_through(path)
        found = loadmat(path, squeeze_me=True, struct_as_record=False)
    except LogError:
        raise
    except Exception as error:  # broken bytes raise whatever the parser stumbles over
        raise LogError(f"{path} is no MATLAB file: {error}") from error
    return {name: _tree(value) for name, value in found.items() if not name.startswith("__")}


def _tree(value: Any) -> Any:
    """Structures of MATLAB as mappings."""
    if hasattr(value, "_fieldnames"):
        return {name: _tree(getattr(value, name)) for name in value._fieldnames}
    return value


def _look_through(path: Path) -> None:
    """Refuse what inflates without bound, and what scipy does not survive."""
    inflater = Inflater(path.stat().st_size)
    with path.open("rb") as stream:
        if not any(head := stream.read(HEAD)):
            raise ValueError("it begins with zeros")
        order = {b"IM": "<", b"MI": ">"}.get(head[-2:])
        while order and len(tag := stream.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", tag)
            if not kind:
                raise ValueError("an element is of no type")
            if kind == COMPRESSED:
                inflater.inflate(stream.read(size), "zlib")
            else:
                stream.seek(size, 1)
    if (end := _tried(path.resolve(), path.stat().st_mtime_ns)) < 0:
        raise ValueError(f"reading it ends in {signal.Signals(-end).name}")


@cache
def _tried(path: Path, changed: int) -> int:
    """How a process ends that reads a file; once for as long as it does not change."""
    return subprocess.run([sys.executable, "-I", "-c", TRY, str(path)], capture_output=True, check=False).returncode
