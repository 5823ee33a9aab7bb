"""Screening: where fits begin."""

from dataclasses import replace

import numpy as np

from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.screening import Screening, spectral_lines
from boom_mj.effects import make_effect

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
    """A pulsation does nothing that a payload does; whoever may leave all does what all others do."""
    payload, hose = (make_effect(name, {"mass": 20.0}) for name in ("tip_payload", "end_hose"))
    kinds = [(type(payload), payload.site), (type(hose), hose.site), (type(PULSATION), PULSATION.site)]
    screening = Screening(model, kinds, [0.6])
    residual = np.zeros(len(model.noise.weight))
    residual[model.data.train] = 100 * screening.columns[:, screening.stretches[0]][:, 0]
    assert screening.mimicked((PULSATION,), residual, 1.03) == 0.0
    assert screening.mimicked((payload,), residual, 1e9) == 2.0
    alone = Screening(model, kinds[:1], [])
    assert alone.mimicked((payload,), residual, 1e9) == 0.0


def test_what_these_recordings_do_not_show_is_unseen(model: Linearisation) -> None:
    """Kinds count alike, however many points each is screened at."""
    payload = make_effect("tip_payload", {"mass": 20.0})
    screening = Screening(model, [(type(payload), payload.site), (type(PULSATION), PULSATION.site)], [0.6])
    residual = np.zeros(len(model.noise.weight))
    sizes = screening.normal_equations(residual).diagonal / len(screening.columns)
    low, high = sorted(np.sqrt(1 + part.max()) for part in (sizes[:1], sizes[1:]))
    assert [screening.unseen(residual, enough) for enough in (0.9 * low, (low + high) / 2, high)] == [0.0, 0.5, 1.0]


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
    parts = [screening.columns[:, part][:, 0] for part in screening.stretches]
    residual = np.zeros(len(model.noise.weight))
    residual[model.data.train] = 100 * parts[0] + 3 * parts[2]
    assert screening.rank(residual)[-1].candidate.effects[0].id == "pump_pulsation"
    assert [kind.id for kind, _ in screening.beside((payload,), residual)] == ["pump_pulsation", "end_hose"]
    screening.model = replace(model, budget=replace(model.budget, beside=1))
    assert [kind.id for kind, _ in screening.beside((payload,), residual)] == ["pump_pulsation"]
