"""Sweeps: one experiment over ranges of machine values and of effects, as a grid or at random.

    DIR/sweep.json      what is swept; another sweep does not go into the folder
    DIR/000012.mcap     the recording of a point
    DIR/000012.json     its row of the table, written last: a point that has its row is done
    DIR/table.csv       all rows

A point depends on its number alone, so that a sweep goes on where it was stopped, and random draws can be continued.
"""

import csv
import io
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
from operator import itemgetter
from pathlib import Path
from typing import Any, Self

import numpy as np

from boom_mj.effects import Effect, Equipped, parse_effect
from boom_mj.errors import EquilibriumError, InputError, SimulationError
from boom_mj.files import locked, read_json, write_text
from boom_mj.logs import write_mcap
from boom_mj.machine import Machine, with_values
from boom_mj.sensors import boom_scene, record
from boom_mj.simulation import Experiment, Trajectory, make_plant, run_experiment
from boom_mj.spreading import spread

FORM = (
    "a range reads PLACE=LOW..HIGH/N or EFFECT:key=value,...,PARAMETER=LOW..HIGH/N; without /N where points are drawn"
)


@dataclass(frozen=True)
class Axis:
    """A number that varies.

    Attributes:
        owner: an effect with its place, "link_mass:link=3"; empty for the machine.
        name: a parameter of the effect, or a place in the machine file, such as "link3.mass".
        low, high: range.
        count: values of a grid, evenly from low to high; None where points are drawn.
    """

    owner: str
    name: str
    low: float
    high: float
    count: int | None = None

    def __str__(self) -> str:
        return f"{self.owner}{',' if ':' in self.owner else ':'}{self.name}" if self.owner else self.name

    @classmethod
    def parse(cls, text: str) -> Self:
        """An axis from `PLACE=LOW..HIGH/N` or `EFFECT:key=value,...,PARAMETER=LOW..HIGH/N`; /N may be missing.

        Raises:
            InputError: the text reads otherwise.
        """
        where, _, span = text.rpartition("=")
        owner, _, name = where.rpartition("," if "," in where else ":")
        low, _, rest = span.partition("..")
        high, slash, count = rest.partition("/")
        try:
            found = cls(owner, name, float(low), float(high), int(count) if slash else None)
        except ValueError as error:
            raise InputError(f"--sweep {text}: {FORM}") from error
        if not name or not np.isfinite([found.low, found.high]).all() or found.count == 0:
            raise InputError(f"--sweep {text}: {FORM}")
        return found


@dataclass(frozen=True)
class Point:
    """A point of a sweep: its number, and a value for every axis."""

    number: int
    values: tuple[float, ...]

    def __str__(self) -> str:
        return f"point {self.number:06d}"


@dataclass(frozen=True)
class Sweep:
    """What is simulated: an experiment on a machine whose values vary.

    Attributes:
        effects: that every point has.
        draws: number of points drawn evenly from all ranges; None for a grid.
        noise: whether sensors have theirs.
        seed: of draws and noise.
        scene: whether recordings show the boom moving.
    """

    machine: Machine
    experiment: Experiment
    axes: tuple[Axis, ...]
    hinges: int = 1
    effects: tuple[Effect, ...] = ()
    draws: int | None = None
    noise: bool = True
    seed: int = 0
    scene: bool = False

    def __len__(self) -> int:
        return self.draws if self.draws is not None else int(np.prod([axis.count or 0 for axis in self.axes]))

    def points(self) -> Iterator[Point]:
        """All points in order; the last axis of a grid varies fastest."""
        if self.draws is None:
            grid = product(*(np.linspace(axis.low, axis.high, axis.count or 0).tolist() for axis in self.axes))
            yield from (Point(number, values) for number, values in enumerate(grid))
            return
        for number in range(self.draws):
            rng = np.random.default_rng((self.seed, 0, number))
            yield Point(number, tuple(float(rng.uniform(axis.low, axis.high)) for axis in self.axes))

    def at(self, values: Sequence[float]) -> tuple[Machine, list[Effect]]:
        """Machine and effects of a point.

        Raises:
            InputError: no such place or effect, or a value out of bounds.
        """
        places: dict[str, float] = {}
        owners: dict[str, list[str]] = {}
        for axis, value in zip(self.axes, values):
            if axis.owner:
                owners.setdefault(axis.owner, []).append(f"{axis.name}={value!r}")
            else:
                places[axis.name] = value
        texts = [f"{owner}{',' if ':' in owner else ':'}{','.join(pairs)}" for owner, pairs in owners.items()]
        return with_values(self.machine, places), [*self.effects, *map(parse_effect, texts)]

    def check(self) -> None:
        """Raises InputError: axes given twice or without their counts, ends of ranges that cannot be."""
        for k, axis in enumerate(self.axes):
            if str(axis) in map(str, self.axes[:k]):
                raise InputError(f"--sweep {axis}: given twice")
            if self.draws is None and axis.count is None:
                raise InputError(f"--sweep {axis}: say how many values, {axis.low:g}..{axis.high:g}/N, or --draws")
            if self.draws is not None and axis.count is not None:
                raise InputError(f"--sweep {axis}: a range that is drawn from has no /{axis.count}")
        for values in ([axis.low for axis in self.axes], [axis.high for axis in self.axes]):
            self.at(values)

    def document(self) -> dict[str, Any]:
        """What makes it another sweep; more draws do not."""
        return {
            "machine": self.machine.model_dump(mode="json"),
            "experiment": self.experiment.model_dump(mode="json"),
            "axes": [asdict(axis) for axis in self.axes],
            "hinges": self.hinges,
            "effects": [repr(effect) for effect in self.effects],
            "drawn": self.draws is not None,
            "noise": self.noise,
            "seed": self.seed,
            "scene": self.scene,
        }


def run_sweep(
    sweep: Sweep, folder: Path, jobs: int = 1, cluster: str | None = None
) -> Iterator[tuple[int, BaseException | None]]:
    """Simulate the points that a folder does not hold yet, then write the table.

    The files are the same to the byte however the work was spread and however often it was interrupted.

    Args:
        folder: new, empty, or begun with the same sweep.
        jobs, cluster: see `spread`.

    Yields:
        How many points are done, and what went wrong with the last one, if its recording could not be written.

    Raises:
        InputError: ranges that cannot be, or a folder that holds something else.
        OutputError: another process fills the folder, or it cannot be written.
    """
    sweep.check()
    with locked(folder):
        _claim(folder, sweep.document())
        waiting = [point for point in sweep.points() if not _row(folder, point).exists()]
        done = len(sweep) - len(waiting)
        yield done, None
        for ended in spread(
            Equipped(partial(simulate_point, sweep=sweep, folder=folder.resolve())), waiting, jobs, cluster
        ):
            if ended.error is None:
                write_text(_row(folder, ended.item), json.dumps(ended.result(), indent=1) + "\n")
            done += 1
            yield done, ended.error
        write_text(folder / "table.csv", _table(read_rows(folder)))


def read_rows(folder: Path) -> list[dict[str, Any]]:
    """Rows of the points that are done, in order: number, values, recording and figures, or the error."""
    rows = [read_json(path, InputError) for path in folder.glob("[0-9]*.json")]
    return sorted(rows, key=itemgetter("point"))


def simulate_point(point: Point, sweep: Sweep, folder: Path) -> dict[str, Any]:
    """Simulate a point and write its recording; its row of the table, with the error of one that cannot be."""
    given = {str(axis): value for axis, value in zip(sweep.axes, point.values)}
    row: dict[str, Any] = {"point": point.number, **given}
    try:
        machine, effects = sweep.at(point.values)
        trajectory = run_experiment(make_plant(machine, sweep.hinges, effects), sweep.experiment)
    except (InputError, EquilibriumError, SimulationError) as error:
        return {**row, "error": str(error)}
    said = "; ".join((sweep.experiment.description, *(f"{name} = {value:.9g}" for name, value in given.items())))
    rng = np.random.default_rng((sweep.seed, 1, point.number)) if sweep.noise else None
    named = sweep.experiment.model_copy(update={"description": said})
    scene = boom_scene(trajectory) if sweep.scene else None
    write_mcap(record(trajectory, named, rng), folder / f"{point.number:06d}.mcap", scene=scene)
    return {**row, "recording": f"{point.number:06d}.mcap", **figures(trajectory)}


def figures(trajectory: Trajectory) -> dict[str, float]:
    """A motion in a few numbers: the tip's start, end and range, m, and the least and largest cylinder forces, N."""
    tip = trajectory.sensor(f"marker{len(trajectory.plant.machine.sensors.markers_x) * 4}")
    found = {}
    for name, values in (("tip_start", tip[0]), ("tip_end", tip[-1]), ("tip_range", np.ptp(tip, axis=0))):
        found.update({f"{name}_{axis}": float(value) for axis, value in zip("xyz", values)})
    for k, force in enumerate(trajectory.cylinder_force.T):
        found |= {f"cylinder{k + 2}_min": float(force.min()), f"cylinder{k + 2}_max": float(force.max())}
    return found


def _row(folder: Path, point: Point) -> Path:
    return folder / f"{point.number:06d}.json"


def _table(rows: Sequence[dict[str, Any]]) -> str:
    """Rows as CSV; columns in the order in which they first appear, the error last."""
    columns = dict.fromkeys(name for row in rows for name in row if name != "error")
    text = io.StringIO()
    writer = csv.DictWriter(text, [*columns, "error"], restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _claim(folder: Path, wanted: dict[str, Any]) -> None:
    """Make a folder the sweep's own, or find it begun."""
    path = folder / "sweep.json"
    if not any(folder.iterdir()):
        write_text(path, json.dumps(wanted, indent=1) + "\n")
        return
    if not path.is_file():
        raise InputError(f"{folder} holds something that is no sweep: choose an empty or a new folder")
    if (there := read_json(path, InputError)) != wanted:
        differs = [key for key in wanted if not isinstance(there, dict) or there.get(key) != wanted[key]]
        raise InputError(
            f"{folder} holds another sweep (it differs in {', '.join(differs)}): give the same arguments to finish "
            "it, or another folder"
        )
