"""Small numbers and signs that decide about answers, each where it is computed; `scripts/mutants.py` asked for them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import ndtri, stdtrit

from boom_mj.diagnosis import answer, budget, decision
from boom_mj.diagnosis.candidate import Candidate, everywhere
from boom_mj.diagnosis.criteria import BOOM, MJCF, SearchBudget
from boom_mj.diagnosis.fitting import Fit, fit
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.scoring import Scored
from boom_mj.effects import BOOM_SITES, Parameter, Site, effect_library, parse_effect
from boom_mj.effects.filters import lagged
from boom_mj.effects.library.wind import CORRELATION_S
from boom_mj.errors import LogWarning
from boom_mj.estimation import dataset
from boom_mj.estimation.bootstrap import closure, log_squares, mean_over, resampled_means, worse_by
from boom_mj.estimation.intervals import robust_variance
from boom_mj.estimation.noise import OPTIONS, _carried, noise_model
from boom_mj.recording import Recording, named_signal
from boom_mj.replay.quality.edits import blanked
from boom_mj.systems.boom import BoomSystem

MODEL = SimpleNamespace(criteria=BOOM)
SOFT, SOFTER = "base_compliance:axes=roll,roll=1e8", "base_compliance:axes=roll+pitch,roll=1e8,pitch=1e8"
PAYLOAD, HOSE = "tip_payload:mass=27", "end_hose:mass=20"


def scored(gap: float, *effects: str, model: object = MODEL) -> Scored:
    candidate = Candidate(tuple(map(parse_effect, effects)))
    empty = np.zeros((0, len(candidate.start)))
    return Scored(
        Fit(candidate, candidate.start, candidate.effects, empty[:, 0], empty, 0.0), model, gap, gap, candidate.start
    )


def test_a_models_error_reaches_as_many_blocks_as_the_options_say_on_either_side() -> None:
    whole = SimpleNamespace(channels=[0], stretch=lambda number: slice(0, 41))
    reached = np.flatnonzero(_carried(whole, np.where(np.arange(41) == 20, 2.0, 0.0)))
    assert (reached[0], reached[-1]) == (20 - OPTIONS.reach_blocks, 20 + OPTIONS.reach_blocks)


@pytest.mark.parametrize(("span", "kept"), [((0.0, 3.0), 31), ((1.0, 2.0), 21), ((0.0, 2.0), 21), ((1.0, 1.0), 11)])
def test_signals_are_cut_to_the_time_that_is_simulated(span: tuple[float, float], kept: int) -> None:
    time = np.arange(31) / 10
    log = Recording("a", "boom36", "", {"markers": named_signal("markers", time, np.zeros((31, 36)))})
    names = {"markers": np.ones(36)}
    if kept == 31:
        assert dataset._while_driven(log, span, names) is log
        return
    with pytest.warns(LogWarning, match=rf"{31 - kept} samples of markers lie up to 1.000 s outside"):
        cut = dataset._while_driven(log, span, names)["markers"].time
    assert len(cut) == kept and cut[0] == span[0]


def test_blurring_takes_means_of_a_channels_own_stretches_and_of_what_was_measured() -> None:
    data = SimpleNamespace(
        time=np.array([0.0, 0.4, 1.2, 1.6, 0.0, 0.4]),
        channel_of=np.array([0, 0, 0, 0, 1, 1]),
        used=np.array([True, True, True, False, True, True]),
    )
    blurred = dataset.Dataset.blurred(data, np.array([1.0, 3.0, 5.0, 9.0, 10.0, 20.0]), 1.0)
    assert blurred.tolist() == [2.0, 2.0, 5.0, 0.0, 15.0, 15.0]


def test_variances_over_clusters_are_widened_for_their_number() -> None:
    score, cluster = 10 * np.array([[1.0], [2.0], [-1.0], [3.0]]), np.arange(4)
    wider = 4 / 3 * (stdtrit(3, 0.975) / ndtri(0.975)) ** 2
    (found,) = robust_variance(np.eye(1) / 100, score, [cluster])
    assert found == pytest.approx(wider * 1500 / 100**2)
    assert robust_variance(np.eye(1) / 100, score[:3], [cluster[:3]]) == pytest.approx([0.01])  # too few


def test_bootstraps_have_the_data_first_and_draws_that_differ() -> None:
    means = resampled_means(np.array([0, 0, 1, 2]), np.array([[1.0, 3.0, 5.0, 7.0]]))
    assert means[0, 0] == 4.0 and means[1:, 0].std() > 0.5
    loss, error = worse_by(np.array([0, 0, 2]), np.zeros(3), np.array([1.0, 1.0, 2.0]))
    assert (loss, error) == (2.0, pytest.approx(np.sqrt(2.0) / 3))


def test_rivals_tie_within_their_uncertainty(monkeypatch: pytest.MonkeyPatch) -> None:
    best, rival = scored(1.00, PAYLOAD), scored(1.02, HOSE)
    loss = {"of": (0.01, 0.02)}
    monkeypatch.setattr(decision, "held_out_loss", lambda *given: loss["of"])

    def ties(before: float, other: Scored = rival) -> bool:
        return decision.ties_with(MODEL, best, other, before)

    assert ties(2.0)  # 0.02 of a gap of 1 that both close, and half an error
    assert not ties(1.5)  # 4 % of it
    assert not ties(2.0, scored(1.04, HOSE))
    assert not ties(2.0, scored(1.0, PAYLOAD, HOSE))
    loss["of"] = (0.01, 0.004)  # 2.5 errors
    assert not ties(2.0)


def test_of_the_same_causes_the_fewer_parameters_stand_by_mean_squares() -> None:
    for most, left, simpler in (
        (1.2, 1.69, True),  # 1 % of 144 may be inaccuracy
        (1.2, 1.71, False),
        (0.98, 1.005, True),  # both suffice
        (0.98, 1.02, False),  # the simpler one does not
    ):
        best, found = scored(most, SOFTER), scored(left, SOFT)
        assert decision.nested(found, best)
        assert decision._simplest(best, [found], (12.0, 12.0)) is (found if simpler else best)


def test_a_cause_is_needed_where_the_rest_leaves_much_more(monkeypatch: pytest.MonkeyPatch) -> None:
    best, rival = replace(scored(1.0, PAYLOAD), deviation=np.array([0.3])), scored(1.2, HOSE)
    for left, needed in ((1.0, True), (1.7, True), (1.9, False)):  # of 2.5: closes all, 53 %, 40 %
        squares = np.tile([left, 9.0, 2.5], (11, 1))
        monkeypatch.setattr(budget, "_mean_squares", lambda *given, squares=squares: squares)
        assert budget.needed(best, [best, rival], np.zeros(0), best.fit.effects[0]) == needed
        unsure = replace(best, deviation=np.array([0.35]))  # 0.675 +- 0.69: it may do nothing
        assert not budget.needed(unsure, [unsure, rival], np.zeros(0), best.fit.effects[0])
    monkeypatch.setattr(budget, "needed", lambda best, scored, as_built, effect: effect.id == "end_hose")
    assert budget.any_needed(scored(1.0, PAYLOAD, HOSE), [], np.zeros(0)) is True
    assert budget.any_needed(best, [], np.zeros(0)) is False


def test_what_leaves_much_more_in_training_is_no_rival_where_the_floor_is_never_reached(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Be what it says of few held-out windows as good as it may: it was not refined."""
    model = SimpleNamespace(criteria=MJCF, budget=SearchBudget(), data=None)
    best = replace(scored(2.0, PAYLOAD, model=model), deviation=np.array([0.3]))
    logs = np.tile([[1.0], [3.0], [1.0]], 2)  # over two cells: of the best, of the machine as built, of a rival
    monkeypatch.setattr(budget, "log_squares", lambda data, left: (logs[: len(left)], np.arange(2)))
    for left, needed in ((2.9, False), (3.1, True)):
        rival = scored(left, HOSE, model=model)
        assert budget.needed(best, [best, rival], best.fit.residual, best.fit.effects[0]) == needed


def test_the_remainder_is_a_share_of_mean_squares(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(answer, "gap", lambda residual, rows: residual)
    for name in ("looks_like", "locate", "in_words"):
        monkeypatch.setattr(answer, name, lambda *given: None)
    data = SimpleNamespace(held_out=None, recordings=())
    model = SimpleNamespace(data=data)
    shares = SimpleNamespace(remainder=SimpleNamespace(value=0.2))
    found = SimpleNamespace(
        as_built=3.0, residual=2.0, not_trained={}, freed=(), model=model, budget=shares, outliers=()
    )
    assert answer._remainder(found, False)["share"] == pytest.approx((4 - 1) / 9)
    assert answer._remainder(found, True)["share"] == 0.2
    assert answer._remainder(SimpleNamespace(**{**vars(found), "residual": 0.9}), False)["share"] == 0.0


def test_unlikely_sizes_cost(monkeypatch: pytest.MonkeyPatch) -> None:
    found = scored(1.0, PAYLOAD, model=SimpleNamespace(criteria=replace(BOOM, unlikely_gap=0.5)))
    assert found.doubt == 0.0
    monkeypatch.setattr(Scored, "plausible", property(lambda found: False))
    assert found.doubt == pytest.approx(2 * np.log(2))


def test_every_kind_of_the_library_that_competes_has_its_sites() -> None:
    from boom_mj.machine import load_machine

    system = BoomSystem(load_machine("boom36"))
    kinds = everywhere(system, ("wind",))
    assert {kind.id for kind, _ in kinds} >= {"tip_payload", "joint_play"} and "wind" not in {k.id for k, _ in kinds}


def test_a_prediction_is_the_base_and_what_effects_change_in_it(model: Linearisation) -> None:
    count = len(model.base)

    class Coarse:
        data = model.data

        @staticmethod
        def predict(hypotheses: list, level: object, recordings: object = None) -> list[np.ndarray]:
            return [np.full(count, 5.0 + 2.0 * len(effects)) for effects in hypotheses]

    own = replace(model, predictor=Coarse(), base=np.full(count, 3.0))
    assert [float(p[0]) for p in own.predict([(), ("one",), ("one", "two")])] == [3.0, 5.0, 7.0]


def test_a_fit_of_what_is_linear_ends_where_least_squares_do(model: Linearisation) -> None:
    """In scaled parameters y = a theta: one step of Levenberg-Marquardt less its damping, and then the rest."""
    rng = np.random.default_rng(1)
    count, train = len(model.base), model.data.train
    slope = rng.standard_normal(count)
    candidate = Candidate((parse_effect("tip_payload:mass=20"),))
    wanted = candidate.start + 0.3

    class Straight:
        data, posterior = (
            model.data,
            SimpleNamespace(
                left=lambda residual: (residual[train], np.zeros(0)),
                free=lambda estimate: np.zeros(0, bool),
                project=lambda columns, free: columns,
            ),
        )

        @staticmethod
        def residuals(points: list) -> list[np.ndarray]:
            return [slope * (wanted - Candidate(effects).start)[0] for effects in points]

        @staticmethod
        def clean(residual: np.ndarray) -> np.ndarray:
            return residual

    found = fit(Straight(), candidate, enough=1e-9)
    assert found.scaled == pytest.approx(wanted, rel=1e-3)


def test_friction_in_proportion_to_a_load_is_a_share_of_it_against_the_motion() -> None:
    effect = effect_library()["load_friction"](Site(), share=0.2)
    resisted = effect.resist(np.array([0.0, 1.0, -1.0]), np.array([50.0, -100.0, 100.0]))
    assert resisted == pytest.approx([0.0, 20.0, -20.0])


def test_a_low_pass_takes_its_time_constant_whenever_a_log_begins() -> None:
    time = 5.0 + np.arange(2001) / 1000
    passed = lagged(time, np.where(time > 5.0, 1.0, 0.0), 0.2)
    assert passed[200] == pytest.approx(1 - np.exp(-1), abs=5e-3) and passed[-1] == pytest.approx(1.0, abs=1e-4)


def test_gusts_vary_about_the_mean_by_their_strength_and_slowly() -> None:
    wind, time = parse_effect("wind:mean_speed=5,direction=0,gust_strength=0.2"), 3.0 + np.arange(200_000) / 100
    gusts = wind._gusts(time)
    assert gusts.mean() == pytest.approx(1.0, abs=0.1) and gusts.std() == pytest.approx(0.2, rel=0.15)
    about = gusts - gusts.mean()
    alike = (about[100:] * about[:-100]).mean() / (about**2).mean()
    assert alike == pytest.approx(np.exp(-1 / CORRELATION_S), abs=0.05)  # 1 s later


def test_a_structural_slider_is_a_spring_that_yields_at_its_torque() -> None:
    from boom_mj.machine import load_machine
    from boom_mj.mjcf import build

    machine = load_machine("boom36")
    effect = parse_effect("structural_hysteresis:joint=3,stiffness=1e6,slip_torque=2e3")
    spec = build(machine).spec
    effect.edit(spec, machine)
    (tendon,) = [t for t in spec.tendons if t.name == "slider3"]
    assert tendon.stiffness[0] == 1e6


def test_a_table_takes_means_channel_by_channel() -> None:
    channels = tuple(SimpleNamespace(blocks=np.array(blocks)) for blocks in ([0, 2], [1]))
    table = dataset.Table(None, channels, 0.0, np.arange(3.0), np.zeros((3, 2)), np.ones((3, 2)))
    mean = table.saying(np.array([1.0, 2.0, 3.0])).mean
    assert (mean[0, 0], mean[2, 0], mean[1, 1]) == (1.0, 2.0, 3.0) and np.isnan(mean).sum() == 3


def test_nothing_is_left_of_a_prediction_that_is_what_was_measured_but_for_the_models_error(
    model: Linearisation,
) -> None:
    assert np.abs(model.residual(model.data.measured - model.mean_error)).max() < 1e-6


def test_joint_angles_without_commands_are_bridged_straight() -> None:
    time = np.arange(11) / 10
    angles = np.where(np.arange(11)[:, None] == 5, 9.0, np.arange(11.0)[:, None] * np.ones(5))
    log = Recording("a", "boom36", "", {"joint/position": named_signal("joint/position", time, angles)})
    bridged = blanked("joint/position", np.arange(11)[:, None] == np.full(5, 5))(log)["joint/position"].values
    assert bridged == pytest.approx(np.arange(11.0)[:, None] * np.ones(5))


def test_noise_and_what_a_model_may_err_by_add_up_in_squares() -> None:
    data = SimpleNamespace(
        noise=np.full(5, 3.0), used=np.arange(5) > 0, channels=[0], stretch=lambda number: slice(0, 5)
    )
    doubts = np.array([np.full(5, 8.0), np.full(5, -6.0)])  # that they nearly cancel is chance
    found = noise_model(data, doubts, 0.5)
    assert found.weight == pytest.approx([0.0, *[1 / np.hypot(3.0, 10.0 * OPTIONS.spread_share)] * 4])
    assert found.error == pytest.approx(np.full(5, 1.0))


def test_a_closure_is_that_of_the_data_and_its_interval_that_of_draws() -> None:
    windows, before = np.arange(40), np.full(40, 3.0)
    found = closure(windows, before, np.where(windows < 20, 1.0, 2.0))
    assert found.value == pytest.approx((3 - np.sqrt(2.5)) / 2) and found.low < found.value < found.high


def test_what_is_likely_has_two_ends() -> None:
    known = Parameter("kg", 0.0, 0.0, 9.0, 1.0, likely=(1.0, 2.0))
    assert [known.plausible(value) for value in (0.5, 1.5, 2.5)] == [False, True, False]


def test_a_steady_tone_screened_as_a_pulsation_stays_within_its_bounds() -> None:
    pulsation = effect_library()["pump_pulsation"]
    site = pulsation.allowed(BOOM_SITES)[0]
    points = pulsation.screening(site, (2.0,))[0]
    values = pulsation.combine(site, points, np.full(len(points), 1e9))
    assert values["amplitude"] == pulsation.parameters(site)["amplitude"].high


def test_what_an_explanation_may_leave_grows_with_the_gap_above_the_floor() -> None:
    """Of a boom it does not."""
    assert MJCF.enough(3.0) == pytest.approx(MJCF.explained_gap + 2 * MJCF.error_share)
    assert MJCF.enough(3.0) > MJCF.enough(1.0) == MJCF.explained_gap
    assert BOOM.enough(50.0) == BOOM.explained_gap


def test_logarithms_of_what_channels_leave_window_by_window() -> None:
    data = SimpleNamespace(
        held_out=np.array([False, True, True, True, True, True, True]),
        windows=np.array([0, 2, 2, 5, 2, 5, 5]),
        channel_of=np.array([0, 0, 0, 0, 1, 1, 1]),
    )
    residual = np.array([9.0, 1.0, 3.0, 0.5, 2.0, 4.0, 0.0])
    logs, windows = log_squares(data, np.array([residual, 2 * residual]))  # type: ignore[arg-type]
    assert windows.tolist() == [0, 1, 0, 1]
    assert np.exp(logs) == pytest.approx(np.array([[5.0, 1.0, 4.0, 8.0], [20.0, 1.0, 16.0, 32.0]]))


def test_a_mean_is_as_unsure_as_its_clusters_are_apart() -> None:
    mean, error = mean_over(np.array([0, 0, 3, 3]), np.array([1.0, 3.0, 5.0, 7.0]))
    assert (mean, error) == (4.0, pytest.approx(np.sqrt(4.0**2 + 4.0**2) / 4))
