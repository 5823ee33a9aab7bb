"""Zero offsets of the joint angle sensors: every log has them, nobody calls them an effect."""

import numpy as np

from boom_mj.effects import AngleEffect, Array, Parameter


class JointZeroOffset(AngleEffect):
    """The sensor reads too much by a constant; the diagnosis estimates it along with everything."""

    id = "joint_zero_offset"
    table = {"offset": Parameter("rad", 0.0, -0.2, 0.2, 0.005)}
    confused_with = ("camera_pose", "joint_sensor_nonlinearity", "thermal_bending", "base_tilt", "joint_play", "wind")
    separating_experiment = "slew_tour"
    competes = False

    def error(self, angle: Array) -> Array:
        return np.full_like(angle, self.values["offset"])
