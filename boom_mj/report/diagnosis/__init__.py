"""The page of a diagnosis: verdict in words, where the gap lies, what explains it, what is left."""

from boom_mj.report.diagnosis.change import draw_gaps as draw_gaps
from boom_mj.report.diagnosis.page import write_diagnosis as write_diagnosis
