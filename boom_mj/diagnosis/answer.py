"""The answer as one document of plain data: all that others read."""

from collections.abc import Sequence
from importlib.metadata import version
from typing import Any

import numpy as np

from boom_mj.diagnosis.conclusion import Diagnosis
from boom_mj.diagnosis.localisation import in_words, locate, looks_like
from boom_mj.diagnosis.named import described, probability_of_all, sized
from boom_mj.diagnosis.predictions import estimated_nuisances, nuisances
from boom_mj.diagnosis.readings import outlier_findings
from boom_mj.diagnosis.sentences import other_laws, rival, sentence
from boom_mj.diagnosis.steps import ChannelSteps, nuisance_sizes
from boom_mj.estimation.bootstrap import gap
from boom_mj.replay.quality import DataFinding

RIVALS = 8  # listed


def document(
    found: Diagnosis,
    names: Sequence[str],
    findings: Sequence[DataFinding] = (),
    channels: Sequence[ChannelSteps] = (),
) -> dict[str, Any]:
    """The answer in plain data: verdict, effects, rivals, ties, gaps, where, what is left.

    Args:
        names: of the recordings, training first.
        findings: what is wrong with them.
        channels: their gaps from the machine file to the explanation, `channel_steps`; simulating them takes a while.

    Of an explanation `effects` are the causes that are sure; others, and what closes some of an "unexplained" gap, are
    listed as "suspect". Shares of budget, remainder and floor add up to 1.
    """
    data, best, raw = found.model.data, found.best, found.model.residual(found.model.base)
    cells = locate(found.model, found.as_built)
    after = found.residual
    gaps = {
        part: {
            "nominal": gap(raw, rows),
            "before": gap(found.as_built, rows),
            "after": gap(after, rows),
            "floor": min(1.0, gap(after, rows)),
        }
        for part, rows in (("train", data.train), ("holdout", data.held_out))
    }
    listed = [vars(cell) for cell in cells if cell.share >= found.criteria.shown_share]
    rest = 1 - sum(cell["share"] for cell in listed)
    causes = _causes(found)
    budget = _budget(found) if causes["effects"] else []
    remainder = None if found.solved or found.verdict == "consistent" else _remainder(found, bool(budget))
    answer = {
        "verdict": found.verdict,
        "sentence": sentence(found),
        "probability": probability_of_all(found),
        **causes,
        "others": {
            "outside_library": found.odds.outside_library,
            "none": found.odds.none,
            "combination": found.odds.combination,
        },
        "rivals": [rival(found, other) for other in found.scored if other is not best][:RIVALS],
        "ties": [[sized(j) for j in (best, *found.ties)]] if best and found.ties else [],
        "next_experiment": found.next_experiment,
        "gap": {
            **gaps,
            "closure": found.closure.value,
            "closure_interval": [found.closure.low, found.closure.high],
            "fidelity_alone": found.fidelity_alone,
            "simplest_model": found.simplest,
            "split_in_time": data.split_in_time,
        },
        "nuisances": _nuisances(found),
        "channels": [vars(row) for row in channels],
        "where": [*listed, {"sensor": "all others", "share": rest}],
        "residual_forces": [vars(force) for force in found.forces],
        "budget": budget,
        "remainder": remainder,
        "floor_share": 1 - sum(row["share"] for row in budget) - (remainder or {"share": 0.0})["share"],
        "data": [finding.document() for finding in (*findings, *outlier_findings(found))],
        "with_outliers": _with_outliers(found),
        "complete": not found.skipped,
        "skipped": list(found.skipped),
        "provenance": {
            "machine": found.model.facts.name,
            "recordings": {
                "train": list(names[: data.training]),
                "holdout": list(names[data.training :]),
                "trained_in_part": [data.recordings[k].name for k in sorted(data.extended)],
            },
            **found.model.facts.provenance,
            "simulated_s": found.model.predictor.simulated_s,
            "boom_mj": version("boom_mj"),
            "mujoco": version("mujoco"),
        },
    }
    return plain(_with_former_names(answer))


def _with_former_names(answer: dict[str, Any]) -> dict[str, Any]:
    """With what version 0.1 calls some of it, beside the names of today."""
    left, made = answer["remainder"], answer["provenance"]
    recordings = {**made["recordings"], "learnt_in_part": made["recordings"]["trained_in_part"]}
    hinges = made.get("hinges", {})
    former = {"contest": hinges["predictions"], "fidelity": hinges["check"]} if hinges else {}
    return {
        **answer,
        "pushes": answer["residual_forces"],
        "unexplained": left and {**left, "learn_from": left["train_with"]},
        "provenance": {**made, "recordings": recordings, **({"hinges": {**hinges, **former}} if hinges else {})},
    }


def _with_outliers(found: Diagnosis) -> dict[str, Any] | None:
    """In short what was found before outliers were left out; None without any."""
    whole = found.with_outliers
    if whole is None:
        return None
    return {"verdict": whole.verdict, "sentence": sentence(whole), **_causes(whole)}


def _causes(found: Diagnosis) -> dict[str, list[dict[str, Any]]]:
    """Effects that the verdict names, and suspects."""
    causes, named = described(found) if found.best else [], found.named
    return {
        "effects": [cause for cause, so in zip(causes, named) if so],
        "suspect": [cause for cause, so in zip(causes, named) if not so],
    }


def _nuisances(found: Diagnosis) -> list[dict[str, Any]]:
    """Every one with its prior, and as it was estimated along."""
    return [
        {
            "id": size.effect.id,
            "location": size.effect.location,
            "parameter": size.parameter,
            "value": size.value,
            "unit": size.effect.declared[size.parameter].unit,
            "prior": {"neutral": size.neutral, "deviation": size.deviation},
        }
        for size in nuisance_sizes(estimated_nuisances(found), nuisances(found))
    ]


def _budget(found: Diagnosis) -> list[dict[str, Any]]:
    """Shares of the held-out mean square of the machine as built that the effects take."""
    if found.best is None or found.budget is None:
        return []
    return [
        {"id": effect.id, "location": effect.location, "share": share.value, "share_interval": [share.low, share.high]}
        for effect, share in zip(found.best.fit.effects, found.budget.shares)
    ]


def _remainder(found: Diagnosis, beside: bool) -> dict[str, Any]:
    """What is left above the floor, what it looks like, where it lies, and which recordings would teach more.

    Args:
        beside: whether its share is one of the budget's.
    """
    whole, left = (gap(residual, found.model.data.held_out) ** 2 for residual in (found.as_built, found.residual))
    share = found.budget.remainder.value if beside and found.budget else (left - 1) / whole
    return {
        "share": max(share, 0.0),
        "looks_like": "outlying" if found.outliers else looks_like(found.model, found.residual),
        "where": " and ".join(part.name for part in found.outliers) or in_words(locate(found.model, found.residual)),
        "other_laws": [{"location": place, "holdout_gap": left} for place, left in other_laws(found)],
        "train_with": [found.model.data.recordings[k].name for k in found.not_trained],
    }


def plain(value: Any) -> Any:
    """Numbers that JSON can hold: infinities and NaN as null."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value
