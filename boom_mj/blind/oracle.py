"""Who is to blame for a miss, once the seal is open: the truth itself is simulated as an explanation would be.

Where it leaves no more than noise, the model holds what happened and the search did not find it. Where it leaves more,
the model is wrong, or the way in which it reads a log, and no search can help.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from boom_mj.blind.figures import Score
from boom_mj.blind.run import read_case
from boom_mj.diagnosis.linearisation import linearise
from boom_mj.effects import make_effect
from boom_mj.errors import InputError
from boom_mj.estimation.bootstrap import gap
from boom_mj.files import read_json
from boom_mj.spreading import results
from boom_mj.systems.predictor import Predictor

LISTED = ("single", "clutter", "pair", "several", "withheld")  # classes whose effects the library holds


def with_hindsight(
    found: Score, folder: Path, seal: Path, jobs: int = 1, tell: Callable[[int, int], None] = lambda done, total: None
) -> Score:
    """The score of a set with what the truth leaves of every miss that the library could have named.

    Args:
        jobs: processes on this machine.
        tell: hears how many of how many misses are done.
    """
    sealed = read_json(seal, InputError)["cases"]
    missed = [o.case for o in found.outcomes if o.reason and o.kind in LISTED]
    items = [((folder / case).resolve(), sealed[case]["effects"]) for case in missed]
    left: dict[str, float] = {}
    for (path, _), value in results(left_by_truth, items, jobs):
        left[path.name] = value
        tell(len(left), len(items))
    outcomes = tuple(replace(o, truth_leaves=left.get(o.case, np.nan)) for o in found.outcomes)
    return replace(found, outcomes=outcomes)


def left_by_truth(item: tuple[Path, Sequence[Mapping[str, Any]]]) -> float:
    """Held-out gap of a case that the effects sealed for it leave, with nuisances fitted and their own model error.

    Of the effects as far as a diagnosis simulates them: the gusts of a wind are estimated, in every recording.
    """
    case, sealed = item
    read = read_case(case)
    whole = [make_effect(e["id"], {**e["location"], **e["parameters"]}, read.system.sites()) for e in sealed]
    effects = tuple(type(e)(e.site, **{name: e.values[name] for name in e.free(e.site)}) for e in whole)
    healthy = linearise(Predictor(read.system, read.data, threads=1))
    model = healthy.rebased(effects, np.zeros(len(healthy.nuisances)))
    model = model.relinearised(effects, model.posterior.estimate(model.residual(model.base)))
    return gap(model.clean(model.residual(model.base)), model.data.held_out)
