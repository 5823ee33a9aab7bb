"""Pictures: compute below, draw on top. Measured is near-black, nominal vermilion, corrected blue, everywhere."""

from boom_mj.report.calibration import write_calibration as write_calibration
from boom_mj.report.diagnosis import write_diagnosis as write_diagnosis
from boom_mj.report.overlay import draw_overlay as draw_overlay
