"""The unit of a log's numbers, guessed from what they are called and how large they are."""

import re

import numpy as np

from boom_mj.recording import QUANTITIES
from boom_mj.recording import UNITS as UNITS

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
