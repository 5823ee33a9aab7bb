"""The answer as one document of plain data: all that others read."""

from collections.abc import Sequence
from importlib.metadata import version
from typing import Any

import numpy as np

from boom_mj.diagnosis.diagnose import Diagnosis
from boom_mj.diagnosis.localisation import in_words, locate, looks_like
from boom_mj.diagnosis.named import brief, described
from boom_mj.diagnosis.sentences import rival, sentence
from boom_mj.estimation.bootstrap import gap

RIVALS = 8  # listed


def document(found: Diagnosis, names: Sequence[str]) -> dict[str, Any]:
    """The answer in plain data: verdict, effects, rivals, ties, gaps, where, what is left.

    Of an "unexplained" gap `effects` are the causes that close most of it, if there are any; what closes less is listed
    as "suspect".
    """
    data, best = found.model.data, found.best
    cells = locate(found.model, found.nominal)
    after = found.residual
    gaps = {
        part: {"before": gap(found.nominal, rows), "after": gap(after, rows), "floor": 1.0}
        for part, rows in (("train", data.train), ("holdout", data.held_out))
    }
    listed = [vars(cell) for cell in cells if cell.share >= found.criteria.shown_share]
    rest = 1 - sum(cell["share"] for cell in listed)
    causes, certain = described(found) if best else [], found.solved or found.closure.low > found.criteria.named_closure
    answer = {
        "verdict": found.verdict,
        "sentence": sentence(found),
        "effects": causes if certain else [],
        "suspect": [] if certain else causes,
        "rivals": [rival(found, other) for other in found.scored if other is not best][:RIVALS],
        "ties": [[brief(j.fit.effects) for j in (best, *found.ties)]] if best and found.ties else [],
        "next_experiment": found.next_experiment,
        "gap": {
            **gaps,
            "closure": found.closure.value,
            "closure_interval": [found.closure.low, found.closure.high],
            "fidelity_alone": found.fidelity_alone,
            "split_in_time": data.split_in_time,
        },
        "where": [*listed, {"sensor": "all others", "share": rest}],
        "pushes": [vars(force) for force in found.forces],
        "unexplained": None,
        "provenance": {
            "machine": found.model.facts.name,
            "recordings": {
                "train": list(names[: data.training]),
                "holdout": list(names[data.training :]),
                "learnt_in_part": [data.recordings[k].name for k in sorted(data.extended)],
            },
            **found.model.facts.provenance,
            "simulated_s": found.model.predictor.simulated_s,
            "boom_mj": version("boom_mj"),
            "mujoco": version("mujoco"),
        },
    }
    if found.verdict == "unexplained":
        left = gaps["holdout"]["after"] ** 2 - 1
        share = left / max(gaps["holdout"]["before"] ** 2 - 1, 1e-9)
        remaining = locate(found.model, after)
        answer["unexplained"] = {
            "share": float(np.clip(share, 0, 1)),
            "looks_like": looks_like(found.model, after),
            "where": in_words(remaining),
            "learn_from": [data.recordings[k].name for k in found.not_trained],
        }
    return _plain(answer)


def _plain(value: Any) -> Any:
    """Numbers that JSON can hold: infinities and NaN as null."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value
