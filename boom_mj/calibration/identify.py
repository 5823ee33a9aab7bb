"""What the data tell apart: rank, condition, correlated pairs, null directions, and coordinates made fewer.

With J the whitened sensitivities, H = J^T J is the information of independent residuals; a combination of coordinates
that it leaves free by more than WIDEST is not told by the data. Parameters of a kind that are confused are joined, so
that their ratio stays that of the machine file; one that nothing tells and that has no neighbour to join is held.
"""

from dataclasses import dataclass

import numpy as np

from boom_mj.calibration.parameters import Space

Array = np.ndarray
WIDEST = 0.03  # deviation of a logarithm, from independent residuals, beyond which a coordinate is not told
ALIKE = 0.9  # correlation that is named
NULL = 0.5  # deviation of a unit combination, beyond which it counts as free
SHOWN = 0.3  # share of a combination from which on a coordinate is named in it


@dataclass(frozen=True)
class Identifiability:
    """What sensitivities say of coordinates.

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


def identify(jacobian: Array, space: Space) -> Identifiability:
    """What the data tell of the coordinates of a space, with whitened sensitivities (N, space.size)."""
    spread, knobs = covariance(jacobian), len(space.knobs)
    deviation = np.sqrt(np.diag(spread))
    alike = spread / np.outer(deviation, deviation)
    pairs = [(space.names[i], space.names[k], float(alike[i, k])) for i in range(space.size) for k in range(i)]
    size, direction = np.linalg.eigh(spread[:knobs, :knobs])  # zero offsets follow freely
    free = np.flatnonzero(size > NULL**2)
    length = np.linalg.norm(jacobian, axis=0)
    told = jacobian[:, length > 0] / length[length > 0]
    return Identifiability(
        rank=space.size - len(free),
        size=space.size,
        condition=float(np.linalg.cond(told)) if told.shape[1] == space.size else float("inf"),
        correlated=tuple(sorted((p for p in pairs if abs(p[2]) > ALIKE), key=lambda p: -abs(p[2]))),
        null=tuple(_combination(space, direction[:, k]) for k in free[::-1]),
    )


def _combination(space: Space, weights: Array) -> tuple[tuple[str, float], ...]:
    weights = weights * np.sign(weights[np.argmax(np.abs(weights))])
    named = [(space.names[k], float(w)) for k, w in enumerate(weights) if abs(w) > SHOWN]
    return tuple(sorted(named, key=lambda item: -abs(item[1])))


def simplify(jacobian: Array, space: Space) -> tuple[Space, tuple[str, ...]]:
    """A space whose coordinates the data tell, and a sentence about each that was given up."""
    said: list[str] = []
    whole = space
    information = jacobian.T @ jacobian
    while True:
        gathering = space.gathering(whole)
        told = gathering.T @ information @ gathering
        spread = inverse(told)
        deviation = np.sqrt(np.diag(spread))[: len(space.knobs)]
        if not len(deviation) or deviation.max() <= WIDEST:
            return space, tuple(said)
        worst = int(np.argmax(deviation))
        knob, loose = space.knobs[worst], deviation[worst]
        felt = np.sqrt(told[worst, worst])  # 1 / deviation if all else were known
        rivals = [k for k, other in enumerate(space.knobs) if other.kind == knob.kind and k != worst]
        if felt * WIDEST < 1 or not rivals:
            said.append(f"{knob.name} stays at the machine file's: {_unsure(loose)}")
            space = space.without(worst)
            continue
        partner = max(rivals, key=lambda k: abs(spread[worst, k]) / deviation[k])
        said.append(f"{knob.name} and {space.knobs[partner].name} keep their ratio: apart, {_unsure(loose)}")
        space = space.joined(worst, partner)


def _unsure(deviation: float) -> str:
    return "these data do not tell it" if deviation > NULL else f"these data tell it to {deviation:.0%} only"
