"""How good the probabilities of answers are.

An answer gives a probability p to what it says: that its causes are all that the machine has and where (of a partial
answer, that the machine has them), that nothing needs explaining, or that no cause of the library explains it. It is
true (y = 1) or not (y = 0). Over n answers

    Brier score    B = mean (p - y)^2               0 is best, 1/4 is that of p = 1/2 throughout
    log score      L = mean -log(p if y else 1 - p) with probabilities kept within [LEAST, 1 - LEAST]
    calibration    ECE = sum_b n_b / n |mean_b p - mean_b y|, the expected calibration error, over BINS equal bins of p
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

Array = np.ndarray
BINS = 10
LEAST = 1e-3  # that a log score takes for impossible: one sure and wrong answer costs 6.9, not infinity


def given(answer: Mapping[str, Any]) -> float:
    """The probability that an answer gives to what it says; NaN where it gives none.

    A set of causes is no more probable than the least probable of them.
    """
    others = answer.get("others") or {}
    own = {
        "consistent": [others.get("none")],
        "unexplained": [others.get("outside_library")],
    }.get(answer["verdict"], [cause.get("probability") for cause in answer["effects"]])
    found = [answer["probability"]] if answer.get("probability") is not None else own
    return float(min(found)) if found and None not in found else np.nan


def brier_score(probability: Array, true: Array) -> float:
    """Of probabilities (n,) given to what is true or not, (n,) of bool."""
    return float(np.mean((probability - true) ** 2))


def log_score(probability: Array, true: Array) -> float:
    """As `brier_score`."""
    kept = np.clip(probability, LEAST, 1 - LEAST)
    return float(np.mean(-np.log(np.where(true, kept, 1 - kept))))


@dataclass(frozen=True)
class Bin:
    """Answers whose probability lies in [low, high): how many, their mean probability, and the share that is true."""

    low: float
    high: float
    count: int
    probability: float
    true: float


def reliability(probability: Array, true: Array, bins: int = BINS) -> tuple[Bin, ...]:
    """The bins that hold answers, lowest first; 1 belongs to the last."""
    number = np.minimum((probability * bins).astype(int), bins - 1)
    return tuple(
        Bin(k / bins, (k + 1) / bins, int(np.sum(here)), float(probability[here].mean()), float(true[here].mean()))
        for k in range(bins)
        if (here := number == k).any()
    )


def calibration_error(probability: Array, true: Array, bins: int = BINS) -> float:
    """The expected calibration error; as `brier_score`."""
    found = reliability(probability, true, bins)
    return sum(one.count * abs(one.probability - one.true) for one in found) / len(probability)
