"""`logs inspect` and the maps that it proposes."""

import json
import subprocess
import sys

import numpy as np
import pytest
from foreign import (
    ANGLES,
    START,
    joint_states,
    log_of,
    proposed,
)

from boom_mj.errors import LogWarning, TopicMapError
from boom_mj.logs import load_topic_map, read_log
from boom_mj.logs.inspection import inspect_log
from boom_mj.logs.proposal import propose_map


def boom(*arguments: object) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "boom_mj", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300)


def test_inspect_says_what_is_wrong_with_the_times(tmp_path):
    messages = joint_states()
    odd = [*messages[:30], messages[29], *messages[60:], *messages[:5]]
    path = log_of(tmp_path, odd)
    topic = inspect_log(path).topics[0]
    assert topic.header.rate_hz == pytest.approx(50)
    assert (topic.header.repeated, topic.header.gaps, topic.header.resets) == (1, 1, 1)
    assert topic.header.longest_gap == pytest.approx(0.62)
    assert topic.header.longest_gap_at == pytest.approx(START + 0.58)
    assert topic.header.first_reset == pytest.approx(START + 2.0)
    assert (topic.log.repeated, topic.log.gaps, topic.log.resets) == (0, 0, 0)
    assert topic.time_base == "log"
    assert topic.fields["position"]["joint2"].least == ANGLES[:, 1].min()


def test_inspect_guesses_degrees_and_the_guess_is_not_accepted(tmp_path):
    path = log_of(tmp_path, joint_states(angles=np.rad2deg(ANGLES)))
    shown = boom("logs", "inspect", path)
    assert shown.returncode == 0, shown.stderr
    assert 'unit = "deg?"' in shown.stdout and "guess" in shown.stdout and "50.00 Hz" in shown.stdout
    (tmp_path / "map.toml").write_text(boom("logs", "inspect", path, "--map").stdout)
    with pytest.raises(TopicMapError, match="is a guess"):
        load_topic_map(tmp_path / "map.toml")
    found = read_log(path, proposed(path, tmp_path))["joint/position"].values
    np.testing.assert_allclose(found, ANGLES, rtol=0, atol=1e-15)
    document = json.loads(boom("logs", "inspect", path, "--json").stdout)
    assert document["topics"][0]["fields"]["position"]["joint1"]["max"] == pytest.approx(np.rad2deg(ANGLES[:, 0].max()))
    assert document["topics"][0]["header_time"]["rate_hz"] == pytest.approx(50)
    for arguments, status in (
        ((tmp_path / "no.mcap",), 2),
        ((path, "--json", "--map"), 2),
        ((tmp_path / "map.toml",), 1),
    ):
        done = boom("logs", "inspect", *arguments)
        assert done.returncode == status and done.stdout == "" and "Traceback" not in done.stderr


def test_columns_of_a_table_are_recognised_by_their_names_and_what_is_doubtful_is_said(tmp_path):
    names = ["Zeit", "Drehwerk", *(f"Arm{i}_deg" for i in range(1, 5)), "Arm1_soll_deg", "Zylinder2_Kraft_kN"]
    names += [f"link5_acc_{axis}_g" for axis in "xyz"]
    rows = [[1000 / 15 * i, 10.0, 60 + i / 90, -35, -40, -45, 60, 420.1, 0, 1, 0] for i in range(90)]
    lines = [";".join(f"{x:.3f}".replace(".", ",") for x in row) for row in rows]
    path = tmp_path / "messy.csv"
    path.write_text(";".join(names) + "\n" + "\n".join(lines) + "\n")
    text = propose_map(inspect_log(path))
    for line in (
        'from = ["Drehwerk", "Arm1_deg", "Arm2_deg", "Arm3_deg", "Arm4_deg"]',
        'unit = "deg?"',  # one of the names does not say so
        'time_unit = "ms?"',
        'unit = "g"',
        "# cylinder3 not found",
        '# from = ["Arm1_soll_deg"]',
    ):
        assert f"\n{line}" in text
    with pytest.warns(LogWarning, match="joint angles at 15.0 Hz"):
        found = read_log(path, proposed(path, tmp_path))
    assert set(found.signals) == {"joint/position", "imu/link5/specific_force"}
    np.testing.assert_allclose(found["joint/position"].values[0], np.deg2rad([10, 60, -35, -40, -45]))
    np.testing.assert_allclose(found["imu/link5/specific_force"].values[0], [0, 9.80665, 0])


def test_replay_takes_a_map(tmp_path):
    time = np.arange(0, 4, 0.02)
    angles = np.outer(np.ones_like(time), [0, 1.0, -0.5, -0.5, -0.5])
    path = log_of(tmp_path, joint_states(angles=np.rad2deg(angles), time=time))
    (tmp_path / "map.toml").write_text(propose_map(inspect_log(path)).replace('"deg?"', '"deg"'))
    done = boom("replay", path, "--map", tmp_path / "map.toml", "--machine", "boom36", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["timing"]["simulated_s"] == pytest.approx(time[-1])
    refused = boom("replay", path, "--machine", "boom36")
    assert refused.returncode == 1 and "degrees" in refused.stderr and refused.stdout == ""
