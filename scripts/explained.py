"""What explanations of opened seals leave, where they are right and where they are not, by how large the gap was.

    python scripts/explained.py docs/results/{blind,benchmark}/*.tar.xz

From published answers; nothing is simulated. A gap is the larger of training and held out.
"""

import argparse
import json
import tarfile
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from boom_mj.blind.grading import judge_case
from boom_mj.diagnosis.criteria import BOOM

PARTS = "train", "holdout"
EDGES = 1.0, 2.0, 5.0, 10.0, 20.0, np.inf
HEADER = "| | gap as built | answers | 5 % | median | 95 % | largest | more than `explained_gap` |\n" + "|---" * 8 + "|"


def read(archive: Path) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    """Sealed cases with effects, and their answers."""
    with tarfile.open(archive) as files:
        texts = {m.name: f.read() for m in files if m.name.endswith((".json", ".seal")) and (f := files.extractfile(m))}
    documents = {name: json.loads(text) for name, text in texts.items()}
    sealed = {case: truth for name, d in documents.items() if "seal" in name for case, truth in d["cases"].items()}
    for name, answer in documents.items():
        truth = sealed.get(Path(name).stem, {"effects": []})
        if truth["effects"] and answer.get("gap", {}).get("train"):
            yield truth, answer


def row(label: str, where: str, left: Any) -> str:
    """Quantiles of what is left."""
    figures = [f"{q:.3f}" for q in np.quantile(left, [0.05, 0.5, 0.95, 1.0])]
    return f"| {' | '.join([label, where, str(len(left)), *figures, str(np.sum(left > BOOM.explained_gap))])} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("archives", type=Path, nargs="+")
    found = [pair for archive in parser.parse_args().archives for pair in read(archive)]
    found = [(sealed, answer) for sealed, answer in found if answer["verdict"] in ("explained", "ambiguous")]
    gaps = np.array([[max(a["gap"][p][k] for p in PARTS) for k in ("before", "after")] for _, a in found])
    right = np.array([judge_case("", sealed, answer).placed for sealed, answer in found])
    print(HEADER)
    for label, mine in (("right", right), ("wrong", ~right)):
        for low, high in pairwise(EDGES):
            here = mine & (gaps[:, 0] >= low) & (gaps[:, 0] < high)
            if here.any():
                print(row(label, f"{low:g} to {high:g}" if np.isfinite(high) else f"{low:g} and more", gaps[here, 1]))
        print(row(label, "all", gaps[mine, 1]))


if __name__ == "__main__":
    main()
