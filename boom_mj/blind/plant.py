"""The machine of a case: one individual, simulated otherwise than the diagnosis does."""

from collections.abc import Sequence

import mujoco
import numpy as np

from boom_mj.effects import Effect, effects_of, make_effect
from boom_mj.machine import Machine
from boom_mj.mjcf import build
from boom_mj.simulation import Plant
from boom_mj.simulation.plant import JOINTS, with_effects

HINGES = 8  # the diagnosis has 2, 3 and 4
INTEGRATOR = mujoco.mjtIntegrator.mjINT_EULER  # the diagnosis has implicitfast
STEP = 0.1  # of the diagnosis' own; at 0.4 a hose of 24 kg weighed 24.07, the step's own error, at 0.1 24.00
ZERO_OFFSET = np.radians(0.3)
STIFFNESS, MASS, DAMPING = 0.003, 0.003, 0.05  # how far an individual is off
AS_BUILT = 0.03, 0.02, 0.25  # and how far before anyone has calibrated its file


def nuisances(
    machine: Machine, rng: np.random.Generator, scatter: tuple[float, float, float] = (STIFFNESS, MASS, DAMPING)
) -> tuple[Effect, ...]:
    """What no two machines share: zero offsets of the joints, small errors of stiffness, mass, damping; all uniform.

    Args:
        scatter: how far those three go, as shares.
    """
    stiffness, mass, damping = scatter
    offsets = rng.uniform(-1, 1, JOINTS) * ZERO_OFFSET
    found = [make_effect("joint_zero_offset", {"joint": k + 1, "offset": offset}) for k, offset in enumerate(offsets)]
    for link in range(2, 2 + len(machine.links)):
        softer, heavier = rng.uniform(-1, 1, 2)
        found += [
            make_effect("link_stiffness", {"link": link, "axis": axis, "factor": 1 + stiffness * softer})
            for axis in ("v", "w", "torsion")
        ]
        found.append(make_effect("link_mass", {"link": link, "factor": 1 + mass * heavier}))
    return (*found, make_effect("structural_damping", {"factor": 1 + damping * rng.uniform(-1, 1)}))


def true_plant(machine: Machine, effects: Sequence[Effect], step: float = STEP) -> Plant:
    """A machine with finer hinges, another integrator and shorter steps than any that the diagnosis simulates.

    Args:
        step: in steps of the diagnosis.
    """
    boom = build(machine, HINGES)
    boom.spec.option.integrator = INTEGRATOR
    boom.spec.option.timestep *= step
    return with_effects(boom, (*effects_of(machine), *effects))
