"""What methods share: cases as data, causes as plain data, and one answer file a case."""

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from boom_mj.blind.run import read_case as opened
from boom_mj.diagnosis.scoring import Scored
from boom_mj.estimation.dataset import Dataset
from boom_mj.estimation.intervals import Z95
from boom_mj.systems.boom.system import BoomSystem
from boom_mj.systems.predictor import Predictor

Answer = dict[str, Any]


@dataclass(frozen=True, eq=False)
class Case:
    """A case of a set.

    Attributes:
        without: ids of effects that a method must do without.
        system, data: the nominal boom and its recordings.
    """

    name: str
    without: tuple[str, ...]
    system: BoomSystem
    data: Dataset

    def predictor(self, data: Dataset | None = None) -> Predictor:
        """Simulations of its recordings, on one thread."""
        return Predictor(self.system, data or self.data, threads=1)


def read_case(folder: Path) -> Case:
    """A case from its folder, DIR/CASE."""
    read = opened(folder)
    if not isinstance(read.system, BoomSystem):
        raise SystemExit(f"{folder.parent}: methods here are for booms")
    without = json.loads((folder / "withhold.json").read_text())["without"]
    return Case(folder.name, tuple(without), read.system, read.data)


def case_folders(cases: Path) -> list[Path]:
    """Folders of a set's cases, in the order of their names."""
    return sorted(path.parent for path in cases.glob("*/withhold.json"))


def parser(method: str) -> argparse.ArgumentParser:
    """Arguments of every method: the set, and the folder of its answers."""
    found = argparse.ArgumentParser(description=method)
    found.add_argument("cases", type=Path, help="folder of a set of cases")
    found.add_argument("-o", "--output", type=Path, required=True, help="folder for the answers")
    return found


def answer_all(cases: Path, output: Path, solve: Callable[[Case], Answer]) -> None:
    """Answer every case that has no answer yet, on one core, each with the processor seconds that it took."""
    output.mkdir(parents=True, exist_ok=True)
    for folder in case_folders(cases):
        path = output / f"{folder.name}.json"
        if not path.exists():
            began = time.process_time()
            with threadpool_limits(1):
                answer = solve(read_case(folder))
            path.write_text(json.dumps({**answer, "cpu_s": time.process_time() - began}, indent=1) + "\n")
            print(path, answer["verdict"], *(cause["id"] for cause in answer["effects"]))


def cause_of(found: Scored, number: int, probability: float | None = None) -> dict[str, Any]:
    """An effect of a fit with 95 % intervals of its sizes."""
    effect, sizes = found.fit.effects[number], {}
    for k, (owner, name, parameter) in enumerate(found.fit.candidate.parameters):
        if owner == number:
            reach = Z95 * found.deviation[k]
            low, high = sorted(parameter.value(found.fit.scaled[k] + side * reach) for side in (-1, 1))
            ends = {"low": low, "high": high if high < float("inf") else None}
            sizes[name] = {"value": effect.values[name], **ends, "unit": parameter.unit}
    return {"id": effect.id, "location": effect.location, "parameters": sizes, "probability": probability}
