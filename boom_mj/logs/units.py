"""Units that logs come in, and what they are in SI."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

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
PLAUSIBLE = {  # (least, most) of the largest absolute value, in SI; beyond it the next unit is tried
    "rad": (0.0, 2 * np.pi),
    "rad/s": (0.0, 6.0),
    "m/s^2": (5.0, 100.0),
    "m": (0.0, 200.0),
    "N": (2e3, 1e7),
}


def guess_unit(si: str, largest: float, hint: str = "") -> str:
    """Unit of values whose largest magnitude is known: the first in which it is plausible.

    Args:
        si: SI unit of the quantity.
        largest: magnitude in the unit of the log.
        hint: name that may end in a unit, such as "boom_deg".

    Returns:
        The unit; with a question mark where neither the SI unit nor the name speaks for it.
    """
    named = [unit for unit in UNITS[si] if hint.lower().replace("/", "").endswith("_" + unit.lower().replace("/", ""))]
    if named:
        return named[0]
    least, most = PLAUSIBLE[si]
    for unit, factor in UNITS[si].items():
        if least <= largest * factor <= most or not largest:
            return unit if unit == si else unit + GUESS
    return si + GUESS
