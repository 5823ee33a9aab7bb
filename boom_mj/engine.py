"""MuJoCo, imported whatever MUJOCO_GL says, and kept from leaving files where one works.

MuJoCo refuses to be imported while MUJOCO_GL names no way to draw, or one whose library is missing, even where nothing
is drawn. Here it is imported without the variable then; who draws refuses (`cameras.studio`).

Its bindings give it a clock that it reads at the start and the end of every stage of every step, a twelfth of the time
of a boom of two hinges, for statistics that nobody here reads. It goes before the first step: a thread that steps may
be about to call it.
"""

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module

import numpy as np

NAME = "MUJOCO_GL"

try:
    import mujoco as mujoco
except Exception:  # of several types, by what is missing
    if NAME not in os.environ:
        raise
    _given = os.environ.pop(NAME)
    import mujoco as mujoco

    os.environ[NAME] = _given

with suppress(ImportError, OSError, ValueError):  # of a MuJoCo that is built otherwise: it keeps its clock
    _bindings = import_module("mujoco._functions").__file__
    ctypes.c_void_p.in_dll(ctypes.CDLL(_bindings), "mjcb_time").value = None


def mass_matrix(model: "mujoco.MjModel") -> np.ndarray:
    """M(q) of a model where it begins, armature included, (nv, nv)."""
    data, mass = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, mass)
    return mass


def keep_no_log() -> None:
    """Let MuJoCo's warnings be: it writes them into a file where one works; ours name the joint."""
    mujoco.set_mju_user_warning(lambda text: None)


@contextmanager
def no_log() -> Iterator[None]:
    """The same for a while; afterwards MuJoCo warns as it does by itself."""
    keep_no_log()
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(None)
