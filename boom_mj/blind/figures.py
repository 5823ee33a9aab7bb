"""Opening the seal: how many answers are right, with intervals, against the goals.

A case without an answer counts as a miss of every figure that it belongs to; intervals of shares are Wilson's, those
of quantiles come from the bootstrap.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from scipy.stats import norm

from boom_mj.blind.answers import read_answer
from boom_mj.blind.grading import LISTED, NO_ANSWER, Outcome, judge_case
from boom_mj.blind.probabilities import brier_score, calibration_error, log_score
from boom_mj.blind.sampling import MIX, MORE
from boom_mj.errors import InputError
from boom_mj.files import read_bytes, read_json, read_text

Array = np.ndarray
T = TypeVar("T")
SURE = 1.959964  # deviations of a 95 % interval
DRAWS = 2000


@dataclass(frozen=True)
class Figure:
    """A measured figure, its 95 % interval, and the goal that it is held against.

    Attributes:
        count: of what it was taken from, cases or parameters.
        goal: lowest and highest value that meet it; None where it is for information only.
    """

    name: str
    value: float
    low: float
    high: float
    count: int
    goal: tuple[float, float] | None

    @property
    def met(self) -> bool | None:
        return None if self.goal is None or not self.count else self.goal[0] <= self.value <= self.goal[1]


@dataclass(frozen=True)
class Score:
    """Outcomes and the figures made of them.

    Attributes:
        outcomes: in the order of the cases' names, set by set.
        seeds, seals: SHA-256 of every set's.
        apart: what it is pooled of, one score a set.
    """

    outcomes: tuple[Outcome, ...]
    figures: tuple[Figure, ...]
    seeds: tuple[str, ...]
    seals: tuple[str, ...]
    apart: tuple["Score", ...] = ()

    def document(self) -> dict[str, Any]:
        """Everything as plain data."""
        apart = [{"figures": _told(one.figures)} for one in self.apart]
        outcomes = [vars(outcome) for outcome in self.outcomes]
        hashes = {"seal_sha256": self.seals, "seed_sha256": self.seeds}
        return _plain({**hashes, "figures": _told(self.figures), "campaigns": apart, "outcomes": outcomes})


def _told(figures: Sequence[Figure]) -> list[dict[str, Any]]:
    return [{**vars(figure), "met": figure.met} for figure in figures]


def pooled(scores: Sequence[Score]) -> Score:
    """The score of several sets together."""
    outcomes, seeds, seals = (
        tuple(item for one in scores for item in getattr(one, name)) for name in ("outcomes", "seeds", "seals")
    )
    return Score(outcomes, tuple(figures(outcomes)), seeds, seals, tuple(scores))


def score(folder: Path, seal: Path, answers: Path) -> Score:
    """Open the seal of a set and grade its answers.

    Raises:
        InputError: the seal is not the one whose hash was published, or an answer is malformed.
    """
    if not (folder / "seal.sha256").is_file():
        raise InputError(f"{folder} holds no sealed campaign: there is no seal.sha256")
    published, content = read_text(folder / "seal.sha256", InputError).strip(), read_bytes(seal, InputError)
    if (found := sha256(content).hexdigest()) != published:
        raise InputError(f"{seal} is not the seal of {folder}: its hash is {found}, published was {published}")
    sealed, outcomes = read_json(seal, InputError), []
    cases = _of_its_kind(seal, "seal", lambda: [*sealed["cases"].items()])
    _refuse_strays(answers, [name for name, _ in cases])
    for case, truth in cases:
        path = answers / f"{case}.json"
        answer = read_answer(path) if path.exists() else NO_ANSWER
        outcomes.append(_of_its_kind(path, "answer to its case", partial(judge_case, case, truth, answer)))
    return Score(tuple(outcomes), tuple(figures(outcomes)), (str(sealed.get("seed_sha256")),), (published,))


def _refuse_strays(answers: Path, cases: Sequence[str]) -> None:
    """Answers under other names than those of the cases would count as missing."""
    strays = sorted(path for path in answers.glob("*.json") if path.stem not in cases)
    if strays:
        raise InputError(f"{strays[0]} answers no case; answers are called CASE.json, such as {cases[0]}.json")


def _of_its_kind(path: Path, kind: str, use: Callable[[], T]) -> T:
    """What is made of a JSON file, which need not hold what belongs there."""
    try:
        return use()
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise InputError(f"{path} holds no {kind}: {type(error).__name__} {error}") from error


def wilson(hits: int, count: int) -> tuple[float, float]:
    """95 % interval of a share, by Wilson's score."""
    if count == 0:
        return 0.0, 1.0
    share, square = hits / count, SURE**2
    middle = (share + square / (2 * count)) / (1 + square / count)
    reach = SURE * np.sqrt(share * (1 - share) / count + square / (4 * count**2)) / (1 + square / count)
    return max(0.0, float(middle - reach)), min(1.0, float(middle + reach))


def figures(outcomes: Sequence[Outcome]) -> list[Figure]:
    """The figures that a diagnosis is measured by."""
    by = {kind: [o for o in outcomes if o.kind == kind] for kind in (*MIX, *MORE)}
    singles, outside, several = by["single"], [*by["withheld"], *by["stranger"]], by["several"]
    closures = np.array([o.closure for o in outcomes if o.kind in LISTED and o.right and np.isfinite(o.closure)])
    wall = np.array([o.wall_s for o in outcomes if np.isfinite(o.wall_s)])
    return [
        _share("single effect: right id", [o.right for o in singles], (0.95, 1)),
        _share("single effect: right id and location", [o.placed for o in singles], (0.90, 1)),
        _share("single effect: right id without a tie", [o.right and not o.tied for o in singles], None),
        _share("single effect: named or in a stated tie", [o.held for o in singles], None),
        _share("false alarm without effect", [not o.right for o in by["none"]], (0, 0.02)),
        _share(
            "withheld or outside the library: unexplained or tied with a twin", [o.right for o in outside], (0.90, 1)
        ),
        _share("... withheld", [o.right for o in by["withheld"]], None),
        _share("... outside the library", [o.right for o in by["stranger"]], None),
        _share("two effects: both named", [o.right for o in by["pair"]], (0.80, 1)),
        _share("two effects: both named and placed", [o.placed for o in by["pair"]], None),
        _share("three to five effects: recall", _counted(several, "causes"), (0.80, 1)),
        _share("three to five effects: precision", _counted(several, "named"), (0.93, 1)),
        _share("named causes that are not there", [not hit for hit in _counted(outcomes, "named")], None),
        _share("single effect on a machine as built: right id and location", [o.placed for o in by["clutter"]], None),
        _quantile("held-out closure of solved cases, median", closures, 0.5, (0.95, np.inf)),
        _quantile("held-out closure of solved cases, 10th percentile", closures, 0.1, (0.85, np.inf)),
        _share("95 % intervals that hold the truth", held(outcomes, 0.95), (0.90, 0.98)),
        *(_of_probabilities(name, outcomes, score, goal) for name, score, goal in PROBABILITIES),
        _quantile("time of one case on one core, median, s", wall, 0.5, None),
    ]


PROBABILITIES: tuple[tuple[str, Callable[[Array, Array], float], tuple[float, float] | None], ...] = (
    ("probability of an answer: Brier score", brier_score, (0, 0.1)),
    ("probability of an answer: log score", log_score, None),
    ("probability of an answer: expected calibration error", calibration_error, (0, 0.05)),
)


def _counted(outcomes: Sequence[Outcome], among: str) -> list[bool]:
    """Of the causes that are sealed or named, which are both, case after case."""
    return [k < outcome.hits for outcome in outcomes for k in range(getattr(outcome, among))]


def given_and_true(outcomes: Sequence[Outcome]) -> tuple[Array, Array]:
    """Probabilities of the answers that give one, (n,), and whether what they were given to is so, (n,) of bool."""
    told = [(o.probability, o.true) for o in outcomes if np.isfinite(o.probability)]
    return np.array([p for p, _ in told]), np.array([y for _, y in told], bool)


def _of_probabilities(
    name: str,
    outcomes: Sequence[Outcome],
    score: Callable[[Array, Array], float],
    goal: tuple[float, float] | None,
) -> Figure:
    """A score of probabilities and its bootstrap interval."""
    probability, true = given_and_true(outcomes)
    if not len(true):
        return Figure(name, np.nan, -np.inf, np.inf, 0, goal)
    draws = np.random.default_rng(0).integers(len(true), size=(DRAWS, len(true)))
    low, high = np.quantile([score(probability[draw], true[draw]) for draw in draws], [0.025, 0.975])
    return Figure(name, score(probability, true), float(low), float(high), len(true), goal)


def held(outcomes: Sequence[Outcome], level: float) -> list[bool]:
    """Whether each interval would hold the truth, scaled to a level as a normal deviate would be."""
    reach = float(norm.ppf((1 + level) / 2)) / SURE
    return [abs(error) <= reach for outcome in outcomes for error in outcome.errors]


def _share(name: str, hits: Sequence[bool], goal: tuple[float, float] | None) -> Figure:
    low, high = wilson(sum(hits), len(hits))
    return Figure(name, sum(hits) / len(hits) if hits else np.nan, low, high, len(hits), goal)


def _quantile(name: str, values: Array, level: float, goal: tuple[float, float] | None) -> Figure:
    """A quantile and its bootstrap interval."""
    if not len(values):
        return Figure(name, np.nan, -np.inf, np.inf, 0, goal)
    draws = values[np.random.default_rng(0).integers(len(values), size=(DRAWS, len(values)))]
    low, high = np.quantile(np.quantile(draws, level, axis=1), [0.025, 0.975])
    return Figure(name, float(np.quantile(values, level)), float(low), float(high), len(values), goal)


def _plain(value: Any) -> Any:
    """Data that JSON can hold: numbers that are none become null."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
