"""Units that logs come in, and what they are in SI."""

import re
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from boom_mj.recording import QUANTITIES

UNITS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "rad": {"rad": 1.0, "deg": np.pi / 180, "mrad": 1e-3, "rev": 2 * np.pi},
        "rad/s": {"rad/s": 1.0, "deg/s": np.pi / 180, "rpm": 2 * np.pi / 60},
        "m/s^2": {"m/s^2": 1.0, "g": 9.80665, "mg": 9.80665e-3},
        "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
        "N": {"N": 1.0, "kN": 1e3, "MN": 1e6},
        "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    }
)
"""SI unit -> unit of a log -> factor."""

GUESS = "?"  # marks a unit that was guessed from the values
PLAUSIBLE = {  # by signal or SI unit: (least, most) of the largest magnitude, in SI; beyond it the next unit is tried
    "rad": (0.0, 2 * np.pi),
    "rad/s": (0.0, 6.0),
    "m/s^2": (5.0, 100.0),
    "m": (0.0, 200.0),
    "cylinder/force": (2e3, 1e7),
    "load": (0.0, 1e6),
}


def guess_unit(signal: str, largest: float, names: tuple[str, ...], by_convention: bool) -> str:
    """Unit of the numbers that feed a signal: the first in which they are plausible.

    Args:
        largest: their largest magnitude, in the unit of the log.
        names: what they are called; names may end in a unit, such as "boom_deg".
        by_convention: whether the message type prescribes SI.

    Returns:
        The unit; with a question mark where neither the type nor all of the names speak for it.
    """
    si = QUANTITIES[signal].unit
    for unit in UNITS[si]:
        ending = re.compile(rf"[_ \[(]{re.escape(unit).replace('/', '[_/]?')}[\])]?$", re.IGNORECASE)
        if names and all(ending.search(name) for name in names):
            return unit
    least, most = PLAUSIBLE.get(signal) or PLAUSIBLE[si]
    for unit, factor in UNITS[si].items():
        if least <= largest * factor <= most or not largest:
            return unit if by_convention and unit == si else unit + GUESS
    return si + GUESS
