"""An example of a method: a few effects are tried, and the one that moves the boom most like it moved is named.

python benchmarks/methods/example.py cases answers
"""

import json
import sys
from pathlib import Path

import numpy as np

from boom_mj import Machine, Recording, load_machine, make_plant, parse_effect, read_log, replay
from boom_mj.effects import Effect
from boom_mj.replay import residual
from boom_mj.sensors import noise_levels

TRIED = ("tip_payload:mass=40", "end_hose:mass=40", "link_mass:link=5,factor=1.1", "structural_damping:factor=2")
ENOUGH = 0.95  # of the misfit without an effect, that one must leave to be named


def misfit(machine: Machine, effects: list[Effect], logs: list[Recording]) -> float:
    """Root mean square of measured - simulated without its means, over the sensors' noise."""
    plant, noise, squares = make_plant(machine, 2, effects), noise_levels(machine), []
    for log in logs:
        left = residual(log, replay(plant, log).twin)
        squares += [np.nanvar(left[name].values, axis=0) / noise[name] ** 2 for name in noise if name in left]
    return float(np.sqrt(np.mean(np.concatenate(squares))))


def answer(case: Path) -> dict:
    """The answer to one case, DIR/CASE."""
    machine = load_machine(case.parent / "machine.toml")
    logs = [read_log(path) for path in sorted((case / "train").glob("*.mcap"))]
    without = json.loads((case / "withhold.json").read_text())["without"]
    effects = [parse_effect(text) for text in TRIED]
    left = {effect: misfit(machine, [effect], logs) for effect in effects if effect.id not in without}
    best, nominal = min(left, key=left.get), misfit(machine, [], logs)
    if left[best] < ENOUGH * nominal:
        return {"verdict": "explained", "effects": [{"id": best.id, "location": best.location}]}
    return {"verdict": "consistent" if nominal < 1.5 else "unexplained", "effects": []}


if __name__ == "__main__":
    cases, answers = Path(sys.argv[1]), Path(sys.argv[2])
    answers.mkdir(exist_ok=True)
    for path in sorted(cases.glob("*/train")):
        (answers / f"{path.parent.name}.json").write_text(json.dumps(answer(path.parent)))
