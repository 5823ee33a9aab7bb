"""The page of a calibration: parameters with intervals, and the paper's comparison with measurements."""

from boom_mj.report.calibration.page import write_calibration as write_calibration
