"""Whether true sizes are inside intervals, where all of the truth is named and where half of what is small is not.

    python scripts/sizes.py CASES... --seals FOLDER [--jobs 2]

Sizes are fitted from the sealed ones, with the search left out: what is asked is whether an answer that names the right
causes says how unsure their sizes are, by residuals alone and by what else there may be a little (`diagnosis.unnamed`).
"""

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from boom_mj.blind.run import read_case
from boom_mj.diagnosis.candidate import Candidate, everywhere
from boom_mj.diagnosis.fitting import fit
from boom_mj.diagnosis.linearisation import Linearisation, linearise
from boom_mj.diagnosis.scoring import Scored, score
from boom_mj.diagnosis.unnamed import allowing_for_others
from boom_mj.effects import Effect, make_effect
from boom_mj.estimation.intervals import Z95
from boom_mj.spreading import spread
from boom_mj.systems.predictor import Predictor

ROUNDS = 3  # about the machine that the last has found
Size = tuple[bool, bool, bool, float, float]  # small; inside, before and with others; reach over size, both


def fitted(model: Linearisation, effects: tuple[Effect, ...]) -> Scored:
    """About the machine that these effects make, again and again."""
    for _ in range(ROUNDS):
        model = model.relinearised(effects, model.posterior.estimate(model.residual(*model.predict([effects]))))
        scored = score(model, fit(model, Candidate(effects)))
        effects = scored.fit.effects
    return scored


def sizes(scored: Scored, true: Sequence[Effect], large: int) -> Iterator[Size]:
    """Of every parameter, the first effects being the large ones."""
    wide = allowing_for_others(scored, everywhere(scored.model.system))
    for k, (owner, name, parameter) in enumerate(scored.fit.candidate.parameters):
        size = parameter.coordinate(true[owner].values[name])
        reach = [Z95 * one.deviation[k] for one in (scored, wide)]
        inside = [bool(abs(scored.fit.scaled[k] - size) <= end) for end in reach]
        yield owner >= large, *inside, reach[0] / abs(size), reach[1] / abs(size)


def of_case(case: Path, seals: Path, most: float) -> tuple[list[Size], list[Size]]:
    """Sizes with all that is small, and with half of it left out, by the case's name; none above a gap."""
    read = read_case(case)
    model = linearise(Predictor(read.system, read.data, threads=1))
    entry: dict[str, Any] = json.loads((seals / f"{case.parent.name}.seal").read_text())["cases"][case.name]
    sites, parts = read.system.sites(), (entry["effects"], entry.get("clutter", ()))
    large, small = ([make_effect(e["id"], {**e["location"], **e["parameters"]}, sites) for e in part] for part in parts)
    small = [effect for effect in small if effect.free(effect.site)]
    half = np.random.default_rng(int(case.name, 16)).permutation(len(small))[: len(small) // 2]
    found: list[list[Size]] = []
    for others in (small, [small[k] for k in sorted(half)]):
        true = (*large, *others)
        scored = fitted(model, true) if true else None
        found.append(list(sizes(scored, true, len(large))) if scored and scored.train < most else [])
    return found[0], found[1]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", type=Path, nargs="+", help="sets of opened cases")
    parser.add_argument("--seals", type=Path, required=True, help="folder with the seal of each, NAME.seal")
    parser.add_argument("--most", type=float, default=30.0, help="training gap up to which a fit counts (default 30)")
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    cases = [path.parent for folder in options.cases for path in sorted(folder.glob("*/withhold.json"))]
    found: tuple[list[Size], list[Size]] = [], []
    for done in spread(partial(of_case, seals=options.seals, most=options.most), cases, options.jobs):
        for part, own in zip(found, done.result()):
            part.extend(own)
    print("| named | sizes | inside by residuals | with others | reach over size, median | with others |")
    print("|---" * 6 + "|")
    for said, part in zip(("all", "half of what is small"), found):
        for kind, own in (("large", [s for s in part if not s[0]]), ("small", [s for s in part if s[0]])):
            _, before, after, reach, wide = np.array(own or [(0,) * 5], float).T
            counts = f"{len(own)} {kind} | {before.sum():.0f} | {after.sum():.0f}"
            print(f"| {said} | {counts} | {np.median(reach):.3f} | {np.median(wide):.3f} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
