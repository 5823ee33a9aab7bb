"""Formats of log files: one file each, named here."""

from pathlib import Path

from boom_mj.errors import LogError
from boom_mj.logs.channel import Format
from boom_mj.logs.formats.mcap_file import MCAP
from boom_mj.logs.formats.ros_bag import ROS1_BAG, ROS2_BAG
from boom_mj.logs.formats.table import TABLE

FORMATS = (MCAP, ROS1_BAG, ROS2_BAG, TABLE)
HEAD = 16  # bytes that tell formats apart


def format_of(path: Path) -> Format:
    """Format of a log, by its first bytes or its name.

    Raises:
        LogError: a file that is missing, or of no known format.
    """
    try:
        head = b"" if path.is_dir() else _head(path)
    except OSError as error:
        raise LogError(f"{path} cannot be read: {error.strerror or error}") from error
    for candidate in FORMATS:
        if candidate.recognises(path, head):
            return candidate
    raise LogError(f"{path} is not an MCAP file, nor one of {', '.join(f.name for f in FORMATS[1:])}")


def log_file(path: Path) -> Path:
    """The log itself: of a folder with just one MCAP file, or just one database without metadata, that file."""
    if path.is_dir():
        files = [*path.glob("*.mcap"), *([] if (path / "metadata.yaml").exists() else path.glob("*.db3"))]
        if len(files) == 1:
            return files[0]
    return path


def _head(path: Path) -> bytes:
    with path.open("rb") as stream:
        return stream.read(HEAD)
