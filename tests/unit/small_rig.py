"""A machine with two small cameras close by, and the command line in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "models" / "boom36.toml").read_text().split("\n# Three cameras")[0]
CAMERA = """
[[camera]]
name = "{name}"
position = {position}
look_at = [3.4, 0.0, 3.2]
resolution = [448, 288]
focal_length = [{focal}, {focal}]
distortion = [-0.06, 0.01, 0.0003, -0.0002, 0.0]
exposure = 0.004
readout = 0.01
"""
RIG = CAMERA.format(name="right", position=[5.5, -11.5, 2.5], focal=390.0)
RIG += CAMERA.format(name="left", position=[7.0, 10.5, 5.0], focal=390.0)
SHORT = ("--start", 8.0, "--stop", 8.1, "--jobs", 2)


def boom(*arguments: object, gl: str = "egl") -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "boom_mj", *map(str, arguments)]
    environment = {**os.environ, "MUJOCO_GL": gl}
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=300, env=environment)
