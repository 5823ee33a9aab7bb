"""Small whole inputs of every kind, which every command accepts, and where each of them goes in."""

import json
import shutil
import sys
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

import cv2
import numpy as np
from attempts import attempt
from harms import unprotected
from scipy.io import savemat

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "unit"))

import foreign  # noqa: E402

EXPERIMENT = """\
pose_deg = [0, 0, 0, 0, 0]
duration = 1.0
load = [0, 0, -100]
release = 0.5
"""
MODEL = """\
<mujoco model="arm">
  <worldbody><body pos="0 0 1">
    <joint name="swing" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02" mass="1"/>
  </body></worldbody>
  <actuator><motor name="motor" joint="swing"/></actuator>
</mujoco>
"""
ROBOT = """\
name = "arm"
model = "model.xml"
time = "time"
window = 1.0
cutoff = 8.0
[[channel]]
name = "angle"
role = "drive"
joint = "swing"
field = "angle"
[[channel]]
name = "torque"
role = "compare"
actuator = "motor"
field = "torque"
"""
CSV_MAP = """\
[[entry]]
signal = "joint/position"
topic = "table"
field = "columns"
from = ["q1_rad", "q2_rad", "q3_rad", "q4_rad", "q5_rad"]
unit = "rad"
time = "time_s"
"""
ROS_MAP = """\
[[entry]]
signal = "joint/position"
topic = "/joint_states"
field = "position"
unit = "rad"
"""


@dataclass(frozen=True)
class Target:
    """A file that goes into a command.

    Attributes:
        file: its name.
        arguments: of the command; its outputs are called out*.
        passed: what the call says if it found nothing wrong with the file: later on something else is, so that
            no long work begins; "" if the call runs to its end.
    """

    command: str
    file: str
    arguments: tuple[str, ...]
    passed: str = ""


def _call(command: str, file: str, rest: str, passed: str = "") -> Target:
    return Target(command, file, (*command.split(), *rest.split()), passed)


HURDLE = "no class of cases is called nothing"
TARGETS = (
    _call("generate", "machine.toml", "machine.toml -o out.xml"),
    _call("simulate", "machine.toml", "machine.toml experiment.toml -o out.mcap"),
    _call("simulate", "experiment.toml", "machine.toml experiment.toml -o out.mcap"),
    _call("replay", "log.mcap", "log.mcap --machine machine.toml -o out.mcap"),
    _call("replay", "bare_log.mcap", "bare_log.mcap --machine machine.toml -o out.mcap"),
    _call("replay", "machine.toml", "log.mcap --machine machine.toml -o out.mcap"),
    _call("replay", "csv_map.toml", "log.csv --map csv_map.toml --machine machine.toml -o out.mcap"),
    _call("replay", "log.csv", "log.csv --map csv_map.toml --machine machine.toml -o out.mcap"),
    _call("replay", "log.csv.gz", "log.csv.gz --map csv_map.toml --machine machine.toml -o out.mcap"),
    _call("replay", "ros1.bag", "ros1.bag --map ros_map.toml --machine machine.toml -o out.mcap"),
    _call("replay", "ros2.db3", "ros2.db3 --map ros_map.toml --machine machine.toml -o out.mcap"),
    _call("validate", "machine.toml", "machine.toml --poses 1"),
    _call("view", "log.mcap", "log.mcap --machine nowhere.toml", "nowhere.toml"),
    _call("view", "machine.toml", "machine.toml --experiment nowhere.toml", "nowhere.toml"),
    _call("render", "log.mcap", "log.mcap --machine machine.toml -o out --camera nobody", "nobody"),
    _call("render", "machine.toml", "machine.toml --experiment experiment.toml -o out --camera nobody", "nobody"),
    _call("render", "experiment.toml", "machine.toml --experiment experiment.toml -o out --camera nobody", "nobody"),
    _call("track", "film/dataset.json", "film -o out.mcap --workers 1", "the chequerboard of"),
    _call("track", "film/images/a.png", "film -o out.mcap --workers 1", "the chequerboard of"),
    _call("calibrate", "machine.toml", "machine.toml nowhere.mcap -o out.toml", "nowhere.mcap"),
    _call("calibrate", "log.mcap", "machine.toml log.mcap torn.mcap -o out.toml", "torn.mcap"),
    _call("logs inspect", "log.mcap", "log.mcap"),
    _call("logs inspect", "bare_log.mcap", "bare_log.mcap --json"),
    _call("logs inspect", "log.csv", "log.csv"),
    _call("logs inspect", "log.csv.gz", "log.csv.gz --map"),
    _call("logs inspect", "ros1.bag", "ros1.bag"),
    _call("logs inspect", "ros2.db3", "ros2.db3"),
    _call("gap diagnose", "log.mcap", "log.mcap --machine nowhere.toml --json out.json", "nowhere.toml"),
    _call("gap diagnose", "machine.toml", "markers.mcap --machine machine.toml --json out.json", "joint/position"),
    _call("gap diagnose", "model.xml", "nowhere.csv --map robot.toml -o out.xml", "nowhere.csv"),
    _call("gap diagnose", "robot.toml", "nowhere.csv --map robot.toml -o out.xml", "nowhere.csv"),
    _call("gap diagnose", "robot.csv", "robot.csv nowhere.csv --map robot.toml -o out.xml", "nowhere.csv"),
    _call("gap diagnose", "robot.mat", "robot.mat nowhere.csv --map robot.toml -o out.xml", "nowhere.csv"),
    _call(
        "gap blind make",
        "machine.toml",
        "--cases 1 --seed-file seed --seal out.seal -o out --machine machine.toml --mix nothing=1",
        HURDLE,
    ),
    _call(
        "gap blind make",
        "seed",
        "--cases 1 --seed-file seed --seal out.seal -o out --machine machine.toml --mix nothing=1",
        HURDLE,
    ),
    _call("gap blind run", "campaign/machine.toml", "campaign -o out", "case ca5e"),
    _call("gap blind run", "campaign/seal.sha256", "campaign -o out", "case ca5e"),
    _call("gap blind run", "campaign/ca5e/withhold.json", "campaign -o out", "case ca5e"),
    _call("gap blind score", "seal.json", "campaign --seal seal.json --answers answers -o out.md"),
    _call("gap blind score", "campaign/seal.sha256", "campaign --seal seal.json --answers answers -o out.md"),
    _call("gap blind score", "answers/ca5e.json", "campaign --seal seal.json --answers answers -o out.html"),
)


def make_whole(folder: Path) -> None:
    """Fill a folder with whole inputs."""
    machine = (ROOT / "models" / "boom36.toml").read_text()
    (folder / "machine.toml").write_text(machine)
    (folder / "experiment.toml").write_text(EXPERIMENT)
    for name, text in (("csv_map", CSV_MAP), ("ros_map", ROS_MAP), ("robot", ROBOT)):
        (folder / f"{name}.toml").write_text(text)
    (folder / "model.xml").write_text(MODEL)
    done = attempt(["simulate", "machine.toml", "experiment.toml", "-o", "log.mcap"], folder)
    assert done.status == 0, done.told
    unprotected(folder / "log.mcap")
    (folder / "torn.mcap").write_bytes(b"")
    _write_markers(folder / "markers.mcap")
    _write_tables(folder)
    for made in (foreign.from_ros1(folder), foreign.from_database(folder)):
        if made.parent != folder:
            shutil.copy(made, folder / made.name)
            shutil.rmtree(made.parent)
    _write_film(folder / "film")
    _write_campaign(folder)


def _write_markers(path: Path) -> None:
    from boom_mj.logs import write_mcap
    from boom_mj.recording import Recording, named_signal

    signal = named_signal("markers", np.arange(50) / 25, np.random.default_rng(0).normal(size=(50, 36)))
    write_mcap(Recording("markers", "boom36", "", {"markers": signal}), path)


def _write_tables(folder: Path) -> None:
    foreign.from_csv(folder)
    short = (folder / "log.csv").read_text().splitlines()[:61]  # 1.2 s
    (folder / "log.csv").write_text("\n".join(short) + "\n")
    foreign.from_gzipped_csv(folder)
    time = np.arange(1500) / 500
    angle, torque = 0.3 * np.sin(2 * time), np.cos(2 * time)
    rows = [f"{t:.4f},{a:.6f},{b:.6f}" for t, a, b in zip(time, angle, torque)]
    (folder / "robot.csv").write_text("\n".join(["time,angle,torque", *rows]) + "\n")
    savemat(folder / "robot.mat", {"time": time, "angle": angle, "torque": torque}, do_compression=True)


def _write_film(folder: Path) -> None:
    """A data set of two cameras that see a grey nothing."""
    (folder / "images").mkdir(parents=True)
    cv2.imwrite(str(folder / "images" / "a.png"), np.full((48, 64), 128, np.uint8))
    cameras = [{"name": name, "width": 64, "height": 48} for name in ("left", "right")]
    pictures = [{"camera": camera["name"], "file": "images/a.png"} for camera in cameras]
    plates = [
        {"name": f"p{k}", "picture": "images/a.png", "size": [0.8, 0.4], "marker": k, "side": "right"} for k in (0, 1)
    ]
    content = {"name": "film", "machine": "boom36", "cameras": cameras, "plates": plates, "lateral": [0.5]}
    content |= {"chequerboard": {}, "calibration": pictures, "frames": pictures}
    (folder / "dataset.json").write_text(json.dumps(content))


def _write_campaign(folder: Path) -> None:
    """A sealed campaign of one case, whose logs cannot be diagnosed, and an answer to it."""
    case = folder / "campaign" / "ca5e"
    for part in ("train", "holdout"):
        (case / part).mkdir(parents=True)
        shutil.copy(folder / "markers.mcap", case / part / "hold.mcap")
    (case / "withhold.json").write_text('{"without": ["wind"]}')
    shutil.copy(folder / "machine.toml", folder / "campaign" / "machine.toml")
    truth = {"class": "single", "visibility": 3.0, "nuisances": []}
    truth["effects"] = [{"id": "tip_payload", "location": {}, "parameters": {"mass": 50.0}}]
    answer = {"verdict": "explained", "sentence": "so it is", "ties": [], "gap": {"closure": 0.99}, "wall_s": 1.0}
    value = {"value": 51.0, "low": 49.0, "high": 53.0}
    answer["effects"] = [{"id": "tip_payload", "location": {}, "parameters": {"mass": value}}]
    (folder / "answers").mkdir()
    (folder / "answers" / "ca5e.json").write_text(json.dumps(answer))
    (folder / "seed").write_bytes(bytes(range(32)))
    seal(folder, json.dumps({"salt": "", "seed_sha256": "0", "cases": {"ca5e": truth}}).encode())


def seal(folder: Path, content: bytes) -> None:
    """Write a seal and publish its hash."""
    (folder / "seal.json").write_bytes(content)
    (folder / "campaign" / "seal.sha256").write_text(sha256(content).hexdigest() + "\n")


def place(whole: Path, folder: Path) -> Path:
    """A fresh copy of the whole inputs, with what hostile files may want to reach beside it."""
    folder.mkdir(parents=True)
    for name in ("outside.xml", "outside.stl", "outside.png"):
        (folder / name).write_bytes(b"<mujoco/>")
    inner = folder / "here"
    shutil.copytree(whole, inner)
    (inner / "link.xml").symlink_to(folder / "outside.xml")
    (inner / "film" / "link").symlink_to("/etc")
    return inner
