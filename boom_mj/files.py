"""Files: what comes from outside is read within bounds, what is written appears whole or not at all.

Text that people write (machines, maps, experiments) is at most `LONGEST` bytes; nothing is unpickled, and names in a
file do not lead out of its folder.
"""

import fcntl
import json
import os
import tomllib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any
from uuid import getnode, uuid4

from boom_mj.errors import BoomError, OutputError, shown

LONGEST, LONGEST_DATA = 2**20, 2**30  # bytes of a text by hand; of a file that is read at once
PNG, PNG_HEAD = b"\x89PNG\r\n\x1a\n", 24
DEVICES = Path("/dev")
HOST = f"{getnode():x}"


def read_bytes(path: Path | str, refuse: type[BoomError], most: int = LONGEST_DATA) -> bytes:
    """Content of a file of at most `most` bytes.

    Raises:
        refuse: it cannot be read, or is longer.
    """
    try:
        with Path(path).open("rb") as stream:
            content = stream.read(most + 1)
    except (OSError, ValueError) as error:
        raise refuse(f"{path} cannot be read: {getattr(error, 'strerror', None) or error}") from error
    if len(content) > most:
        raise refuse(f"{path} cannot be read: it is longer than {most} bytes, which nothing of its kind is")
    return content


def read_text(path: Path | str, refuse: type[BoomError], most: int = LONGEST) -> str:
    """Text of a file; see `read_bytes`."""
    try:
        return read_bytes(path, refuse, most).decode()
    except UnicodeDecodeError as error:
        raise refuse(f"{path} cannot be read: it is no text in UTF-8 ({error})") from error


def parse_toml(text: str, source: Path | str, refuse: type[BoomError]) -> dict[str, Any]:
    """What a TOML text says.

    Raises:
        refuse: it is none; the place is named.
    """
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise refuse(f"{source}: not a TOML file: {error}") from error


def read_json(path: Path | str, refuse: type[BoomError]) -> Any:
    """What a JSON file says.

    Raises:
        refuse: it cannot be read, or is no JSON.
    """
    try:
        return json.loads(read_bytes(path, refuse))
    except (ValueError, RecursionError) as error:
        raise refuse(f"{path}: not a JSON file: {error}") from error


def png_pixels(content: bytes) -> int:
    """Pixels of a PNG file, by its first PNG_HEAD bytes; 0 of any other."""
    width, height = (int.from_bytes(content[k : k + 4]) for k in (16, 20))
    return width * height if content.startswith(PNG) else 0


def inside(folder: Path, name: str, refuse: type[BoomError], source: Path) -> Path:
    """The file in a folder that `source` names.

    Raises:
        refuse: it lies outside the folder, by its name or by a link.
    """
    try:
        if Path(os.path.realpath(folder / name)).is_relative_to(os.path.realpath(folder)):
            return folder / name
    except ValueError as error:  # bytes that no name has
        raise refuse(f"{source} names {shown(name)}, which is no name of a file: {error}") from error
    raise refuse(f"{source} names {shown(name)}, which lies outside {folder}: put it inside")


@contextmanager
def whole_file(path: Path | str) -> Iterator[IO[bytes]]:
    """Stream to a file that appears under its name when the block ends, and not at all if it fails.

    A link stays one; a device or a pipe, such as /dev/stdout, is written as it comes.

    Raises:
        OutputError: the disk is full, or the place cannot be written.
    """
    path = Path(path)
    try:
        if DEVICES in path.parents or (path.exists() and not path.is_file()):
            with path.open("wb") as stream:
                yield stream
            return
        target = Path(os.path.realpath(path))
        part = target.with_name(f".{target.name}.{os.getpid()}@{HOST}.{uuid4().hex}.part")
        try:
            with part.open("wb") as stream:
                yield stream
            os.replace(part, target)
        finally:
            part.unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {error.strerror or error}") from error


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file whole or not at all; its folder is made.

    Raises:
        OutputError: see `whole_file`.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {error.strerror or error}") from error
    with whole_file(path) as stream:
        stream.write(content)


def write_text(path: Path | str, text: str) -> None:
    """Write a text whole or not at all, into a folder that exists; see `whole_file`."""
    with whole_file(path) as stream:
        stream.write(text.encode(errors="backslashreplace"))


def sweep(parts: Iterable[Path]) -> None:
    """Remove those parts of files (`.NAME.PID@HOST.UUID.part`) whose processes, of this machine, were killed."""
    for part in parts:
        process, _, host = part.name.split(".")[-3].partition("@")
        if host == HOST and process.isdigit() and not Path("/proc", process).exists():
            part.unlink(missing_ok=True)


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Be the only one to write into a folder, which is made; a process that is killed loses its lock.

    What killed processes left of files, before or meanwhile, is removed.

    Raises:
        OutputError: another process has it, or there cannot be such a folder.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        place = os.open(folder, os.O_RDONLY)
    except OSError as error:
        raise OutputError(f"{folder} cannot be written: {error.strerror or error}") from error
    try:
        try:
            fcntl.flock(place, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise OutputError(
                f"{folder} is being written by another process: wait until it has ended, or choose another folder"
            ) from error
        except OSError:  # a file system without locks
            pass
        try:
            sweep(folder.rglob(".*.part"))
            yield
        finally:
            sweep(folder.rglob(".*.part"))
    finally:
        os.close(place)
