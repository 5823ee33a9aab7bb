"""Arguments that several commands share."""

import glob
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from boom_mj.errors import InputError, MachineFileError, SimulationError
from boom_mj.files import read_text, sweep, write_text
from boom_mj.machine import Beam, Machine, load_machine, load_model, machine_file

MachineFile = Annotated[str, typer.Argument(metavar="MACHINE.toml", help="Machine file, or a name such as boom36.")]
Hinges = Annotated[int, typer.Option(min=1, max=32, help="Equivalent hinges per elastic coordinate of each link.")]
Jobs = Annotated[int, typer.Option("--jobs", min=1, help="Processes of this machine that share the work.")]
Cluster = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="Dask scheduler whose workers share it instead; they see the same folders."),
]


class ManyHoldouts(TyperCommand):
    """`--holdout A B C` means `--holdout A --holdout B --holdout C`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        spread: list[str] = []
        within = False
        for word in args:
            if word == "--holdout":
                within = True
            elif word.startswith("-"):
                within = False
                spread.append(word)
            elif within:
                spread += ["--holdout", word]
            else:
                spread.append(word)
        return super().parse_args(ctx, spread)


def find_machine(name: str) -> Machine:
    """A machine from a file, or from the models that come with the package by its name."""
    return load_machine(name)


def find_model(name: str) -> Machine | Beam:
    """A machine of any kind, found like `find_machine`."""
    return load_model(name)


def machine_text(name: str) -> str:
    """The text of a machine file, found like `load_machine`."""
    return read_text(machine_file(name), MachineFileError)


def output_path(path: Path, suffix: str | None = None) -> Path:
    """Refuse an output that cannot be before any work is done, and remove what killed processes left of it."""
    if suffix is not None and path.suffix != suffix:
        raise InputError(f"{path}: the output of this command is a {suffix} file")
    folder = _resolved(path).parent
    if not folder.is_dir():
        raise InputError(f"{path}: there is no folder {folder}")
    if path.is_dir():
        raise InputError(f"{path} is a folder; the output of this command is a file")
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise InputError(f"{path} cannot be written: no permission")
    sweep(folder.glob(f".{glob.escape(path.name)}.*.part"))
    return path


def output_folder(path: Path) -> Path:
    """Refuse a folder for outputs that cannot be before any work is done."""
    there = next(place for place in (_resolved(path), *_resolved(path).parents) if place.exists())
    if not there.is_dir():
        raise InputError(f"{path}: {there} is a file; this command needs a folder")
    if not os.access(there, os.W_OK):
        raise InputError(f"{path} cannot be written: no permission in {there}")
    return path


def _resolved(path: Path) -> Path:
    if (real := Path(os.path.realpath(path))).is_symlink():
        raise InputError(f"{path} cannot be written: it is a loop of links")
    return real


def printable(text: str) -> str:
    """Text from a file as it may stand on a terminal: what is not to be seen is escaped."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape", "surrogatepass").decode() for c in text)


@contextmanager
def last_states_beside(output: Path | None) -> Iterator[None]:
    """Keep the last states of a simulation that leaves the numbers, as a table beside its output."""
    try:
        yield
    except SimulationError as error:
        if output is None or error.states is None:
            raise
        table = output.with_name(f"{output.stem}.diverged.csv")
        write_text(table, error.states.table())
        raise SimulationError(
            f"{error}; {table} holds the last {len(error.states.time)} states", error.states
        ) from error
