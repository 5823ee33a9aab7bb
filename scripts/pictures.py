"""Pictures of the README and the pages: MUJOCO_GL=egl .venv/bin/python scripts/pictures.py [boom | page]

`boom` needs a working EGL, `page`, of the page of a diagnosis, Chromium: `scripts/chromium`, or CHROMIUM=PATH.
"""

import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib
import mujoco
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from boom_mj import diagnose
from boom_mj.cameras.yard import in_yard
from boom_mj.machine import load_machine
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment

ROOT = Path(__file__).parents[1]


def main() -> None:
    wanted = sys.argv[1:] or ["boom", "page"]
    if "boom" in wanted:
        boom()
    if "page" in wanted:
        page()


def page() -> None:
    """The page of examples/unknown_payload on a desk, and on a phone by day and by night."""
    logs = [ROOT / "examples" / "unknown_payload" / f"release_{way}_vertical.mcap" for way in ("bow", "stretched")]
    with TemporaryDirectory() as folder:
        html = Path(folder) / "page.html"
        diagnose("boom36", logs[:1], logs[1:]).to_html(html)
        photograph(html, ROOT / "docs" / "diagnosis.png", 1280, 1500)
        phone = Path(folder) / "phone.html"
        phone.write_text('<body style="margin: 0"><iframe src="page.html" width="390" height="844" style="border: 0">')
        halves = [Path(folder) / f"{night}.png" for night in (False, True)]
        for night, half in enumerate(halves):
            photograph(phone, half, 500, 844, bool(night))  # windows are never narrower; the phone is its left
        both = np.hstack([plt.imread(half)[:, :390, :3] for half in halves])
        plt.imsave(ROOT / "docs" / "diagnosis_phone.png", both)


def photograph(page: Path, picture: Path, width: int, height: int, night: bool = False) -> None:
    scheme = f"--blink-settings=preferredColorScheme={int(not night)}"
    options = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", scheme)
    shot = (f"--window-size={width},{height}", f"--screenshot={picture}", page.as_uri())
    subprocess.run(
        [os.environ.get("CHROMIUM", str(ROOT / ".chromium" / "bin" / "chromium")), *options, *shot],
        check=True,
        stderr=subprocess.DEVNULL,
    )


def boom() -> None:
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
