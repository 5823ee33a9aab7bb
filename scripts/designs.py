"""What a designed experiment brings: ties of the diagnosis, and what another recording makes of them; prints tables.

    python scripts/designs.py --commit ID [--ties 10] [--jobs 2] [--keep FILE.jsonl]

Every boom has one effect of the library, drawn with its place and size from the SHA-256 of the commit's id and
"designs". Like machines in service it has encoders and pressure sensors, no markers and no IMUs, and it was asked for
nothing but the same cut rope twice, stretched, once for training and once held out: what other poses would tell apart
is a tie. The plant of the blind check records it.
Where the answer is a tie, `designed` plans another experiment of at most 60 s; the same boom records it, the
catalogue's best and the median of the random ones, each once for training and once held out, and each is diagnosed with
what was there. What is done is kept line by line in FILE.jsonl, and a second call goes on; booms without a tie are
counted, too.
"""

import argparse
import json
import sys
import time
from collections import Counter
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from healthy_first import in_words, stored

from boom_mj.blind.detectability import Detectability
from boom_mj.blind.grading import judge_case
from boom_mj.blind.plant import nuisances, true_plant
from boom_mj.blind.sampling import draw, known_effects
from boom_mj.diagnosis.answer import document
from boom_mj.diagnosis.diagnose import diagnose
from boom_mj.errors import EquilibriumError, SimulationError
from boom_mj.machine import Machine, load_machine
from boom_mj.recording import Recording
from boom_mj.sensors import record
from boom_mj.simulation import CATALOGUE, Experiment, Plant, run_experiment
from boom_mj.spreading import spread
from boom_mj.systems.boom.design import asked_of, designed
from boom_mj.systems.boom.load import checked_data
from boom_mj.systems.boom.system import BoomSystem
from boom_mj.systems.predictor import Predictor

ABSENT, NOTHING = ("accelerometer", "gyroscope", "marker_xz", "marker_y"), 1e3  # times the noise that a sensor has
LEAST = 0.1  # root mean square of what an effect changes, in noise
PLAN = CATALOGUE["release_stretched_vertical"]
SECONDS, LOAD = 60.0, 981.0  # that another experiment may last; N, that a rope may pull with
WAYS = ("designed", "catalogue's best", "median random")
BEFORE = "before"
Rng = np.random.Generator


def in_service(machine: Machine) -> Machine:
    """The machine whose other sensors say nothing."""
    noise = machine.sensors.noise
    levels = {name: NOTHING * getattr(noise, name) for name in ABSENT}
    sensors = machine.sensors.model_copy(update={"noise": noise.model_copy(update=levels)})
    return machine.model_copy(update={"sensors": sensors})


MACHINE = in_service(load_machine("boom36"))
Row = dict[str, Any]


@dataclass(frozen=True)
class Task:
    """A boom: its number, its effect, and the seed."""

    number: int
    effect: str
    seed: int

    def __str__(self) -> str:
        return f"boom {self.number}"


def tried(task: Task) -> Row:
    """Truth and answers of one boom."""
    rng = np.random.default_rng([task.seed, task.number])
    seen = Detectability(MACHINE, (PLAN,))
    own = nuisances(MACHINE, rng)
    effect, values = draw(task.effect, rng, seen.visibility)
    shows = seen.visibility([effect])
    row: Row = {"number": task.number, "shows": shows, "answers": {}}
    row["truth"] = {
        "class": "single",
        "effects": [{"id": effect.id, "location": effect.location, "parameters": values}],
        "visibility": shows,
    }
    if shows < LEAST:
        return row
    try:
        plant = true_plant(MACHINE, (*own, effect))
        train, held_out = ([recorded(plant, PLAN, rng)] for _ in range(2))
    except (EquilibriumError, SimulationError):
        return row
    said, row["answers"][BEFORE] = answered(train, held_out, row["truth"])
    if not said["ties"]:
        return row
    plan = designed(MACHINE, asked_of(said, str(task)), SECONDS, LOAD, rng=rng)
    for way, rated in zip(WAYS, (plan.best, plan.catalogue, plan.random)):
        if rated is None:
            continue
        experiment, outlook = rated
        more = [recorded(plant, experiment, rng) for _ in range(2)]
        _, answer = answered([*train, more[0]], [*held_out, more[1]], row["truth"])
        row["answers"][way] = {**answer, "experiment": experiment.name, "apart": outlook.separation}
    return row


def recorded(plant: Plant, plan: Experiment, rng: Rng) -> Recording:
    """As it comes back from a file."""
    return stored([record(run_experiment(plant, plan), plan, rng)])[0]


def answered(train: list[Recording], held_out: list[Recording], truth: Row) -> tuple[Row, Row]:
    """An answer, and the same in short."""
    began, boom = time.process_time(), BoomSystem(MACHINE)
    checked = checked_data(boom, [*train, *held_out], len(train))
    said = document(diagnose(Predictor(boom, checked.data, threads=1)), checked.names, checked.findings)
    found, (true,) = judge_case("", truth, said), truth["effects"]
    tied = [[one["id"], one["location"]] for tie in said["ties"] for one in tie]
    return said, {
        "verdict": said["verdict"], "effects": said["effects"], "gap": said["gap"], "named": found.answer,
        "right": found.right and found.placed and not tied, "tied": tied,
        "held": [true["id"], true["location"]] in tied, "cpu_s": time.process_time() - began,
    }  # fmt: skip


def table(rows: list[Row]) -> str:
    """What became of ties, counted and one by one, as Markdown."""
    asked = [row for row in rows if BEFORE in row["answers"]]
    ties = [row for row in asked if row["answers"][BEFORE]["tied"]]
    known = sum(row["answers"][BEFORE]["held"] for row in ties)
    lines = [f"{len(asked)} booms were diagnosed; {len(ties)} ended in a tie, {known} of which hold the true effect."]
    lines += ["", "| | " + " | ".join(WAYS) + " |", "|---|" + "---|" * len(WAYS)]
    counts = {way: Counter(outcome(row["answers"].get(way)) for row in ties) for way in WAYS}
    for name in OUTCOMES:
        lines.append(f"| {name} | " + " | ".join(str(counts[way][name]) for way in WAYS) + " |")
    apart = {way: [row["answers"][way]["apart"] for row in ties if way in row["answers"]] for way in WAYS}
    lines.append(
        "| expected, median sd | " + " | ".join(f"{np.median(apart[way] or [np.nan]):.3g}" for way in WAYS) + " |"
    )
    lines += ["", "| boom | truth | tie | " + " | ".join(WAYS) + " |", "|---|---|---|" + "---|" * len(WAYS)]
    for row in sorted(ties, key=lambda row: row["number"]):
        tied = " or ".join(dict.fromkeys(words(*one) for one in row["answers"][BEFORE]["tied"]))
        cells = []
        for way in WAYS:
            answer = row["answers"].get(way)
            cells.append(f"{answer['experiment']}, {answer['apart']:.3g} sd: {outcome(answer)}" if answer else "none")
        lines.append(f"| {row['number']} | {in_words(row['truth']['effects'][0])} | {tied} | {' | '.join(cells)} |")
    return "\n".join(lines)


OUTCOMES = ("right", "still a tie, with the truth", "still a tie, without it", "wrong name", "nothing named", "none")


def outcome(answer: Row | None) -> str:
    """Of one answer, one of `OUTCOMES`."""
    if answer is None:
        return OUTCOMES[-1]
    if answer["right"]:
        return OUTCOMES[0]
    if answer["tied"]:
        return OUTCOMES[1 if answer["held"] else 2]
    return OUTCOMES[3 if answer["effects"] and answer["verdict"] != "unexplained" else 4]


def words(name: str, location: Row) -> str:
    """An effect and its place."""
    return " ".join([name, *(f"{key} {value}" for key, value in location.items())])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--commit", required=True, help="that is tried")
    parser.add_argument("--ties", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--keep", type=Path, default=Path("designs.jsonl"))
    options = parser.parse_args()
    seed = int.from_bytes(sha256(f"{options.commit}designs".encode()).digest())
    drawn = np.random.default_rng(seed).permutation(known_effects())
    rows = [json.loads(line) for line in options.keep.read_text().splitlines()] if options.keep.exists() else []
    done = {row["number"] for row in rows}

    def enough() -> bool:
        return sum(bool(row["answers"].get(BEFORE, {}).get("tied")) for row in rows) >= options.ties

    tasks = (
        Task(k, str(drawn[k % len(drawn)]), seed) for k in range(20 * options.ties) if k not in done and not enough()
    )
    for finished in spread(tried, tasks, options.jobs):
        rows.append(finished.result())
        with options.keep.open("a") as stream:
            stream.write(json.dumps(rows[-1]) + "\n")
        last = rows[-1]["answers"]
        print(
            f"{len(rows)} booms; {finished.item}: {last.get(BEFORE, {}).get('verdict', 'not asked')}", file=sys.stderr
        )
    print(table(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
