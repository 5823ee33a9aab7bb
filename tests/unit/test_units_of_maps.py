"""What a channel map says of units and signs is held against the nominal model, and what is off is said."""

from pathlib import Path

import numpy as np
import pytest
from cart import MAP, MODEL

from boom_mj.systems.mjcf import load_mjcf


def said(
    folder: Path, motion: float = 1.0, force: float = 1.0, text: str = MAP, kind: str = "slide", mass: float = 2.0
) -> list[tuple[str, str, str]]:
    """Findings of a mass of 2 kg in the model that moves, with logged numbers so many times what they should be."""
    time = np.arange(0, 10, 0.01)
    q = 0.3 * np.sin(2 * time) + 0.1 * np.sin(5 * time)
    f = -mass * (1.2 * np.sin(2 * time) + 2.5 * np.sin(5 * time))
    f += 0.01 * np.random.default_rng(0).normal(size=len(time))
    rows = [f"{a:.3f},{b:.9g},{c:.9g}" for a, b, c in zip(time, motion * q, force * f)]
    (folder / "log.csv").write_text("\n".join(["t,q,f", *rows]) + "\n")
    (folder / "map.toml").write_text(text)
    (folder / "cart.xml").write_text(MODEL.format(kind=kind))
    found = load_mjcf([folder / "log.csv"], [], folder / "map.toml").findings
    return [(finding.channel, finding.kind, finding.evidence) for finding in found]


def test_a_right_map_is_not_doubted(tmp_path: Path) -> None:
    """Nor is one of a machine five times as heavy as its model, or a fifth of it."""
    for mass in (2.0, 10.0, 0.4):
        assert said(tmp_path, mass=mass) == []


@pytest.mark.parametrize(
    ("motion", "force", "channel", "kind", "text"),
    [
        (1, 1e-3, "force", "unit", "as if in kN instead of N: scale = 1000"),
        (1, 1e6, "force", "unit", "as if in 1e-6 N instead of N: scale = 1e-06"),
        (1, -1, "force", "sign", "is the negative of what the model says: scale = -1"),
        (1, -1e-3, "force", "unit", "instead of N: scale = -1000"),
        (-1, 1, "force", "sign", "is the negative"),
        (1e3, 1, "force", "unit", "as if in kN"),  # the one or the other
    ],
)
def test_what_is_compared(tmp_path: Path, motion: float, force: float, channel: str, kind: str, text: str) -> None:
    ((where, what, evidence),) = [one for one in said(tmp_path, motion, force) if one[0] == channel]
    assert (where, what) == (channel, kind) and text in evidence


def test_a_position_beyond_what_its_joint_can_do(tmp_path: Path) -> None:
    degrees = MAP.replace('"slide"', '"hinge"').replace('"m"', '"rad"')
    (found,) = [one for one in said(tmp_path, 57.3, 1.0, degrees, "hinge") if one[0] == "motion"]
    assert found[1] == "unit" and "reaches 22" in found[2] and "as if in deg: scale = 0.0174533" in found[2]
