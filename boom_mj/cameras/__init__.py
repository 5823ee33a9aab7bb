"""Cameras that watch a boom: rig, pictures with labels, data sets, and the way back from pictures to markers."""

from boom_mj.engine import mujoco as _mujoco  # noqa: F401  # isort: skip
