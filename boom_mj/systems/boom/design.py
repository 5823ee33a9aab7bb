"""Which experiment of the catalogue would separate explanations that these data cannot."""

from collections.abc import Sequence

import numpy as np

from boom_mj.effects import Effect, make_effect
from boom_mj.errors import BoomError
from boom_mj.machine import Machine
from boom_mj.sensors import measure, noise_levels
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment

Array = np.ndarray
LONGEST = 125.0  # s


def next_experiment(machine: Machine, explanations: Sequence[tuple[Effect, ...]], done: Sequence[str]) -> str | None:
    """The experiment whose sensors would differ most, per second, between the two closest of some explanations.

    Zero offsets of the joint sensors are projected out: what they can imitate separates nothing.
    """
    levels = noise_levels(machine)

    def recorded(effects: tuple[Effect, ...], name: str) -> Array:
        plan = CATALOGUE[name]
        found = measure(run_experiment(make_plant(machine, 1, effects), plan), name, "", plan.duration)
        parts = [found[s].values / level for s, level in levels.items() if s != "joint/position"]
        return np.concatenate([part.ravel() for part in parts])

    scores: dict[str, float] = {}
    for name, plan in CATALOGUE.items():
        if name in done or plan.duration > LONGEST:
            continue
        try:
            twins = [recorded(effects, name) for effects in explanations]
            nominal = recorded((), name)
            zero = [
                recorded((make_effect("joint_zero_offset", {"joint": k, "offset": 0.002}),), name) for k in range(1, 6)
            ]
        except BoomError:
            continue
        basis = np.linalg.qr(np.stack([z - nominal for z in zero], axis=1))[0]
        distances = []
        for k, a in enumerate(twins):
            for b in twins[k + 1 :]:
                difference = a - b
                difference -= basis @ (basis.T @ difference)
                distances.append(float(difference @ difference) / plan.duration)
        scores[name] = min(distances)
    return max(scores, key=lambda name: scores[name]) if scores else None
