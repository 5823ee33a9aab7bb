"""What `--json` writes, by command: keys that stay; required ones are in every document, which may hold more."""

from boom_mj.cli.documents.blind import GapBlindMake, GapBlindRun, GapBlindScore
from boom_mj.cli.documents.calibration import Calibrate, CalibratePlan
from boom_mj.cli.documents.design import GapDesign
from boom_mj.cli.documents.discover import GapDiscover
from boom_mj.cli.documents.gap import GapDiagnose, GapWatch
from boom_mj.cli.documents.library import GapCriteria, GapEffects
from boom_mj.cli.documents.logs import LogsCheck, LogsInspect
from boom_mj.cli.documents.models import Generate, Render, Replay, Simulate, Sweep, Track, Validate, View
from boom_mj.cli.documents.part import Part as Part

DOCUMENTS: dict[str, tuple[type[Part], ...]] = {
    "generate": (Generate,),
    "simulate": (Simulate, Sweep),
    "replay": (Replay,),
    "validate": (Validate,),
    "view": (View,),
    "render": (Render,),
    "track": (Track,),
    "calibrate": (Calibrate, CalibratePlan),
    "logs inspect": (LogsInspect,),
    "logs check": (LogsCheck,),
    "gap diagnose": (GapDiagnose,),
    "gap discover": (GapDiscover,),
    "gap design": (GapDesign,),
    "gap effects": (GapEffects,),
    "gap criteria": (GapCriteria,),
    "gap watch": (GapWatch,),
    "gap blind make": (GapBlindMake,),
    "gap blind run": (GapBlindRun,),
    "gap blind score": (GapBlindScore,),
}
"""Documents by command; of several, which one depends on the options."""
