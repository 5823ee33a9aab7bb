"""Zero offsets of the joint angle sensors: every log has them, nobody calls them an effect."""

import numpy as np

from boom_mj.effects.effect import AngleEffect, Array, Parameter


class JointZeroOffset(AngleEffect):
    """Every joint sensor reads too much by a constant; the diagnosis estimates it along with everything."""

    id = "joint_zero_offset"
    parameters = {f"joint{k}": Parameter("rad", 0.0, -0.2, 0.2, 0.005) for k in range(1, 6)}
    confused_with = ("camera_pose", "joint_sensor_nonlinearity", "thermal_bending")
    told_by = "slew_tour"

    def error(self, angles: Array) -> Array:
        return np.broadcast_to([self.values[f"joint{k}"] for k in range(1, 6)], angles.shape)
