"""What the data tell apart: rank, condition, correlated pairs, null directions, and scaled parameters made fewer.

With J the whitened sensitivities, H = J^T J is the information of independent residuals; a combination of scaled
parameters that it leaves free by more than WIDEST is not identifiable. Parameters of a kind that are confused are tied,
so that their ratio stays that of the machine file; one that nothing informs and that has no neighbour is fixed.
"""

from dataclasses import dataclass

import numpy as np

from boom_mj.calibration.parameters import Parameterisation

Array = np.ndarray
WIDEST = 0.03  # deviation of a logarithm, from independent residuals, beyond which a scaled parameter is not told
ALIKE = 0.9  # correlation that is named
NULL = 0.5  # deviation of a unit combination, beyond which it counts as free
SHOWN = 0.3  # share of a combination from which on a scaled parameter is named in it


@dataclass(frozen=True)
class Identifiability:
    """What sensitivities say of scaled parameters.

    Attributes:
        rank: directions that the data tell, of `size`.
        condition: of the sensitivities, each scaled to its length.
        correlated: (name, name, correlation) of the estimates, strongest first.
        null: combinations that stay free, each as names with their weights.
    """

    rank: int
    size: int
    condition: float
    correlated: tuple[tuple[str, str, float], ...]
    null: tuple[tuple[tuple[str, float], ...], ...]


def covariance(jacobian: Array) -> Array:
    """(J^T J)^-1 of whitened sensitivities (N, p), (p, p)."""
    return inverse(jacobian.T @ jacobian)


def inverse(information: Array) -> Array:
    """Of a symmetric matrix that may be singular, (p, p): with a large variance instead of an infinite one."""
    scale = np.sqrt(np.maximum(np.diag(information), 1e-12))
    size, direction = np.linalg.eigh(information / np.outer(scale, scale))
    return (direction / np.maximum(size, 1e-12)) @ direction.T / np.outer(scale, scale)


def identify(jacobian: Array, free: Parameterisation) -> Identifiability:
    """What the data tell of the scaled parameters of a parameterisation, with whitened sensitivities (N, free.size)."""
    spread, tied = covariance(jacobian), len(free.tied)
    deviation = np.sqrt(np.diag(spread))
    alike = spread / np.outer(deviation, deviation)
    pairs = [(free.names[i], free.names[k], float(alike[i, k])) for i in range(free.size) for k in range(i)]
    size, direction = np.linalg.eigh(spread[:tied, :tied])  # zero offsets follow freely
    open_ended = np.flatnonzero(size > NULL**2)
    length = np.linalg.norm(jacobian, axis=0)
    informed = jacobian[:, length > 0] / length[length > 0]
    return Identifiability(
        rank=free.size - len(open_ended),
        size=free.size,
        condition=float(np.linalg.cond(informed)) if informed.shape[1] == free.size else float("inf"),
        correlated=tuple(sorted((p for p in pairs if abs(p[2]) > ALIKE), key=lambda p: -abs(p[2]))),
        null=tuple(_combination(free, direction[:, k]) for k in open_ended[::-1]),
    )


def _combination(free: Parameterisation, weights: Array) -> tuple[tuple[str, float], ...]:
    weights = weights * np.sign(weights[np.argmax(np.abs(weights))])
    named = [(free.names[k], float(w)) for k, w in enumerate(weights) if abs(w) > SHOWN]
    return tuple(sorted(named, key=lambda item: -abs(item[1])))


def simplify(jacobian: Array, free: Parameterisation) -> tuple[Parameterisation, tuple[str, ...]]:
    """A parameterisation whose scaled parameters the data tell, and a sentence about each that was fixed."""
    said: list[str] = []
    whole = free
    information = jacobian.T @ jacobian
    while True:
        gathering = free.gathering(whole)
        told = gathering.T @ information @ gathering
        spread = inverse(told)
        deviation = np.sqrt(np.diag(spread))[: len(free.tied)]
        if not len(deviation) or deviation.max() <= WIDEST:
            return free, tuple(said)
        worst = int(np.argmax(deviation))
        group, loose = free.tied[worst], deviation[worst]
        felt = np.sqrt(told[worst, worst])  # 1 / deviation if all else were known
        rivals = [k for k, other in enumerate(free.tied) if other.kind == group.kind and k != worst]
        if felt * WIDEST < 1 or not rivals:
            said.append(f"{group.name} stays at the machine file's: {_unsure(loose)}")
            free = free.without(worst)
            continue
        partner = max(rivals, key=lambda k: abs(spread[worst, k]) / deviation[k])
        said.append(f"{group.name} and {free.tied[partner].name} keep their ratio: apart, {_unsure(loose)}")
        free = free.joined(worst, partner)


def _unsure(deviation: float) -> str:
    return "these data do not tell it" if deviation > NULL else f"these data tell it to {deviation:.0%} only"
