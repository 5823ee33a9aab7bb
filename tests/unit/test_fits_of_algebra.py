"""Where fits end, how sure they are there, and how they begin anew, on a machine whose answers are known by algebra."""

from dataclasses import replace

import numpy as np
from algebra import HUM, LATE, SQUARE, Ramp, Square, Tone, model, term
from pytest import MonkeyPatch, approx, mark
from scipy.optimize import least_squares

from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.fitting import fit, refine_jointly
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.partners import without_the_least
from boom_mj.diagnosis.refining import begun_anew, beyond
from boom_mj.diagnosis.scoring import alternatives, profiled, score
from boom_mj.effects import Effect
from boom_mj.estimation.bootstrap import gap
from boom_mj.estimation.intervals import Z95
from boom_mj.estimation.least_squares import OPTIONS


@mark.parametrize("true", [SQUARE, LATE], ids=["linear", "not linear"])
def test_fits_end_where_least_squares_of_everything_do(true: Effect) -> None:
    about, start = model((true,)), Candidate((type(true)(true.site, size=0.02),))
    train = about.data.train

    def residual(at: np.ndarray) -> np.ndarray:
        offsets = about.posterior.basis.whole[train] @ at[1:]
        (left,) = about.residuals([start.at(at[:1])])
        return np.r_[left[train] - offsets, at[0] / OPTIONS.prior, at[1:]]

    low, high = start.bounds()
    wide = np.full(2, 2.5)
    best = least_squares(residual, np.r_[start.start, 0.0, 0.0], bounds=(np.r_[low, -wide], np.r_[high, wide]))
    alone = fit(about, start, OPTIONS.sharp)
    there, joint = refine_jointly(about.rebased(start.effects, np.zeros(2)), start)
    assert alone.scaled == approx(best.x[:1], rel=1e-4) and joint.scaled == approx(best.x[:1], rel=1e-3)
    assert alone.cost == approx(best.cost, rel=1e-5)
    assert there.effects == joint.effects


def test_sizes_are_unsure_as_far_as_the_cost_is_rough() -> None:
    about = model((SQUARE,))
    smooth = fit(about, Candidate((term(Square, 1, 0.02),)))
    assert score(about, replace(smooth, rough=np.array([0.3]))).deviation == approx(
        np.hypot(score(about, smooth).deviation, 0.3)
    )


@mark.parametrize("jolt", [0.0, 0.04])
def test_what_play_shakes_makes_other_sizes_unsure(jolt: float, monkeypatch: MonkeyPatch) -> None:
    monkeypatch.setattr(Square, "grid_start", (1.0,))
    about, predict, turns = model((SQUARE, HUM)), Linearisation.predict, iter(range(99))
    sharp = score(about, fit(about, Candidate((SQUARE, HUM)), OPTIONS.sharp))
    shape = sharp.fit.jacobian[:, 1] / np.maximum(about.noise.weight, 1e-12)

    def shaken(self: Linearisation, hypotheses: list, training_only: bool = False) -> list[np.ndarray]:
        """Every other prediction with more hum, the others with less: by `jolt` of its scaled size."""
        return [one + (-1) ** next(turns) * jolt * shape for one in predict(self, hypotheses, training_only)]

    monkeypatch.setattr(Linearisation, "predict", shaken)
    square, hum = profiled(sharp, before=20.0).deviation
    assert square > 3 * sharp.deviation[0]
    assert hum == approx(np.hypot(sharp.deviation[1], jolt), rel=0.02)


@mark.parametrize("oscillatory", [True, False])
@mark.parametrize("grid", [(), (1.0, 1.59, 1.6, 1.61, 2.4)], ids=["from screening", "from a grid"])
def test_a_fit_that_stays_at_a_wrong_size_begins_anew(
    grid: tuple[float, ...], oscillatory: bool, monkeypatch: MonkeyPatch
) -> None:
    if grid:
        monkeypatch.setattr(Tone, "grid_start", grid)
        monkeypatch.setattr(Tone, "screening", lambda site: [])
    square, true = term(Square, 1, 0.3), term(Tone, 2, 0.801)
    healthy = model((square, true), oscillatory=oscillatory)
    data, raw = healthy.data, healthy.clean(healthy.residual(healthy.base))
    as_built = gap(raw, data.train), gap(raw, data.held_out)
    stuck = score(healthy, fit(healthy, Candidate((square, term(Tone, 2, 0.35)))))
    assert stuck.train > 1.3
    lines = list[str]()
    best = begun_anew(stuck, as_built, Clock(tell=lines.append))
    starts = 1 if grid else 3  # the square grows with its size
    assert lines.count(f"{stuck.label} begun anew") == starts * oscillatory
    if oscillatory:
        assert best.gaps == approx((1, 1), abs=0.05)
        assert best.fit.effects[1].values["size"] == approx(0.801, abs=1e-4)
    else:
        assert best is stuck


def test_a_size_moves_on_to_where_the_same_leaves_less() -> None:
    square, true = term(Square, 1, 0.3), term(Tone, 2, 0.801)
    healthy = model((square, true), oscillatory=True)
    stuck = score(healthy, fit(healthy, Candidate((square, term(Tone, 2, 0.35)))))
    moved = beyond(stuck)
    assert moved.train < stuck.train
    assert moved.fit.effects[1].values["size"] == approx(0.801, abs=1e-3)
    assert beyond(moved) is moved
    alone = score(healthy, fit(healthy, Candidate((square,))))
    assert beyond(alone) is alone  # it grows with its size: derivatives tell


@mark.parametrize("worse, unsure", [(0.01, 3.0), (1.0, None)])
def test_a_size_is_as_unsure_as_ends_that_are_as_good_are_apart(worse: float, unsure: float | None) -> None:
    healthy = model((SQUARE,))
    best = score(healthy, fit(healthy, Candidate((term(Square, 1, 0.01),))))
    there = replace(best.fit, scaled=best.fit.scaled - 3.0)
    found = alternatives([replace(best, fit=there, train=best.train + worse), best], before=5.0)
    assert found.fit is best.fit
    assert Z95 * found.deviation == approx(Z95 * best.deviation if unsure is None else [unsure])


@mark.parametrize(
    ("causes", "kept"),
    [
        ((LATE, SQUARE), (SQUARE,)),  # what came first, whatever it does: beside it others were tried
        ((LATE, term(Ramp, 2, 0.05), SQUARE), (LATE, SQUARE)),
        ((term(Ramp, 2, 0.05), LATE, SQUARE), (LATE, SQUARE)),
        ((LATE, HUM, term(Ramp, 2, 0.05)), (LATE, term(Ramp, 2, 0.05))),  # the last stays
    ],
)
def test_others_are_tried_in_the_place_of_what_does_least(causes: tuple[Effect, ...], kept: tuple[Effect, ...]) -> None:
    about = model(causes)
    found = score(about, fit(about, Candidate(causes)))
    assert [effect.cause for effect in without_the_least(found)] == [effect.cause for effect in kept]
