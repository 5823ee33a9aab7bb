"""Screening: where fits begin."""

import numpy as np

from boom_mj.diagnosis.linearisation import Metric
from boom_mj.diagnosis.screening import Signatures
from boom_mj.effects import effect_library

PULSE, UP = effect_library()["pump_pulsation"], {"direction": "vertical"}


def test_a_misfit_that_several_periods_explain_starts_fits_at_each(metric: Metric) -> None:
    """Two seconds do not tell 0.60 from 0.62 Hz, and tell both from 3 Hz."""
    signatures = Signatures(metric, [(PULSE, UP)], [0.60, 0.62, 3.0])
    residual = np.zeros(len(metric.weight))
    residual[metric.campaign.train] = signatures.columns[:, signatures.stretches[0]] @ np.array([2.0, 1.0])
    (found,) = signatures.rank(residual)
    found_at = [candidate.effects[0].values["frequency"] for candidate in found.starts]
    assert {0.60, 0.62} <= {*found_at} and not {1.5, 3.0} & {*found_at}
