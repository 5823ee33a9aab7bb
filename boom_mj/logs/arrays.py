"""Arrays as mappings: NumPy's files, and HDF5, as which MATLAB 7.3 writes, by h5py: `pip install boom_mj[hdf5]`."""

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from boom_mj.errors import LogError
from boom_mj.logs.inflating import Inflater

Array = np.ndarray


def read_numpy(path: Path) -> Mapping[str, Any]:
    """Arrays by name, nothing unpickled; of a file of one array that one, under no name.

    Raises:
        LogError: a file that cannot be read, or inflates without bound.
    """
    try:
        if zipfile.is_zipfile(path):
            with zipfile.ZipFile(path) as packed:
                Inflater(path.stat().st_size).count(sum(part.file_size for part in packed.infolist()))
        found = np.load(path, allow_pickle=False)
        return {"": found} if isinstance(found, Array) else {name: found[name] for name in found.files}
    except Exception as error:  # whatever its parser stumbles over
        raise LogError(f"{path} is no NumPy file of numbers: {error}") from error


def read_hdf5(path: Path, matlab: bool = False) -> Mapping[str, Any]:
    """Datasets by name, groups as mappings; each is read when it is asked for.

    Args:
        matlab: whether MATLAB wrote it, whose columns are its rows.

    Raises:
        LogError: h5py is not installed, or does not take the file.
    """
    try:
        import h5py  # type: ignore[import-not-found,import-untyped,unused-ignore]
    except ImportError as error:
        raise LogError(f"{path} needs h5py: pip install boom_mj[hdf5]") from error
    try:
        inflater = Inflater(path.stat().st_size)

        def tree(group: Any) -> dict[str, Any]:
            return {
                name: tree(part) if isinstance(part, h5py.Group) else _Dataset(part, inflater, matlab)
                for name, part in group.items()
                if part is not None  # a link to nowhere
            }

        return tree(h5py.File(path, "r"))
    except Exception as error:
        raise LogError(f"{path} is no HDF5 file: {error}") from error


@dataclass(frozen=True, eq=False)
class _Dataset:
    """An array that is read when it is needed; a row or column of MATLAB is (n,)."""

    data: Any
    inflater: Inflater
    matlab: bool

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        self.inflater.count(self.data.size * self.data.dtype.itemsize)
        values = np.asarray(self.data[()], dtype=dtype)
        return np.squeeze(values.T) if self.matlab else values
