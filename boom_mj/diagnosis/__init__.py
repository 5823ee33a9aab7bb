"""The diagnosis of the sim-to-real gap: where it lies, which effect causes it, how far it shrinks."""

from boom_mj.diagnosis.answer import document as document
from boom_mj.diagnosis.answer import estimated_tolerances as estimated_tolerances
from boom_mj.diagnosis.answer import twins as twins
from boom_mj.diagnosis.answer import with_effects as with_effects
from boom_mj.diagnosis.answer import with_effects_text as with_effects_text
from boom_mj.diagnosis.diagnose import Diagnosis as Diagnosis
from boom_mj.diagnosis.diagnose import diagnose as diagnose
from boom_mj.systems.predictor import Campaign as Campaign
