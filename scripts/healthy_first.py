"""What healthy logs are worth: machines as built, diagnosed in three ways; prints tables.

    python scripts/healthy_first.py --commit ID [--machines 20] [--jobs 2] [--keep FILE.jsonl]

Every machine is drawn as it was built (masses 2 %, stiffness 3 %, damping 25 % off, joints zeroed within 0.3 deg) and
records the short suite twice, with noise of its own: when it was well, and later with one effect of the library, or, as
often, with none. It is diagnosed by its data sheet alone, by the file that `calibrate` makes of the healthy logs, and
with `--healthy`. The SHA-256 of the commit's id and "healthy first" is the seed. What is done is kept line by line in
FILE.jsonl, and a second call goes on.
"""

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from boom_mj.blind.boom_bench import SHORT
from boom_mj.blind.detectability import Detectability
from boom_mj.blind.grading import judge_case
from boom_mj.blind.plant import AS_BUILT, nuisances, true_plant
from boom_mj.blind.sampling import Order, draw_all, known_effects
from boom_mj.calibration import USUAL, calibrate, calibrated_text
from boom_mj.cli.arguments import machine_text
from boom_mj.diagnosis.answer import document
from boom_mj.diagnosis.diagnose import diagnose
from boom_mj.diagnosis.healthy import as_built
from boom_mj.effects import Effect
from boom_mj.errors import EquilibriumError, SimulationError
from boom_mj.logs import read_log, write_mcap
from boom_mj.machine import Machine, load_machine, parse_machine
from boom_mj.recording import Recording
from boom_mj.sensors import record
from boom_mj.simulation import run_experiment
from boom_mj.spreading import spread
from boom_mj.systems.boom.load import checked_data
from boom_mj.systems.boom.system import BoomSystem
from boom_mj.systems.predictor import Predictor
from boom_mj.systems.system import System

NAME = "boom36"
MACHINE = load_machine(NAME)
EXPERIMENTS = (*SHORT.train, *SHORT.holdout)
WAYS = ("data sheet", "calibrate", "--healthy")
Logs = list[Recording]


@dataclass(frozen=True)
class Task:
    """A machine: its number, its effect (none if empty), and the entropy of the set."""

    number: int
    effect: str
    entropy: tuple[int, ...]

    def __str__(self) -> str:
        return f"machine {self.number}"


def tried(task: Task) -> dict[str, Any]:
    """Truth and answers of one machine."""
    rng = np.random.default_rng((*task.entropy, task.number))
    healthy, later, truth, _ = recorded([task.effect] if task.effect else [], rng)
    ways: dict[str, Callable[[], System]] = {
        WAYS[0]: lambda: BoomSystem(MACHINE),
        WAYS[1]: lambda: BoomSystem(calibrated(healthy)),
        WAYS[2]: lambda: as_built(BoomSystem(MACHINE), healthy),
    }
    return {
        "number": task.number,
        "truth": truth,
        "answers": {way: answered(system, later, truth) for way, system in ways.items()},
    }


def recorded(names: Sequence[str], rng: np.random.Generator) -> tuple[Logs, Logs, dict[str, Any], tuple[Effect, ...]]:
    """Logs of a machine that was well, later ones with effects, what is true of these, and how it was built."""
    seen = [Detectability(MACHINE, part) for part in (SHORT.train, SHORT.holdout)]

    def shows(effects: Sequence[Effect]) -> float:
        return min(eye.visibility(effects) for eye in seen) if effects else 0.0

    while True:
        own = nuisances(MACHINE, rng, AS_BUILT)
        drawn = draw_all(Order("several", tuple(names), ""), rng, shows)
        effects = [effect for effect, _ in drawn]
        try:
            logs = [
                [record(run_experiment(plant, e), e, rng) for e in EXPERIMENTS]
                for plant in (true_plant(MACHINE, own), true_plant(MACHINE, changed(own, effects)))
            ]
            break
        except (EquilibriumError, SimulationError):
            continue  # the coarse model stood it, the fine one does not
    truth = {
        "class": ("none", "single", "pair")[len(names)] if len(names) < 3 else "several",
        "effects": [{"id": e.id, "location": e.location, "parameters": values} for e, values in drawn],
        "visibility": shows(effects),
    }
    return stored(logs[0]), stored(logs[1]), truth, own


def changed(own: Sequence[Effect], effects: Sequence[Effect]) -> list[Effect]:
    """A machine as built with effects: what is off already is changed by as much."""
    here = {e.cause: e for e in own}
    for effect in effects:
        if before := here.get(effect.cause):
            off = {
                n: (v * before.values[n] if n == "factor" else v + before.values[n]) for n, v in effect.values.items()
            }
            here[effect.cause] = type(effect)(effect.site, **off)
        else:
            here[effect.cause] = effect
    return list(here.values())


def stored(logs: Logs) -> Logs:
    """As they come back from files."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder) / f"{log.name}.mcap" for log in logs]
        for log, path in zip(logs, paths):
            write_mcap(log, path)
        return [read_log(path) for path in paths]


def calibrated(healthy: Logs) -> Machine:
    """The file that `calibrate` makes of them."""
    found = calibrate(MACHINE, healthy, USUAL, tell=lambda line: None)
    return parse_machine(calibrated_text(machine_text(NAME), found))


def answered(system: Callable[[], System], later: Logs, truth: dict[str, Any]) -> dict[str, Any]:
    """The diagnosis of later logs, in short."""
    began = time.process_time()
    built = system()
    boom = built if isinstance(built, BoomSystem) else BoomSystem(MACHINE)
    checked = checked_data(boom, later, len(SHORT.train), built=built)
    said = document(diagnose(Predictor(built, checked.data, threads=1)), checked.names, checked.findings)
    found = judge_case("", truth, said)
    return {
        "verdict": said["verdict"], "effects": said["effects"], "gap": said["gap"], "named": found.answer,
        "right": found.right and found.placed, "errors": found.errors, "cpu_s": time.process_time() - began,
    }  # fmt: skip


def table(rows: list[dict[str, Any]]) -> str:
    """How often each way was right, and machine by machine, as Markdown."""
    ill, well = ([r for r in rows if bool(r["truth"]["effects"]) == there] for there in (True, False))
    lines = ["| | data sheet alone | after `calibrate` | `--healthy` |", "|---|---|---|---|"]

    def line(name: str, value: Callable[[str], str]) -> None:
        lines.append(f"| {name} | " + " | ".join(value(way) for way in WAYS) + " |")

    def errors(way: str) -> list[float]:
        return [abs(error) for r in ill for error in r["answers"][way]["errors"]]

    line("effect and place named", lambda w: f"{sum(r['answers'][w]['right'] for r in ill)} of {len(ill)}")
    line("sizes in their intervals", lambda w: f"{sum(e <= 1 for e in errors(w))} of {len(errors(w))}")
    line("healthy called ill", lambda w: f"{sum(not r['answers'][w]['right'] for r in well)} of {len(well)}")
    line("CPU s, median", lambda w: f"{np.median([r['answers'][w]['cpu_s'] for r in rows]):.0f}")
    lines += ["", "| machine | truth | " + " | ".join(WAYS) + " |", "|---|---|" + "---|" * len(WAYS)]
    for row in sorted(rows, key=lambda r: r["number"]):
        cells = [f"{a['verdict']}: {', '.join(map(in_words, a['effects'])) or '-'}" for a in row["answers"].values()]
        true = ", ".join(map(in_words, row["truth"]["effects"])) or "none"
        lines.append(f"| {row['number']} | {true} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def in_words(effect: dict[str, Any]) -> str:
    """Of a truth or of an answer."""
    sizes = [
        f"{name} {size:.4g}" if isinstance(size, float) else f"{name} {size['value']:.4g}{ends(size)}"
        for name, size in effect["parameters"].items()
    ]
    return " ".join([effect["id"], *(f"{k} {v}" for k, v in effect["location"].items()), ", ".join(sizes)])


def ends(size: dict[str, Any]) -> str:
    """Of an interval, if it has any."""
    return "" if None in (size["low"], size["high"]) else f" ({size['low']:.4g} to {size['high']:.4g})"


def entropy_of(commit: str, campaign: str) -> tuple[int, ...]:
    """Of a campaign that tries a commit."""
    return tuple(int(w) for w in np.frombuffer(sha256(f"{commit}{campaign}".encode()).digest(), "<u4"))


def all_rows(
    work: Callable[[Any], dict[str, Any]], tasks: Sequence[Any], keep: Path, jobs: int
) -> list[dict[str, Any]]:
    """Results of numbered tasks; those that a file holds are done, others are added to it one by one."""
    rows = [json.loads(line) for line in keep.read_text().splitlines()] if keep.exists() else []
    done = {row["number"] for row in rows}
    for finished in spread(work, [task for task in tasks if task.number not in done], jobs):
        rows.append(finished.result())
        with keep.open("a") as stream:
            stream.write(json.dumps(rows[-1]) + "\n")
        print(f"{len(rows)} of {len(tasks)}", file=sys.stderr, flush=True)
    return rows


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--commit", required=True, help="that is tried")
    parser.add_argument("--machines", type=int, default=20, help="with an effect; as many without")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--keep", type=Path, default=Path("healthy_first.jsonl"))
    options = parser.parse_args()
    entropy = entropy_of(options.commit, "healthy first")
    drawn = np.random.default_rng(entropy).permutation(known_effects())
    effects = [name for k in range(options.machines) for name in (str(drawn[k % len(drawn)]), "")]
    tasks = [Task(k, name, entropy) for k, name in enumerate(effects)]
    rows = all_rows(tried, tasks, options.keep, options.jobs)
    print(table(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
