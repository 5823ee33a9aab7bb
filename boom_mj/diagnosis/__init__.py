"""The diagnosis of the sim-to-real gap: where it lies, which effect causes it, how far it shrinks."""

from boom_mj.diagnosis.answer import document as document
from boom_mj.diagnosis.conclusion import Diagnosis as Diagnosis
from boom_mj.diagnosis.diagnose import diagnose as diagnose
from boom_mj.diagnosis.predictions import built_with as built_with
from boom_mj.diagnosis.predictions import causes as causes
from boom_mj.diagnosis.predictions import estimated_nuisances as estimated_nuisances
from boom_mj.diagnosis.predictions import explanation as explanation
from boom_mj.diagnosis.predictions import nominal_predictor as nominal_predictor
from boom_mj.diagnosis.predictions import simulated_recording as simulated_recording
from boom_mj.diagnosis.predictions import steps as steps
from boom_mj.diagnosis.reasons import reasons as reasons
from boom_mj.diagnosis.steps import channel_steps as channel_steps
