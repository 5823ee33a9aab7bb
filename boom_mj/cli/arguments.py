"""Arguments that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

from boom_mj.errors import InputError
from boom_mj.machine import Beam, Machine, load_machine, load_model

MachineFile = Annotated[str, typer.Argument(metavar="MACHINE.toml", help="Machine file, or a name such as boom36.")]
Hinges = Annotated[int, typer.Option(min=1, max=32, help="Equivalent hinges per elastic coordinate of each link.")]
MODELS = tuple(folder / "models" for folder in (Path(__file__).parents[1], Path(__file__).parents[2]))


def find_machine(name: str) -> Machine:
    """A machine from a file, or from the models that come with the package by its name."""
    return load_machine(_machine_path(name))


def find_model(name: str) -> Machine | Beam:
    """A machine of any kind, found like `find_machine`."""
    return load_model(_machine_path(name))


def machine_text(name: str) -> str:
    """The text of a machine file, found like `find_machine`."""
    return _machine_path(name).read_text()


def _machine_path(name: str) -> Path:
    if not Path(name).suffix:
        for folder in MODELS:
            if (folder / f"{name}.toml").is_file():
                return folder / f"{name}.toml"
    return Path(name)


def output_path(path: Path, suffix: str) -> Path:
    """Refuse an output that cannot be before any work is done."""
    if path.suffix != suffix:
        raise InputError(f"{path}: the output of this command is a {suffix} file")
    if not path.resolve().parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.resolve().parent}")
    return path
