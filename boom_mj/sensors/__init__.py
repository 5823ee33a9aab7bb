"""From a simulated motion to the recording that the machine's sensors would make of it."""

from boom_mj.engine import mujoco as _mujoco  # noqa: F401  # isort: skip

from boom_mj.recording import sample as sample
from boom_mj.sensors.driving import check_drivable as check_drivable
from boom_mj.sensors.driving import driving_angles as driving_angles
from boom_mj.sensors.measure import apply_sensor_effects as apply_sensor_effects
from boom_mj.sensors.measure import ideal_signals as ideal_signals
from boom_mj.sensors.measure import measure as measure
from boom_mj.sensors.measure import noise_levels as noise_levels
from boom_mj.sensors.measure import record as record
from boom_mj.sensors.measure import sample_rates as sample_rates
from boom_mj.sensors.measure import true_angles as true_angles
from boom_mj.sensors.scene import boom_lines as boom_lines
from boom_mj.sensors.scene import boom_scene as boom_scene
