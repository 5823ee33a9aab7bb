"""The machine as a MuJoCo model with equivalent hinges; it never sees the reference model."""

from boom_mj.engine import mujoco as _mujoco  # noqa: F401  # isort: skip

from boom_mj.mjcf.beam import build_beam as build_beam
from boom_mj.mjcf.builder import BoomModel as BoomModel
from boom_mj.mjcf.builder import build as build
from boom_mj.mjcf.keyframes import POSES_DEG as POSES_DEG
from boom_mj.mjcf.scene import YELLOW as YELLOW
from boom_mj.mjcf.scene import box_corners as box_corners
from boom_mj.mjcf.urdf import urdf_text as urdf_text
