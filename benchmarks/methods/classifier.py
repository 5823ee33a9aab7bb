"""A classifier: a random forest on features of the residual, trained on simulated cases of the same plant.

    python -m boom_mj gap blind make --cases 2000 --mix single=80,none=14,stranger=6 --short \\
        --seed-file training.bin -o training --seal training.seal
    python benchmarks/methods/classifier.py cases -o answers --training training --seal training.seal --count 2000

Classes are effects at their places, nothing, and what the library lacks. Features of every channel of every recording:
the mean of its whitened residual, without nuisances, and the logarithm of its mean square in each frequency band. Their
sensitivities are those of the first training case, so that answering takes no simulation unless samples are missing.
The probability of a withheld effect counts as that of something outside the library. Needs `boom_mj[bench]`.
"""

import json
from collections.abc import Mapping
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from cases import Answer, Case, answer_all, case_folders, parser, read_case

from boom_mj.diagnosis.linearisation import Linearisation, linearise
from boom_mj.diagnosis.localisation import bands

Array = np.ndarray
NOTHING, OUTSIDE = "nothing", "outside"
TREES = 500


def features(model: Linearisation, case: Case) -> Array:
    """Of a case about the machine of another with the same experiments, (f,)."""
    data, facts = case.data, model.facts
    if len(data.time) != len(model.base):  # a clock that is late leaves fewer samples
        model = linearise(case.predictor())
    white = np.where(data.used, model.clean(model.noise.white(data.measured - model.base - model.mean_error)), 0.0)
    found = []
    for number in range(len(data.channels)):
        series = white[data.stretch(number)]
        parts = [part for _, part in bands(series, facts.bands_hz, data.block_s)]
        found += [series.mean(), *(np.log(np.mean(part**2) + 1e-12) for part in parts)]
    return np.array(found)


def label(truth: Mapping[str, Any]) -> str:
    """The class of a sealed case."""
    if truth["class"] == "stranger":
        return OUTSIDE
    named = [{"id": effect["id"], "location": effect["location"]} for effect in truth["effects"]]
    return json.dumps(named[0], sort_keys=True) if named else NOTHING


def solve(case: Case, model: Linearisation, forest: Any) -> Answer:
    """The most probable class of a case."""
    probability = dict.fromkeys((NOTHING, OUTSIDE), 0.0)
    for name, share in zip(forest.classes_, forest.predict_proba([features(model, case)])[0]):
        barred = name.startswith("{") and json.loads(name)["id"] in case.without
        name = OUTSIDE if barred else str(name)
        probability[name] = probability.get(name, 0.0) + float(share)
    best = max(probability, key=lambda name: probability[name])
    answer = {"others": {"none": probability[NOTHING], "outside_library": probability[OUTSIDE]}, "effects": []}
    if best in (NOTHING, OUTSIDE):
        return {**answer, "verdict": "consistent" if best == NOTHING else "unexplained"}
    return {**answer, "verdict": "explained", "effects": [{**json.loads(best), "probability": probability[best]}]}


def train(folder: Path, seal: Path, count: int) -> tuple[Linearisation, Any]:
    """The forest of a set whose seal is open, and the machine of its first case."""
    from sklearn.ensemble import RandomForestClassifier

    truths = json.loads(seal.read_text())["cases"]
    model, rows, labels = None, [], []
    for path in islice(case_folders(folder), count):
        case = read_case(path)
        model = model or linearise(case.predictor())
        rows.append(features(model, case))
        labels.append(label(truths[path.name]))
    forest = RandomForestClassifier(TREES, min_samples_leaf=1, class_weight="balanced", random_state=0)
    return model, forest.fit(rows, labels)


if __name__ == "__main__":
    arguments = parser(__doc__)
    arguments.add_argument("--training", type=Path, required=True, help="folder of a set of cases to train with")
    arguments.add_argument("--seal", type=Path, required=True, help="its seal, open")
    arguments.add_argument("--count", type=int, default=2000, help="how many of its cases")
    given = arguments.parse_args()
    model, forest = train(given.training, given.seal, given.count)
    answer_all(given.cases, given.output, partial(solve, model=model, forest=forest))
