"""The pictures of the README. Run: MUJOCO_GL=egl .venv/bin/python scripts/pictures.py  (needs a working EGL)"""

from pathlib import Path

import matplotlib
import mujoco
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from boom_mj.cameras.yard import in_yard
from boom_mj.machine import load_machine
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment

ROOT = Path(__file__).parents[1]


def main() -> None:
    plant = make_plant(load_machine(ROOT / "models" / "boom36.toml"), 4)
    frames, model = [], in_yard(plant.boom)
    model.vis.global_.offwidth, model.vis.global_.offheight = 1920, 1080
    with mujoco.Renderer(model, 1080, 1920) as renderer:
        data = mujoco.MjData(model)
        camera = mujoco.MjvCamera()
        camera.lookat, camera.distance, camera.azimuth, camera.elevation = (13, 0, 5.5), 33, 112, -6
        for name, times in (("release_stretched_vertical", (7.9, 9.0)), ("fold_in", (0.0, 22.0))):
            found = run_experiment(plant, CATALOGUE[name])
            for when in times:
                data.qpos[:] = found.qpos[np.searchsorted(found.time, when)]
                mujoco.mj_forward(model, data)
                renderer.update_scene(data, camera)
                frames.append(renderer.render())
    whole = np.vstack([np.hstack(frames[:2]), np.hstack(frames[2:])]).astype(float)
    small = sum(whole[i::4, j::4] for i in range(4) for j in range(4)) / 16  # edges of the renderer are hard
    plt.imsave(ROOT / "docs" / "boom.png", small.round().astype(np.uint8))


if __name__ == "__main__":
    main()
