"""Screening: where fits begin."""

from dataclasses import replace

import numpy as np
import pytest

from boom_mj.diagnosis import mimicry
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.lines import spectral_lines
from boom_mj.diagnosis.screening import Screening
from boom_mj.effects import Effect, make_effect

PULSATION = make_effect("pump_pulsation", {"direction": "vertical"})


def test_a_misfit_that_several_periods_explain_starts_fits_at_each(model: Linearisation) -> None:
    """Two seconds do not tell 0.60 from 0.62 Hz, and tell both from 3 Hz."""
    screening = Screening(model, [(type(PULSATION), PULSATION.site)], [0.60, 0.62, 3.0])
    residual = np.zeros(len(model.noise.weight))
    residual[model.data.train] = screening.columns[:, screening.stretches[0]] @ np.array([2.0, 1.0])
    (found,) = screening.rank(residual)
    found_at = [candidate.effects[0].values["frequency"] for candidate in found.starts]
    assert {0.60, 0.62} <= {*found_at} and not {1.5, 3.0} & {*found_at}


def test_what_looks_alike_on_these_data_is_mimicked(model: Linearisation) -> None:
    """A pulsation does nothing that a payload does; beside a gap near noise little of another's suffices, but some."""
    payload, hose = (make_effect(name, {"mass": 20.0}) for name in ("tip_payload", "end_hose"))
    kinds = [(type(payload), payload.site), (type(hose), hose.site), (type(PULSATION), PULSATION.site)]
    screening = Screening(model, kinds, [0.6])
    residual = np.zeros(len(model.noise.weight))
    own = screening.columns[:, screening.stretches[0]][:, 0]
    own = own / np.sqrt(screening.normal_equations(residual).diagonal[0] / len(own))

    def mimicked(effect: Effect, size: float) -> float:
        """Beside a gap whose square is as far above noise."""
        residual = np.zeros(len(model.noise.weight))
        residual[model.data.train] = np.sqrt(1 + size) * own
        return mimicry.mimicked(screening, (effect,), residual, 1.0)

    assert [mimicked(payload, size) for size in (0.001, 0.05, 1e4)] == [0.0, 1.0, 0.0]
    assert mimicked(PULSATION, 1e4) == 0.0
    alone = Screening(model, kinds[:1], [])
    assert mimicry.mimicked(alone, (payload,), residual, 1.0) == 0.0


def test_what_these_recordings_do_not_show_is_unseen(model: Linearisation) -> None:
    """Kinds count alike, however many points each is screened at."""
    payload = make_effect("tip_payload", {"mass": 20.0})
    screening = Screening(model, [(type(payload), payload.site), (type(PULSATION), PULSATION.site)], [0.6])
    residual = np.zeros(len(model.noise.weight))
    sizes = screening.normal_equations(residual).diagonal / len(screening.columns)
    points = screening.stretches[-1].start  # of the payload
    low, high = sorted(part.max() for part in (sizes[:points], sizes[points:]))

    def unseen(least: float) -> float:
        screening.model = replace(model, criteria=replace(model.criteria, least_gain=least))
        return mimicry.unseen(screening, residual)

    assert [unseen(least) for least in (0.9 * low, (low + high) / 2, high)] == [0.0, 0.5, 1.0]


def test_lines_stand_out_of_noise(model: Linearisation) -> None:
    data, rng = model.data, np.random.default_rng(0)
    noise = rng.standard_normal(len(data.time))
    assert spectral_lines(model, noise) == []
    (line,) = spectral_lines(model, noise + 5 * np.sin(2 * np.pi * 1.5 * data.time))
    assert abs(line - 1.5) < 0.1


def test_beside_a_cause_whose_size_is_free_counts_what_it_cannot_explain(model: Linearisation) -> None:
    """An end hose does almost what a payload does: beside one it has little left to explain."""
    payload, hose = (make_effect(name, {"mass": 20.0}) for name in ("tip_payload", "end_hose"))
    kinds = [(type(one), one.site) for one in (payload, hose, PULSATION)]
    screening = Screening(model, kinds, [0.6])
    first, *_, last = (screening.columns[:, part][:, 0] for part in screening.stretches)
    residual = np.zeros(len(model.noise.weight))
    residual[model.data.train] = 100 * first + 3 * last
    assert screening.rank(residual)[-1].candidate.effects[0].id == "pump_pulsation"
    found = screening.beside((payload,), residual, [0.6])
    assert [kind.id for kind, _ in found] == ["pump_pulsation", "end_hose"]
    promise = screening.promises((payload,), residual)
    assert [*found.values()] == [promise[kind.id, site.key] for kind, site in found]
    found = screening.beside((payload,), residual, [0.7])  # of which there is no column
    assert [kind.id for kind, _ in found] == ["pump_pulsation", "end_hose"] and next(iter(found.values())) == np.inf
    screening.model = replace(model, budget=replace(model.budget, beside=1))
    assert [kind.id for kind, _ in screening.beside((payload,), residual, [0.6])] == ["pump_pulsation"]


def test_a_glance_beside_a_known_machine_goes_by_what_its_sizes_change_there(model: Linearisation) -> None:
    """What a cause's own size explains is promised to no other; what is known of it is of the machine that it makes."""
    payload, hose = (make_effect(name, {"mass": 20.0}) for name in ("tip_payload", "end_hose"))
    screening = Screening(model, [(type(one), one.site) for one in (payload, hose, PULSATION)], [0.6])
    own, *_, other = (screening.columns[:, part][:, 0] for part in screening.stretches)
    residual, jacobian = np.zeros(len(model.noise.weight)), np.zeros((len(model.noise.weight), 1))
    residual[model.data.train], jacobian[model.data.train, 0] = 100 * own + other, own
    glance = screening.promises((payload,), residual, model, jacobian)
    assert glance == pytest.approx(screening.promises((payload,), residual), rel=0.05)
    assert max(glance, key=glance.__getitem__)[0] == "pump_pulsation" and len(glance) == 2
    blind = screening.promises((payload,), residual, model, 0 * jacobian)
    assert max(blind, key=blind.__getitem__)[0] == "end_hose"


def test_of_several_sizes_of_a_cause_the_nearest_follows(model: Linearisation) -> None:
    light, heavy, hose = (
        make_effect(name, {"mass": mass})
        for name, mass in (("tip_payload", 25.0), ("tip_payload", 70.0), ("end_hose", 40.0))
    )
    screening = Screening(model, [(type(one), one.site) for one in (light, hose, PULSATION)], [0.6])
    _, _, heaviest, *_, other = (screening.columns[:, part][:, 0] for part in screening.stretches)
    residual = np.zeros(len(model.noise.weight))
    residual[model.data.train] = 100 * heaviest + other
    promised = {one: screening.promises((one,), residual) for one in (light, heavy)}
    best = {one: max(found, key=found.__getitem__)[0] for one, found in promised.items()}
    assert best == {light: "end_hose", heavy: "pump_pulsation"}
