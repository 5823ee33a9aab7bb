"""How unsure sizes are of what else there may be a little, on a machine whose answers are known by algebra."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from algebra import HUM, SITES, SQUARE, Broken, Cube, Hum, Likeness, Ramp, Square, Term, found, predictor, term
from pytest import MonkeyPatch, approx

from boom_mj.diagnosis import criteria
from boom_mj.diagnosis.answer import document
from boom_mj.diagnosis.candidate import Candidate, everywhere
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.criteria import MJCF
from boom_mj.diagnosis.linearisation import linearise
from boom_mj.diagnosis.scoring import Scored
from boom_mj.diagnosis.stages import fit_all
from boom_mj.diagnosis.unnamed import allowing_for_others
from boom_mj.effects import Effect
from boom_mj.estimation.least_squares import OPTIONS

Library = Callable[..., None]


def fitted(named: Effect, *others: Effect) -> Scored:
    """One cause fitted alone to a machine that has others, too."""
    about = linearise(predictor((named, *others), kind="mjcf", oscillatory=False))
    (scored,) = fit_all(about, [Candidate((named,))], Clock())
    return scored


class Fourth(Term):
    """Much like a square, but data tell."""

    id = "fourth"

    def shape(self, time: np.ndarray, angle: np.ndarray) -> np.ndarray:
        return angle**4


def test_sizes_are_as_unsure_as_by_bayes() -> None:
    """The size, those that are not named and nuisances at once, as one linear Gaussian problem."""
    scored = fitted(SQUARE, term(Fourth, 1, 0.008), term(Ramp, 1, 0.02))
    model, data = scored.model, scored.model.data
    kinds = [(kind, SITES[0]) for kind in (Square, Likeness, Fourth, Ramp)]
    points = [kind(site, size=kind.table["size"].typical) for kind, site in kinds if kind(site).cause != SQUARE.cause]
    own, *said = model.predict([scored.fit.effects, *((*scored.fit.effects, one) for one in points)])
    others, left = [model.noise.white(one - own) for one in said], max(scored.train, 1.0) ** 2
    residual, size = model.residual(own)[data.train], scored.fit.jacobian[:, 0]

    def posterior(*others: np.ndarray) -> tuple[float, float]:
        """Mean and variance of what the size is off by."""
        columns = np.stack([size, *model.posterior.basis.whole.T, *others], axis=1)[data.train].astype(float)
        free, held = len(model.nuisances), len(others)
        prior = np.r_[OPTIONS.prior**-2, np.ones(free), np.full(held, left / MJCF.unnamed**2)]
        inverse = np.linalg.inv(columns.T @ columns + np.diag(prior))
        return float((inverse @ columns.T @ residual)[0]), float(left * inverse[0, 0])

    (alone, least), (moved, most) = posterior(), posterior(*others)
    expected = np.sqrt(scored.deviation[0] ** 2 + most - least + (moved - alone) ** 2)
    wider = allowing_for_others(scored, kinds).deviation[0]
    assert wider == approx(expected, rel=0.02) and left > 1.2
    assert min(most - least, (moved - alone) ** 2) > 0.1 * wider**2  # each of both counts


def test_a_little_of_what_looks_the_same_is_inside(library: Library) -> None:
    """A tenth of a size worth finding moves another by as much and by many standard errors."""
    scored = fitted(SQUARE, term(Likeness, 1, 0.1 * Likeness.table["size"].typical))
    error = scored.fit.scaled[0] - Candidate((SQUARE,)).start[0]
    library(Square, Likeness)
    wider = allowing_for_others(scored, list(everywhere(scored.model.system))).deviation[0]
    assert 5 * scored.deviation[0] < abs(error) < 2 * wider
    assert wider == approx(MJCF.unnamed, rel=0.1)


def test_nothing_else_that_looks_the_same_leaves_a_size_as_it_is(library: Library) -> None:
    """Nor does what no machine has that moves."""
    library(Square, Cube, Ramp, Hum, Broken)
    scored = fitted(SQUARE)
    wider = allowing_for_others(scored, list(everywhere(scored.model.system)))
    assert wider.deviation == approx(scored.deviation, rel=0.1)
    assert allowing_for_others(scored, []).deviation == approx(scored.deviation)


def test_where_a_little_of_another_may_do_it_nothing_is_sure(library: Library) -> None:
    library(Square, Likeness, Ramp, Hum)
    little = term(Square, 1, 0.18 * Square.table["size"].typical)
    answer = found(little, kind="mjcf", oscillatory=False)
    said = document(answer, ["first", "second"])
    assert (said["verdict"], said["effects"]) == ("unexplained", []) and answer.closed_by_little
    assert {one["id"] for one in said["ties"][0]} == {"square", "likeness"}
    (suspect,) = said["suspect"]
    assert suspect["parameters"]["size"]["low"] < 0 < suspect["parameters"]["size"]["high"]
    assert suspect["probability"] == approx(answer.odds.explanations[answer.scored.index(answer.best)] * 0.93, rel=0.03)
    assert said["sentence"].startswith("No cause of the gap of") and said["probability"] > 0.6


def test_beside_what_is_sure_it_is_a_suspect(library: Library, monkeypatch: MonkeyPatch) -> None:
    library(Square, Likeness, Ramp, Hum)
    monkeypatch.setitem(criteria.OF_KIND, "mjcf", replace(MJCF, unnamed=0.6))
    answer = found(SQUARE, HUM, kind="mjcf", oscillatory=False)
    said = document(answer, ["first", "second"])
    assert [effect["id"] for effect in said["effects"]] == ["hum"] and answer.solved
    assert said["suspect"][0]["id"] in ("square", "likeness")
    assert "The data do not tell what acts beside" in said["sentence"]
