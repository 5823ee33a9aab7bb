"""Arguments that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

from boom_mj.errors import InputError
from boom_mj.machine import Machine, load_machine, machine_file

MachineFile = Annotated[str, typer.Argument(metavar="MACHINE.toml", help="Machine file, or a name such as boom36.")]
Hinges = Annotated[int, typer.Option(min=1, max=32, help="Equivalent hinges per elastic coordinate of each link.")]
Jobs = Annotated[int, typer.Option("--jobs", min=1, help="Processes of this machine that share the work.")]
Cluster = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="Dask scheduler whose workers share it instead; they see the same folders."),
]


def find_machine(name: str) -> Machine:
    """A machine from a file, or from the models that come with the package by its name."""
    return load_machine(name)


def machine_text(name: str) -> str:
    """The text of a machine file, found like `load_machine`."""
    return machine_file(name).read_text()


def output_path(path: Path, suffix: str) -> Path:
    """Refuse an output that cannot be before any work is done."""
    if path.suffix != suffix:
        raise InputError(f"{path}: the output of this command is a {suffix} file")
    if not path.resolve().parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.resolve().parent}")
    return path
