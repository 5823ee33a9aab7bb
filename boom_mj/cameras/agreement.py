"""What MuJoCo itself says of where points lie in a picture, to hold our projection against."""

import mujoco
import numpy as np

from boom_mj.cameras.dressing import add_cameras
from boom_mj.cameras.view import View

Array = np.ndarray


def mujoco_projection(view: View, points: Array) -> Array:
    """Pixels (n, 2) of points (n, 3) in the world, by MuJoCo's camprojection sensors.

    They know neither principal points nor distortion, keep intrinsics in float32, and count from the picture's corner;
    here pixels are counted from the middle of the first one, as everywhere.
    """
    spec = mujoco.MjSpec()
    add_cameras(spec, {"camera": view})
    for k, point in enumerate(points):
        spec.worldbody.add_site(name=f"p{k}", pos=point)
        sensor = spec.add_sensor(name=f"p{k}", type=mujoco.mjtSensor.mjSENS_CAMPROJECTION)
        sensor.objtype, sensor.objname = mujoco.mjtObj.mjOBJ_SITE, f"p{k}"
        sensor.reftype, sensor.refname = mujoco.mjtObj.mjOBJ_CAMERA, "camera"
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data.sensordata.reshape(-1, 2) - 0.5
