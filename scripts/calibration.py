"""Planted truth: machines about boom36 that are calibrated from their own noisy recordings. Prints the table.

python scripts/calibration.py FOLDER [--machines 50] [--first 0] [--jobs 1 | --cluster ADDRESS] [--table FILE.md]
                              [--experiments EXPERIMENT ...] [--free KIND ...]
                              [--tracked EXPERIMENT ... [--filmed FROM TO EVERY SCALE]]

Stiffness +-20 %, masses +-10 %, damping x 0.5 to 2, zero offsets of joints +-0.3 deg, all drawn evenly; the paper's
experiments, or some of them, with six hinges per elastic coordinate and sensor noise; calibrated with two to four. Only
kinds that are free differ from boom36. Every machine leaves a file in FOLDER: what is there is not made again, so that
the campaign can be stopped and started at any time. `--tracked` takes the markers of some experiments from rendered
pictures through `track` instead (minutes each; needs MUJOCO_GL=egl).
"""

import argparse
import json
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from boom_mj.calibration import calibrate, document
from boom_mj.calibration.experiments import PAPER
from boom_mj.calibration.parameters import STIFFNESS, USUAL, Parameterisation, Variant, make_parameterisation
from boom_mj.files import write_text
from boom_mj.logs import read_mcap, write_mcap
from boom_mj.machine import load_machine
from boom_mj.recording import Recording
from boom_mj.sensors import record
from boom_mj.simulation import make_plant, run_experiment
from boom_mj.spreading import results
from boom_mj.systems.boom.corrected import with_effects_text

Array = np.ndarray
ROOT = Path(__file__).parents[1]
FILE = ROOT / "models" / "boom36.toml"
NOMINAL = load_machine(FILE)
HINGES = 6
SPREAD = {"mass": 0.1, **dict.fromkeys(STIFFNESS, 0.2)}  # half widths of factors about 1
DAMPING, OFFSET_DEG = (0.5, 2.0), 0.3
GOALS = {"mass": 0.01, **dict.fromkeys(STIFFNESS, 0.01), "damping": 0.05}
SURE = 1.96
FILMED = ("4", "14", "4", "1")  # first and last second, every so many frames, scale: of a tracked experiment


@dataclass(frozen=True)
class Order:
    """One machine of the campaign."""

    folder: Path
    number: int
    experiments: tuple[str, ...] = tuple(plan.name for plan in PAPER)
    free: tuple[str, ...] = USUAL
    tracked: tuple[str, ...] = ()
    filmed: tuple[str, ...] = FILMED

    def __str__(self) -> str:
        return self.file.stem

    @property
    def file(self) -> Path:
        return self.folder / f"machine{self.number:03d}{'_tracked' if self.tracked else ''}.json"


def draw(free: Parameterisation, rng: np.random.Generator) -> Array:
    """Scaled parameters of a machine, (free.size,)."""
    factors = [
        np.exp(rng.uniform(*np.log(DAMPING)))
        if group.kind == "damping"
        else 1 + SPREAD[group.kind] * rng.uniform(-1, 1)
        for group in free.tied
    ]
    return np.concatenate([np.log(factors), np.radians(OFFSET_DEG) * rng.uniform(-1, 1, 5)])


def recordings(truth: Variant, order: Order) -> list[Recording]:
    """What the sensors of a machine say in the paper's experiments."""
    plant = make_plant(truth.machine, HINGES, truth.sensor)
    found = []
    for k, plan in enumerate(PAPER):
        if plan.name not in order.experiments:
            continue
        rng = np.random.default_rng([order.number, k])
        log = record(run_experiment(plant, plan), plan, rng)
        found.append(with_tracked_markers(log, truth, order) if plan.name in order.tracked else log)
    return found


def with_tracked_markers(log: Recording, truth: Variant, order: Order) -> Recording:
    """The recording with markers that cameras saw, over the seconds that were filmed."""
    work = order.folder / f"machine{order.number:03d}_{log.name}"
    work.mkdir(parents=True, exist_ok=True)
    machine, source, markers = work / "machine.toml", work / "log.mcap", work / "markers.mcap"
    if not markers.exists():
        machine.write_text(truth_text(truth))
        write_mcap(log, source)
        boom = [sys.executable, "-m", "boom_mj"]
        filmed = [word for pair in zip(("--start", "--stop", "--every", "--scale"), order.filmed) for word in pair]
        shown = ["--machine", machine, "--hinges", HINGES, "--jpeg", 90, "--jobs", 1, *filmed]
        for line in (["render", source, "-o", work / "pictures", *shown], ["track", work / "pictures", "-o", markers]):
            subprocess.run([*boom, *map(str, line)], check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
    return log.with_signals({"markers": read_mcap(markers)["markers"]})


def truth_text(truth: Variant) -> str:
    """The true machine as a file: boom36 with other numbers."""
    from boom_mj.calibration.answer import replaced_text

    values = {}
    for group in make_parameterisation(NOMINAL).tied:
        (parameter,) = group.parameters
        section = ("damping", 0) if parameter.link is None else ("link", parameter.link - 2)
        values.update({(*section, field): value for field, value in parameter.values(truth.machine).items() if value})
    return with_effects_text(replaced_text(FILE.read_text(), values), truth.sensor)


def one(order: Order) -> None:
    """Make, record and calibrate one machine."""
    free = make_parameterisation(NOMINAL, order.free)
    scaled = draw(free, np.random.default_rng(order.number))
    logs = recordings(free.at(scaled), order)
    found = calibrate(NOMINAL, logs, order.free, threads=1)
    answer = document(found, [log.name for log in logs])
    joined = {parameter["name"] for parameter in answer["parameters"] if parameter["with"]}
    rows = [
        {
            "name": name,
            "truth": float(x),
            "found": float(y),
            "deviation": None if np.isnan(s) or name in joined else float(s),
        }
        for name, x, y, s in zip(free.names, scaled, found.scaled, found.deviation)
    ]
    result = {"scaled": rows, "wall_s": found.duration, "tracked": list(order.tracked), "answer": answer}
    write_text(order.file, json.dumps(result, indent=1))


def table(folder: Path) -> str:
    """Errors, coverage and run times of all machines that are there."""
    results = [json.loads(path.read_text()) for path in sorted(folder.glob("machine*.json"))]
    lines = [
        f"{len(results)} machines; errors in percent; intervals: share of 95 % intervals that hold the truth",
        "",
        "| parameter | median error | 90 % of errors below | widest interval, +- | intervals | held or joined |",
        "|---|---|---|---|---|---|",
    ]
    rows = [row for result in results for row in result["scaled"]]
    names = dict.fromkeys(row["name"] for row in rows if "offset" not in row["name"])
    kinds = dict.fromkeys(name.rpartition(".")[2] for name in names)
    for name in (*(f"all {kind}" for kind in kinds), *names):
        own = [r for r in rows if r["name"] == name or (name[:4] == "all " and r["name"].endswith(name[4:]))]
        told = [r for r in own if r["deviation"] is not None]
        held = f"{len(own) - len(told)} of {len(own)}"
        if not told:
            lines.append(f"| {name} | | | | | {held} |")
            continue
        error = np.abs([r["found"] - r["truth"] for r in told])
        reach = SURE * np.array([r["deviation"] for r in told])
        lines.append(
            f"| {name} | {100 * np.median(error):.2f} | {100 * np.quantile(error, 0.9):.2f} | "
            f"{100 * reach.max():.2f} | {np.mean(error <= reach):.1%} | {held} |"
        )
    told = [r for r in rows if r["deviation"] is not None and "offset" not in r["name"]]
    inside = np.mean([abs(r["found"] - r["truth"]) <= SURE * r["deviation"] for r in told])
    wall = np.array([result["wall_s"] for result in results])
    lines += ["", f"All intervals: {inside:.1%} of {len(told)} hold the truth."]
    lines += [f"Wall time of a calibration: median {np.median(wall):.0f} s, longest {wall.max():.0f} s."]
    return "\n".join(lines)


def main() -> None:
    """Calibrate what is missing, print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--machines", type=int, default=50)
    parser.add_argument("--first", type=int, default=0, help="number of the first machine, which seeds it")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--cluster", metavar="ADDRESS")
    names = [plan.name for plan in PAPER]
    parser.add_argument("--experiments", nargs="+", default=names, choices=names)
    parser.add_argument("--free", nargs="+", default=USUAL, choices=USUAL)
    parser.add_argument("--tracked", nargs="*", default=(), choices=names)
    parser.add_argument("--filmed", nargs=4, default=FILMED, metavar=("FROM", "TO", "EVERY", "SCALE"))
    parser.add_argument("--table", type=Path)
    given = parser.parse_args()
    given.folder = given.folder.resolve()
    given.folder.mkdir(parents=True, exist_ok=True)
    orders = [
        Order(
            given.folder,
            number,
            tuple(given.experiments),
            tuple(given.free),
            tuple(given.tracked),
            tuple(given.filmed),
        )
        for number in range(given.first, given.first + given.machines)
    ]
    missing = [order for order in orders if not order.file.exists()]
    began = time.monotonic()
    for done, _ in enumerate(results(one, missing, given.jobs, given.cluster), 1):
        left = (time.monotonic() - began) / done * (len(missing) - done)
        print(f"{done} of {len(missing)}, about {left / 60:.0f} min left", file=sys.stderr, flush=True)
    text = table(given.folder)
    if given.table:
        write_text(given.table, f"{text}\n")
    print(text)


if __name__ == "__main__":
    main()
