"""What is filmed, ready to travel to a worker: the dressed model, its motion, and the cameras."""

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from boom_mj.cameras.dressing import dressed
from boom_mj.cameras.lens import Lens
from boom_mj.cameras.rig import RigCamera
from boom_mj.cameras.targets import Plate
from boom_mj.errors import InputError
from boom_mj.machine import Machine
from boom_mj.simulation import Trajectory

Array = np.ndarray
LOOKS = 60  # instants at which a camera is asked whether it sees anything


@dataclass(frozen=True, eq=False)
class Film:
    """A motion in front of cameras.

    Attributes:
        model: of the dressed boom, with a pinhole camera for every lens.
        time: (n,), s.
        qpos: (n, nq).
        joints: addresses of joint1..joint5 in qpos, (5,).
        ritz: elastic Ritz coordinates = ritz @ qpos, (12, nq).
    """

    machine: Machine
    model: mujoco.MjModel
    plates: tuple[Plate, ...]
    rig: tuple[RigCamera, ...]
    time: Array
    qpos: Array
    joints: Array
    ritz: Array

    def at(self, time: float) -> Array:
        """qpos at a time, linear between steps and held beyond the ends, (nq,)."""
        right = int(np.clip(np.searchsorted(self.time, time), 1, len(self.time) - 1))
        before, after = self.time[right - 1 : right + 1]
        share = np.clip((time - before) / (after - before), 0.0, 1.0)
        return np.asarray((1 - share) * self.qpos[right - 1] + share * self.qpos[right])


def film_of(trajectory: Trajectory, rig: tuple[RigCamera, ...]) -> Film:
    """Dress a simulated boom for cameras.

    Raises:
        InputError: a camera that never has a marker in its picture.
    """
    plant = trajectory.plant
    sources = {c.name: replace(c.view, intrinsics=Lens(c.view.intrinsics).source) for c in rig}
    model, plates = dressed(plant.boom, sources)
    film = Film(plant.machine, model, plates, rig, trajectory.time, trajectory.qpos, plant.joints, plant.ritz)
    _refuse_blind_cameras(film)
    return film


def _refuse_blind_cameras(film: Film) -> None:
    data, steps = mujoco.MjData(film.model), np.linspace(0, len(film.time) - 1, LOOKS).astype(int)
    sites = [k for k in range(film.model.nsite) if film.model.site(k).name.startswith("marker")]
    places = []
    for step in steps:
        data.qpos[:] = film.qpos[step]
        mujoco.mj_kinematics(film.model, data)
        places.append(data.site_xpos[sites].copy())
    for camera in film.rig:
        pixels = camera.view.project(np.concatenate(places))
        if not camera.view.intrinsics.contains(pixels).any():
            behind = np.isnan(pixels).all()
            why = "they lie behind it" if behind else "they lie outside its picture"
            raise InputError(
                f"{camera.name} at {camera.file.position}, looking at {camera.file.look_at}, never sees a marker of "
                f"{film.machine.name}: {why}; change its place, its direction or its focal_length, or leave it out"
            )
