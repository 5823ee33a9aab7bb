"""What the truth itself leaves of every gap: by how much the model is wrong where a diagnosis could not be right.

    python scripts/truths.py CASES --seal SEAL [--jobs 2]

A machine with the sealed effects, large and small, its nuisances estimated, should leave 1 in training and held out,
but for chance and for what every plant has and its model lacks.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from boom_mj.blind.run import read_case
from boom_mj.diagnosis.linearisation import Linearisation, linearise
from boom_mj.effects import Effect, make_effect
from boom_mj.errors import EffectError
from boom_mj.estimation.bootstrap import gap
from boom_mj.spreading import spread
from boom_mj.systems.predictor import Predictor


def left(case: Path, effects: Sequence[dict[str, Any]]) -> tuple[float, float, float, bool] | None:
    """Gaps (held out as built, training and held out with sealed effects), and whether that is more than an explanation
    may leave; None where the library does not hold them."""
    read = read_case(case)
    sites = read.system.sites()
    try:
        true = tuple(make_effect(e["id"], {**e["location"], **e["parameters"]}, sites) for e in effects)
    except EffectError:
        return None
    model = linearise(Predictor(read.system, read.data, threads=1))
    about = model.relinearised(true, model.posterior.estimate(_residual(model, true)))
    clean = about.clean(_residual(about, true))
    before = gap(model.clean(_residual(model, ())), read.data.held_out)
    training, held_out = gap(clean, read.data.train), gap(clean, read.data.held_out)
    return before, training, held_out, max(training, held_out) > model.criteria.explained_gap


def _residual(model: Linearisation, effects: tuple[Effect, ...]) -> Any:
    return model.residual(*model.predict([effects]))


def _row(case: Path, sealed: dict[str, Any]) -> str:
    effects = sealed[case.name]["effects"]
    found = left(case, [*effects, *sealed[case.name].get("clutter", ())])
    names = ", ".join(" ".join(map(str, (e["id"], *e["location"].values()))) for e in effects) or "none"
    if found is None:
        return f"| `{case.name}` | {names} | not in the library | | | |"
    *gaps, more = found
    cells = [f"`{case.name}`", names, *(f"{gap:.3f}" for gap in gaps), "**more than noise**" * more]
    return f"| {' | '.join(cells)} |"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", type=Path)
    parser.add_argument("--seal", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    sealed = json.loads(options.seal.read_text())["cases"]
    work = partial(_row, sealed=sealed)
    print("| case | truth | as built, held out | training | held out | |\n" + "|---" * 6 + "|")
    for done in spread(work, [options.cases / name for name in sealed], options.jobs):
        print(done.result(), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
