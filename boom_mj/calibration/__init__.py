"""Calibration: from recordings to a machine file with intervals, and what the recordings cannot tell."""

from boom_mj.calibration.answer import calibrated_text as calibrated_text
from boom_mj.calibration.answer import document as document
from boom_mj.calibration.calibrate import Calibration as Calibration
from boom_mj.calibration.calibrate import calibrate as calibrate
from boom_mj.calibration.parameters import KINDS as KINDS
from boom_mj.calibration.parameters import USUAL as USUAL
from boom_mj.calibration.plan import Plan as Plan
from boom_mj.calibration.plan import plan_next as plan_next
from boom_mj.calibration.validation import Comparison as Comparison
from boom_mj.calibration.validation import Validation as Validation
from boom_mj.calibration.validation import validate as validate
from boom_mj.calibration.validation import validation_document as validation_document
