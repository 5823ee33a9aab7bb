"""What is wrong with the data, before any physics: `assess` judges one log, `check_recordings` a whole set.

A kind of finding is one file in `kinds/`; being there is being registered.
"""

from boom_mj.replay.quality.assessment import Quality as Quality
from boom_mj.replay.quality.assessment import assess as assess
from boom_mj.replay.quality.check import CheckedRecordings as CheckedRecordings
from boom_mj.replay.quality.check import check_recordings as check_recordings
from boom_mj.replay.quality.finding import Action as Action
from boom_mj.replay.quality.finding import DataFinding as DataFinding
from boom_mj.replay.quality.finding import Repair as Repair
