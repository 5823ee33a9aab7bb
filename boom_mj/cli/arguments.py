"""Arguments that several commands share."""

import glob
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from boom_mj.errors import InputError, MachineFileError, SimulationError
from boom_mj.files import read_json, read_text, sweep, write_text

if TYPE_CHECKING:
    from boom_mj.machine import Beam, Machine

EXPERIMENTS = (  # names in `simulation.CATALOGUE`, which takes longer to import than help may take
    "release_stretched_vertical", "release_stretched_horizontal", "release_bow_vertical", "release_bow_horizontal",
    "release_stretched_vertical_half", "slew_t", "sweep", "fold_in", "fold_in_300", "mixed", "chirp_joint2",
    "chirp_joint4", "slew_tour", "hold",
)  # fmt: skip

MachineFile = Annotated[str, typer.Argument(metavar="MACHINE.toml", help="Machine file, or a name such as boom36.")]
Hinges = Annotated[int, typer.Option(min=1, max=32, help="Equivalent hinges per elastic coordinate of each link.")]
Jobs = Annotated[int, typer.Option("--jobs", min=1, help="Processes of this machine that share the work.")]
Most = Annotated[
    int | None,
    typer.Option(min=1, metavar="N", help="Most causes of an explanation; what suits the machine if left out."),
]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON document on stdout; `schema` says what it holds.")]
Cluster = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="Dask scheduler whose workers share it instead; they see the same folders."),
]

ChannelMapFile = Annotated[
    Path | None, typer.Option("--map", metavar="MAP.toml", help="Any machine: what the fields of its logs are.")
]
ModelFile = Annotated[Path | None, typer.Option(metavar="MODEL.xml", help="Its MJCF file; the map's if left out.")]
LogsMachine = Annotated[str | None, typer.Option(help="Machine file or name; the logs' own if left out.")]
AnswerFile = Annotated[str | None, typer.Option("--json", metavar="FILE", help="Answer as JSON; - for stdout.")]
AnswerPage = Annotated[Path | None, typer.Option(metavar="FILE", help="Answer as a page with pictures.")]
Seconds = Annotated[
    float | None, typer.Option("--time", min=0, metavar="S", help="Seconds after which nothing more is refined.")
]


def _load(paths: list[Path] | None) -> list[Path] | None:
    for path in paths or ():
        from boom_mj.effects import load_effects

        load_effects(path)
    return paths


EffectFiles = Annotated[
    list[Path] | None,
    typer.Option(
        "--effects",
        metavar="FILE.py",
        callback=_load,
        is_eager=True,
        help="Effects of your own that act and compete like ours; several may be given.",
    ),
]


def find_machine(name: str) -> "Machine":
    """A machine from a file, or from the models that come with the package by its name."""
    from boom_mj.machine import load_machine

    return load_machine(name)


def find_model(name: str) -> "Machine | Beam":
    """A machine of any kind, found like `find_machine`."""
    from boom_mj.machine import load_model

    return load_model(name)


def machine_text(name: str) -> str:
    """The text of a machine file, found like `load_machine`."""
    from boom_mj.machine import machine_file

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


def check_machine(machine: str | None, channels: Path | None, model: Path | None) -> None:
    """Refuse options of a boom and of any other machine together."""
    if model is not None and channels is None:
        raise InputError("--model needs a channel map: say which field of the log is what with --map MAP.toml")
    if channels is not None and machine is not None:
        raise InputError("--machine goes with booms only; with --map the model is --model MODEL.xml")


def stopwatch() -> Callable[[str], None]:
    """What prints lines on stderr, each after the seconds since now."""
    began = time.perf_counter()

    def tell(line: str) -> None:
        print(f"{time.perf_counter() - began:6.1f} s  {line}", file=sys.stderr)

    return tell


def begins_afresh(table: Path | None = None) -> str:
    """What work says that begins anew in every call; of a best so far that a stopped call left in a table, too."""
    try:
        so_far = table is not None and table.is_file() and read_json(table, InputError).get("complete") is False
    except (InputError, AttributeError):
        so_far = False
    return "begins afresh" + (f"; {table} holds what a call that was stopped had found" if so_far else "")


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
