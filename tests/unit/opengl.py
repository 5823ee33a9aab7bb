"""Whether pictures can be made here."""

import os
import subprocess
import sys
from functools import cache


@cache
def can_render() -> bool:
    code = "import mujoco; mujoco.Renderer(mujoco.MjModel.from_xml_string('<mujoco/>'), 16, 16).render()"
    done = subprocess.run([sys.executable, "-c", code], env={**os.environ, "MUJOCO_GL": "egl"}, capture_output=True)
    return done.returncode == 0
