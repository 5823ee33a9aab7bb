"""What sensitivities tell apart is kept, what they do not is joined or held, and said."""

from pathlib import Path

import numpy as np
import pytest

from boom_mj.calibration.identify import identify, simplify
from boom_mj.calibration.parameters import KINDS, make_parameterisation
from boom_mj.errors import InputError
from boom_mj.machine import load_machine

BOOM = load_machine(Path(__file__).parents[2] / "models" / "boom36.toml")
FREE = make_parameterisation(BOOM, ("mass", "shear_modulus"))


def sensitivities() -> np.ndarray:
    """Independent and strong."""
    return 1e3 * np.linalg.qr(np.random.default_rng(0).normal(size=(500, FREE.size)))[0]


def test_what_is_told_stays() -> None:
    known = identify(sensitivities(), FREE)
    assert (known.rank, known.size, known.null, known.correlated) == (13, 13, (), ())
    assert known.condition == pytest.approx(1)
    assert simplify(sensitivities(), FREE) == (FREE, ())


def test_what_nothing_moves_is_held_and_named() -> None:
    jacobian = sensitivities()
    jacobian[:, FREE.names.index("link5.shear_modulus")] = 0
    known = identify(jacobian, FREE)
    assert known.rank == 12
    assert [names[0][0] for names in known.null] == ["link5.shear_modulus"]
    free, said = simplify(jacobian, FREE)
    assert set(FREE.names) - set(free.names) == {"link5.shear_modulus"}
    assert "link5.shear_modulus" in said[0]


def test_what_looks_alike_keeps_its_ratio() -> None:
    """Two masses with nearly the same columns: only their product is told."""
    jacobian = sensitivities()
    jacobian[:, 1] = jacobian[:, 0] + 1e-3 * jacobian[:, 1]
    known = identify(jacobian, FREE)
    assert known.correlated[0][:2] == ("link3.mass", "link2.mass") and known.correlated[0][2] < -0.99
    free, said = simplify(jacobian, FREE)
    assert "link2+3.mass" in free.names and len(free.tied) == len(FREE.tied) - 1
    assert "keep their ratio" in said[0]
    gathering = free.gathering(FREE)
    assert gathering[:, free.names.index("link2+3.mass")].tolist() == [1, 1, *[0] * 11]


def test_parameters_that_are_none() -> None:
    with pytest.raises(InputError, match=f"no parameter 'colour'.*{', '.join(KINDS)}"):
        make_parameterisation(BOOM, ("colour",))
    undamped = BOOM.damping.model_copy(update={"relaxation_time": 0.0})
    with pytest.raises(InputError, match=r"damping .* is zero"):
        make_parameterisation(BOOM.model_copy(update={"damping": undamped}), ("damping",))
