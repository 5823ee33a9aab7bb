"""A motion as a film from the side: the simulated boom, its log's markers, deflections as large as one likes."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import mujoco
import numpy as np

from boom_mj.cameras.intrinsics import Intrinsics
from boom_mj.cameras.studio import choose_headless, open_renderer
from boom_mj.cameras.video import write_video
from boom_mj.cameras.yard import in_yard
from boom_mj.recording import Recording
from boom_mj.simulation import Trajectory
from boom_mj.spreading import results

Array = np.ndarray
RATE = 25.0  # pictures per second
BATCH = 25  # pictures that a process takes at a time
JOBS = 2
SIZE = (1280, 720)
MARGIN = 1.12  # of the picture's edges about what moves
TRUCK = ((-8.5, -2.0, 0.0), (3.5, 2.0, 0.0))  # what is in the picture besides the boom, m
MEASURED, SIMULATED, WHITE = (34, 34, 34), (0, 94, 213), (255, 255, 255)  # as OpenCV orders colours
DOT = 6.0  # px, radius
GLASS = 0.35  # opacity of a ground that the boom is bent into

Eye = tuple[Array, float, float, float]
"""Where the camera looks, (3,) m, its distance, m, azimuth and elevation, deg, as MuJoCo's free camera."""


@dataclass(frozen=True, eq=False)
class Reel:
    """What is filmed: states and measured points, picture by picture.

    Attributes:
        model: of the boom.
        time: (n,), s from the start of the motion.
        qpos: (n, nq), exaggerated.
        measured: marker positions, (n, m, 3) m, exaggerated about the simulated ones; NaN where hidden, m = 0 without.
        simulated: theirs.
        title: stands on every picture.
    """

    model: mujoco.MjModel
    time: Array
    qpos: Array
    measured: Array
    simulated: Array
    title: str
    eye: Eye


def reel_of(motion: Trajectory, log: Recording | None, title: str, exaggerate: float, speed: float) -> Reel:
    """Pictures of a motion at RATE.

    Args:
        log: its markers are shown beside the simulated ones.
        exaggerate: factor on what elastic hinges turn, and on measured - simulated.
        speed: in times real time.
    """
    plant, model = motion.plant, in_yard(motion.plant.boom)
    time = np.arange(0.0, motion.time[-1] + 1e-9, speed / RATE)
    steps = _steps(motion, time)
    qpos = motion.qpos[steps].copy()
    qpos[:, plant.elastic] *= exaggerate
    measured = simulated = np.zeros((len(time), 0, 3))
    shown = np.array([plant.markers(row) for row in qpos])
    if log is not None and "markers" in log:
        signal = log["markers"]
        stamps = signal.time - log["joint/position"].time[0]
        at = np.abs(stamps[:, None] - time).argmin(axis=0)  # (n,)
        seen = signal.values[at].reshape(len(time), -1, 3)
        then = np.array([plant.markers(motion.qpos[step]) for step in _steps(motion, stamps[at])])
        simulated, measured = shown, shown + exaggerate * (seen - then)
    if (shown[..., 2] < 0).any():
        model.mat_rgba[model.material("ground").id, 3] = GLASS
    if exaggerate != 1:
        title += f", deflection x {exaggerate:g}"
    return Reel(model, time, qpos, measured, simulated, title, _eye(model, qpos, float(np.mean(motion.joints[:, 0]))))


def _steps(motion: Trajectory, time: Array) -> Array:
    return np.clip(np.rint(time / motion.plant.model.opt.timestep).astype(int), 0, len(motion.time) - 1)


def record_film(reel: Reel, path: Path, report: Callable[[int, int], None] = lambda done, total: None) -> None:
    """Take all pictures, in processes that draw without a display, and write them as .mp4 or .webm.

    Raises:
        RenderError: no OpenGL, or a video that cannot be written.
    """
    choose_headless()
    write_video(path, _pictures(reel, report), RATE)


def _pictures(reel: Reel, report: Callable[[int, int], None]) -> Iterator[Array]:
    starts, waiting, following = range(0, len(reel.time), BATCH), {}, 0
    for start, batch in results(partial(_shoot, reel=reel), starts, JOBS, None):
        waiting[start] = batch
        while following in waiting:
            for data in waiting.pop(following):
                yield np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR))
            following += BATCH
            report(min(following, len(reel.time)), len(reel.time))


def _shoot(start: int, reel: Reel) -> list[Array]:
    """Pictures from one on, as JPEG."""
    model, data = reel.model, mujoco.MjData(reel.model)
    camera = mujoco.MjvCamera()
    camera.lookat, camera.distance, camera.azimuth, camera.elevation = reel.eye
    found = []
    with open_renderer(model, Intrinsics(*SIZE, (1.0, 1.0), (0.0, 0.0), (0.0,) * 5)) as renderer:
        for k in range(start, min(start + BATCH, len(reel.time))):
            data.qpos[:] = reel.qpos[k]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_camlight(model, data)
            renderer.update_scene(data, camera)
            picture = cv2.cvtColor(renderer.render(), cv2.COLOR_RGB2BGR)
            for points, colour, radius in ((reel.measured, MEASURED, DOT), (reel.simulated, SIMULATED, DOT / 2)):
                _dots(picture, _pixels(reel.eye, model.vis.global_.fovy, points[k]), colour, radius)
            _caption(picture, f"{reel.title}   {reel.time[k]:6.1f} s", bool(len(reel.measured[k])))
            found.append(cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 95])[1])
    return found


def _dots(picture: Array, pixels: Array, colour: tuple[int, int, int], radius: float) -> None:
    for x, y in np.round(pixels * 16).astype(int):
        for size, shade in ((radius + 1, WHITE), (radius, colour)):
            cv2.circle(picture, (x, y), round(size * 16), shade, -1, cv2.LINE_AA, 4)


def _caption(picture: Array, text: str, dots: bool) -> None:
    lines = [text, "markers: measured black, simulated red"] if dots else [text]
    for row, line in enumerate(lines):
        place, size = (24, 44 + 34 * row), 0.9 if row == 0 else 0.65
        for colour, width in ((WHITE, 4), (MEASURED, 1)):
            cv2.putText(picture, line, place, cv2.FONT_HERSHEY_SIMPLEX, size, colour, width, cv2.LINE_AA)


def _pixels(eye: Eye, fovy: float, points: Array) -> Array:
    """Where points (m, 3) that are not NaN stand in the picture, (k, 2)."""
    look, distance, azimuth, elevation = eye
    a, e = np.radians(azimuth), np.radians(elevation)
    right = np.array([np.sin(a), -np.cos(a), 0.0])
    forward = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    seen = points[np.isfinite(points).all(axis=1)] - (look - distance * forward)
    focal = SIZE[1] / 2 / np.tan(np.radians(fovy) / 2)
    across, down, depth = seen @ right, -(seen @ np.cross(right, forward)), seen @ forward
    return np.stack([across, down], axis=1) / depth[:, None] * focal + np.array(SIZE) / 2 - 0.5


def _eye(model: mujoco.MjModel, qpos: Array, slewing: float) -> Eye:
    """From the side of the boom's mean direction, far enough to see all that moves."""
    data, points = mujoco.MjData(model), [np.array(TRUCK)]
    for row in qpos[np.linspace(0, len(qpos) - 1, 60).astype(int)]:
        data.qpos[:] = row
        mujoco.mj_kinematics(model, data)
        points += [data.xpos[1:], data.site("tip").xpos[None]]
    cloud = np.concatenate(points)
    azimuth = 90.0 + np.degrees(slewing)
    right = np.array([np.sin(np.radians(azimuth)), -np.cos(np.radians(azimuth)), 0.0])
    forward = np.array([np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth)), 0.0])
    across, depth, height = cloud @ right, cloud @ forward, cloud[:, 2]
    middles = [(v.min() + v.max()) / 2 for v in (across, depth, height)]
    look = middles[0] * right + middles[1] * forward + [0, 0, middles[2]]
    tangent = np.tan(np.radians(model.vis.global_.fovy) / 2)
    wide = np.ptp(across) / 2 / (tangent * SIZE[0] / SIZE[1])
    distance = MARGIN * max(wide, np.ptp(height) / 2 / tangent) + np.ptp(depth) / 2
    return look, float(distance), float(azimuth), -6.0
