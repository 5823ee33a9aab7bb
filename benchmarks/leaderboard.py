"""The table of several methods: python benchmarks/leaderboard.py SCORE.json...

Each file is what `gap blind score --method NAME --json` has written.
"""

import json
import sys
from pathlib import Path

from boom_mj.blind import leaderboard

if __name__ == "__main__":
    print(leaderboard([json.loads(Path(path).read_text())["leaderboard"] for path in sys.argv[1:]]))
