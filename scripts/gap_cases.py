"""Diagnose every case of a folder (CASE/train, CASE/holdout, perhaps CASE/truth.json), one table row each.

python scripts/gap_cases.py CASES -o TABLE.md [--answers ANSWERS.json] [--work DIR]

Answers are kept case by case in the work folder, so that a run that was stopped goes on where it was.
"""

import argparse
import json
import time
from pathlib import Path

from boom_mj.cli.arguments import find_machine
from boom_mj.diagnosis import diagnose, document
from boom_mj.diagnosis.clock import Clock
from boom_mj.files import write_text
from boom_mj.logs import read_log
from boom_mj.systems.boom import BoomSystem
from boom_mj.systems.predictor import Predictor, dataset_of


def answer_of(case: Path) -> dict:
    """The diagnosis of one case, with its wall time."""
    began = time.perf_counter()
    train, held_out = (sorted(case.glob(f"{part}/*.mcap")) for part in ("train", "holdout"))
    recordings = [read_log(path) for path in (*train, *held_out)]
    system = BoomSystem(find_machine(recordings[0].machine))
    predictor = Predictor(system, dataset_of(system, recordings, len(train)))
    clock = Clock(tell=lambda line: print(f"  {time.perf_counter() - began:6.1f} s  {line}", flush=True))
    found = diagnose(predictor, clock=clock)
    answer = document(found, [path.stem for path in (*train, *held_out)])
    return {**answer, "wall_s": time.perf_counter() - began}


def brief(effects: list[dict], sizes: str) -> str:
    """Effects in a table's words; `sizes` is the key of their parameters."""
    words = []
    for effect in effects:
        place = " ".join(f"{k} {v}" for k, v in effect["location"].items())
        values = {k: v["value"] if isinstance(v, dict) else v for k, v in effect[sizes].items()}
        size = ", ".join(f"{k} {v:.4g}" if isinstance(v, (int, float)) else f"{k} {v}" for k, v in values.items() if v)
        words.append(f"{effect['id']} {place} ({size})" if effect["id"] != "none" else "none")
    return " + ".join(words) or "-"


def main() -> None:
    """Diagnose, print and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", type=Path)
    parser.add_argument("-o", type=Path, required=True)
    parser.add_argument("--answers", type=Path)
    parser.add_argument("--work", type=Path, default=Path("out/gap_cases"))
    given = parser.parse_args()
    given.work.mkdir(parents=True, exist_ok=True)
    answers = {}
    for case in sorted(path for path in given.cases.iterdir() if path.is_dir()):
        kept = given.work / f"{case.name}.json"
        if not kept.exists():
            print(case.name, flush=True)
            answer = answer_of(case)
            write_text(kept, json.dumps(answer, indent=1))
        answers[case.name] = json.loads(kept.read_text())
        print(case.name, answers[case.name]["sentence"], flush=True)
    head = "| case | truth | verdict | answer | gap held out | closure | ties | s |"
    rows = [head, "|---" * 8 + "|"]
    for name, answer in answers.items():
        truth = given.cases / name / "truth.json"
        told = brief(json.loads(truth.read_text())["effects"], "magnitude") if truth.exists() else "sealed"
        gaps, closed = answer["gap"]["holdout"], answer["gap"]
        low, high = closed["closure_interval"]
        rivals = answer["ties"][0][1:] if answer["ties"] else []
        ties = "; ".join(" + ".join(e["id"] for e in (one, *one.get("with", ()))) for one in rivals)
        rows.append(
            f"| {name} | {told} | {answer['verdict']} | {brief(answer['effects'], 'parameters')} | "
            f"{gaps['before']:.2f} -> {gaps['after']:.2f} | {closed['closure']:.3f} [{low:.3f}, {high:.3f}] | {ties} | "
            f"{answer['wall_s']:.0f} |"
        )
    write_text(given.o, "\n".join(rows) + "\n")
    if given.answers:
        kept_keys = ("verdict", "sentence", "effects", "ties", "remainder", "next_experiment")
        short = {n: {**{k: a[k] for k in kept_keys}, "closure": a["gap"]["closure"]} for n, a in answers.items()}
        write_text(given.answers, json.dumps(short, indent=1) + "\n")


if __name__ == "__main__":
    main()
