"""Bad machine files are refused with place, value and what is allowed; all at once."""

import math
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from boom_mj.errors import MachineFileError
from boom_mj.machine import cylinder_forces, load_machine, parse_machine

TEXT = (Path(__file__).parents[2] / "models" / "boom36.toml").read_text()


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("length = 8.50", "length = -8.50", ["link2.length", "-8.5", "greater than 0"]),
        ("length = 8.10", "length = nan", ["link3.length", "nan", "finite"]),
        ("gravity = 9.81", "gravty = 9.81", ["gravity is missing", "gravty", "unknown key", "known here", "slewing"]),
        ("support = -6.70", "support = -9.0", ["link2", "support = -9.0", "between -8.5 and 0"]),
        ("range_deg = [-2.0, 88.0]", "range_deg = [88.0, -2.0]", ["link2.range_deg", "88.0", "below"]),
        ("center_of_gravity = -4.40", "center_of_gravity = -3.0", ["link3", "-3.0", "heavier at the tip", "-4.05"]),
        ("height = [0.32, 0.245]", "height = [0.32, 0.9]", ["link4", "section at the tip", "heavier"]),
        ("wall = [0.005, 0.004]", "wall = [0.005]", ["link4.wall.1 is missing"]),
        ("wall = [0.005, 0.004]", "wall = [0.2, 0.004]", ["link4", "wall = 0.2", "half the box"]),
        ("mass = 2000.0", 'mass = "heavy"', ["link2.mass", "'heavy'", "number"]),
        ('kind = "ramp"', 'kind = "slope"', ["offset_profile.kind", "'slope'", "'ramp' or 'step'"]),
        ("rod_diameter = 0.130", "rod_diameter = 0.3", ["cylinder2", "0.3", "below the bore"]),
        ('name = "link4"', 'name = "link7"', ["'link7'", "'link4'", "order"]),
        ("[slewing]", "[slewing", ["not a TOML file", "line"]),
    ],
)
def test_every_bad_value_is_named(old: str, new: str, told: list[str]) -> None:
    assert TEXT.count(old) >= 1
    with pytest.raises(MachineFileError) as caught:
        parse_machine(TEXT.replace(old, new, 1), "boom.toml")
    message = str(caught.value)
    assert all(line.startswith("boom.toml: ") for line in message.splitlines())
    for part in told:
        assert part in message
    assert len(message) < 600  # the culprit, not the whole file


def test_all_bad_values_are_reported_at_once() -> None:
    text = TEXT.replace("length = 8.50", "length = 0", 1).replace("mass = 620.0", "mass = -1", 1)
    with pytest.raises(MachineFileError, match=r"link2\.length(.|\n)*link4\.mass"):
        parse_machine(text)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(MachineFileError, match=r"nowhere\.toml"):
        load_machine(tmp_path / "nowhere.toml")


def test_the_machine_is_frozen_and_in_radians() -> None:
    machine = parse_machine(TEXT)
    with pytest.raises(ValidationError):
        machine.links[0].length = 1.0
    assert machine.drives[1].range == pytest.approx((math.radians(-2), math.radians(88)))
    assert sum(link.length for link in machine.links) == pytest.approx(32.0)


def test_a_cylinder_without_a_moment_arm_is_named() -> None:
    machine = parse_machine(TEXT.replace("rocker_length = 0.80", "rocker_length = 1e15"))
    with pytest.raises(MachineFileError, match=r"boom36: cylinder3 has no moment arm at joint3 = -35\.00 deg"):
        cylinder_forces(machine, np.radians([[0, 60, -35, 0, 0]]), np.ones((1, 5)))


def test_zero_offsets_of_version_0_1_are_one_entry_each() -> None:
    old = '\n[[effect]]\nid = "joint_zero_offset"\njoint1 = 0.002\njoint3 = -0.001\n'
    assert [entry.model_dump() for entry in parse_machine(TEXT + old).effect] == [
        {"id": "joint_zero_offset", "joint": 1, "offset": 0.002},
        {"id": "joint_zero_offset", "joint": 3, "offset": -0.001},
    ]
