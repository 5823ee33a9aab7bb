"""What happened on a bench, simulated by the diagnosing model, leaves the noise: two models of one machine agree.

The plant has another integrator, finer steps, servos and gears of its own; the model follows what was measured.
"""

from pathlib import Path

import numpy as np
import pytest

from boom_mj.blind import MjcfBench
from boom_mj.blind.mjcf_bench import _healthy, _recorded
from boom_mj.diagnosis.linearisation import Linearisation, linearise
from boom_mj.effects import parse_effect
from boom_mj.estimation.bootstrap import gap
from boom_mj.systems.fidelity import Level

BENCHES = Path(__file__).parents[2] / "models" / "benches"
LEFT = 2.0  # what every plant has and the model lacks, with noise that remembers
MUCH = 5.0  # times as much without the effect
HAPPENED = (
    ("servo_pendulum", "coulomb_friction:joint=hinge,force=0.45"),
    ("leg", "coulomb_friction:joint=hip,force=0.6"),
    ("cart", "directional_friction:joint=track,force=1.2,forward=-2.0,backward=3.0"),
    ("cart", "actuator_bias:actuator=motor,offset=-0.4"),
    ("linear_drive", "viscous_joint_friction:joint=slide,damping=30"),
    ("crane", "coulomb_friction:joint=stick,force=340"),
)


def about(name: str, *effects: str) -> Linearisation:
    """A bench's machine with what happened to it, on logs of it."""
    bench = MjcfBench.beside(BENCHES / f"{name}.toml")
    own = bench.individual(np.random.default_rng(0), False)
    happened = tuple(parse_effect(text, bench.sites) for text in effects)
    model = linearise(_recorded(bench, (*own, *happened)))
    estimate = np.zeros(len(model.nuisances))
    return model.rebased(happened, estimate).relinearised(happened, estimate)


@pytest.mark.parametrize(("name", "effect"), HAPPENED)
def test_the_truth_leaves_noise(name: str, effect: str) -> None:
    model = about(name, effect)
    left, before = (gap(model.clean(model.residual(*model.predict([e]))), model.data.used) for e in (model.effects, ()))
    assert left < LEFT and before > MUCH * left


def test_a_rest_that_friction_holds_either_way_is_unsure() -> None:
    """Of a driven joint: what its friction does at rest no motion tells."""
    model = about("linear_drive", "coulomb_friction:joint=slide,force=9")
    residual = model.data.measured - model.predict([model.effects])[0] - model.mean_error
    noise, worst = model.data.noise, np.abs(residual) > 10 * model.data.noise
    inflated = 1 / (model.noise.weight * noise)
    assert worst.sum() > 20 and np.median(inflated[worst]) > 5 and np.median(inflated) < 1.2
    assert gap(model.noise.white(residual), model.data.used) < 1.5 * LEFT < gap(residual / noise, model.data.used)


@pytest.mark.parametrize("name", ["servo_pendulum", "cart", "flexible_arm"])
def test_what_steps_lack_is_extrapolated(name: str) -> None:
    """Against a sixteenth of the step, to a tenth of what is missing; what may be wrong of it holds the rest."""
    predictor = _healthy(MjcfBench.beside(BENCHES / f"{name}.toml"))
    model, data = linearise(predictor), predictor.data
    missing = (predictor.predict([()], Level(1 / 16))[0] - predictor.predict([()], Level(1.0))[0]) * 16 / 15
    size, miss = (gap(vector / data.noise, data.used) for vector in (missing, missing - model.mean_error))
    assert miss < 0.1 * size
    assert gap(np.sqrt(np.maximum(1 / model.noise.weight**2 - data.noise**2, 0)) / data.noise, data.used) > 0.3 * miss
