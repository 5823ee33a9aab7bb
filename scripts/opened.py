"""Cases of opened seals, diagnosed by the code as it is: what the published answer said, and what today's says.

    python scripts/opened.py SEAL ANSWERS WORK [--classes pair,withheld] [--most 2] -o TABLE.md

SEAL and ANSWERS are unpacked from docs/results/blind/*.tar.xz. Effects and nuisances of the seal are simulated anew by
today's plant, so that only the noise differs. A development figure: these seals are open. Cases whose answer is in WORK
stay; a run that was stopped goes on.
"""

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from boom_mj.blind.boom_bench import SUITE
from boom_mj.blind.grading import judge_case
from boom_mj.blind.plant import true_plant
from boom_mj.effects import Effect, make_effect
from boom_mj.logs import write_mcap
from boom_mj.machine import load_machine
from boom_mj.sensors import record
from boom_mj.simulation import run_experiment

COLUMNS = "case", "class", "sealed", "published", "right", "today", "right", "gap", "CPU s", "MB"
HEADER = f"| {' | '.join(COLUMNS)} |\n{'|---' * len(COLUMNS)}|\n"


def effects_of(sealed: dict[str, Any]) -> list[Effect]:
    """Effects and nuisances of a seal; zero offsets of 0.1 stand in one entry."""
    found = []
    for one in (*sealed["nuisances"], *sealed["effects"]):
        place, values = one["location"], one["parameters"]
        if one["id"] == "joint_zero_offset" and not place:
            found += [make_effect(one["id"], {"joint": int(k[5:]), "offset": v}) for k, v in values.items()]
        else:
            found.append(make_effect(one["id"], {**place, **values}))
    return found


def diagnosed(name: str, sealed: dict[str, Any], without: list[str], most: int) -> dict[str, Any]:
    """Record the case anew and ask the command line."""
    rng = np.random.default_rng(list(sha256(name.encode()).digest()))
    plant = true_plant(load_machine("boom36"), effects_of(sealed))
    with tempfile.TemporaryDirectory() as folder:
        paths: dict[str, list[str]] = {}
        for part in ("train", "holdout"):
            for experiment in getattr(SUITE, part):
                path = Path(folder) / f"{part}_{experiment.name}.mcap"
                write_mcap(record(run_experiment(plant, experiment), experiment, rng), path)
                paths.setdefault(part, []).append(str(path))
        command = [sys.executable, "-m", "boom_mj", "gap", "diagnose", *paths["train"], "--holdout", *paths["holdout"]]
        command += ["--json", "-", "--quiet", "--most", str(most)]
        command += [word for effect in without for word in ("--without", effect)]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {**json.loads(done.stdout), "cpu_s": spent, "peak_mb": after.ru_maxrss / 1024}


def brief(answer: dict[str, Any]) -> str:
    """Verdict and effects in a cell."""
    effects = [f"{e['id']} {' '.join(map(str, e['location'].values()))}".strip() for e in answer["effects"]]
    return f"{answer['verdict']}: {' + '.join(effects) or '-'}"


def main() -> None:
    """Ask and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seal", type=Path)
    parser.add_argument("answers", type=Path)
    parser.add_argument("work", type=Path)
    parser.add_argument("--classes", default="single,pair,withheld,none")
    parser.add_argument("--most", type=int, default=2)
    parser.add_argument("-o", type=Path, required=True, dest="table")
    given = parser.parse_args()
    given.work.mkdir(parents=True, exist_ok=True)
    rows = []
    for name, sealed in json.loads(given.seal.read_text())["cases"].items():
        if sealed["class"] not in given.classes.split(","):
            continue
        published, kept = json.loads((given.answers / f"{name}.json").read_text()), given.work / f"{name}.json"
        if not kept.exists():
            kept.write_text(json.dumps(diagnosed(name, sealed, published.get("without", []), given.most), indent=1))
        today = json.loads(kept.read_text())
        truth = brief({"verdict": sealed["class"], "effects": sealed["effects"]}).split(": ")[1]
        cells = [name, sealed["class"], truth]
        for answer in (published, today):
            cells += [brief(answer), "yes" if judge_case(name, sealed, answer).right else "no"]
        cells += [f"{today['gap']['holdout']['after']:.3f}", f"{today['cpu_s']:.0f}", f"{today['peak_mb']:.0f}"]
        rows.append(f"| {' | '.join(cells)} |")
        print(rows[-1], flush=True)
        given.table.write_text(HEADER + "\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
