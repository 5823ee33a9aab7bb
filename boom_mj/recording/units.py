"""Units that logs come in, and what they are in SI: one table for reading logs and for naming what they got wrong."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

UNITS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "rad": {"rad": 1.0, "deg": np.pi / 180, "mrad": 1e-3, "rev": 2 * np.pi},
        "rad/s": {"rad/s": 1.0, "deg/s": np.pi / 180, "rpm": 2 * np.pi / 60, "mrad/s": 1e-3},
        "m/s^2": {"m/s^2": 1.0, "g": 9.80665, "mg": 9.80665e-3},
        "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
        "N": {"N": 1.0, "kN": 1e3, "MN": 1e6, "kgf": 9.80665, "daN": 10.0},
        "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    }
)
"""SI unit -> unit of a log -> factor; what a guess tries first stands first."""
