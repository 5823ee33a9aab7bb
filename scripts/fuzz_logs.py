"""Breaks logs of every format in 10 000 ways, counts how reading ends; prints a table of docs/results/robustness.md.

    python scripts/fuzz_logs.py [--files 10000] [--seed 1]

Every broken file is read by `read_log` and looked into by `inspect_log`; anything but a recording or a LogError that
names the file is a crash, printed with what made it, and the exit status is 1.
"""

import argparse
import contextlib
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "tests" / "unit"), str(ROOT / "tests" / "faults")]

import foreign  # noqa: E402
from harms import HARMS, broken, unprotected  # noqa: E402

from boom_mj.errors import LogError  # noqa: E402
from boom_mj.logs import load_topic_map, read_log  # noqa: E402
from boom_mj.logs.inspection import inspect_log  # noqa: E402
from boom_mj.logs.proposal import propose_map  # noqa: E402


def outcome(path: Path, topic_map: object) -> str:
    """How reading a file ends: read, read with a warning, a clear error, or a crash."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            read_log(path, topic_map)
            result = "read with a warning" if told else "read"
        except LogError as error:
            result = "clear error" if path.name in str(error) else "crash"
        with contextlib.suppress(LogError):
            propose_map(inspect_log(path))
    return result


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--files", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    counts: dict[str, Counter] = {}
    with tempfile.TemporaryDirectory() as folder:
        wholes = []
        for i, writer in enumerate(w for w in foreign.WRITERS if w is not foreign.from_ros2_bag):
            (place := Path(folder) / str(i)).mkdir()
            path = writer(place)
            (place / "map.toml").write_text(propose_map(inspect_log(path)).replace('?"', '"'))
            for log in (path, unprotected(path)) if path.suffix == ".mcap" else (path,):
                wholes.append((log, log.read_bytes(), load_topic_map(place / "map.toml")))
        for number in range(options.files):
            path, content, topic_map = wholes[number % len(wholes)]
            harm = HARMS[(number // len(wholes)) % len(HARMS)]
            path.write_bytes(broken(content, harm, rng))
            try:
                result = outcome(path, topic_map)
            except Exception:
                result = "crash"
                print(f"file {number}, {path.name}, {harm}:\n{traceback.format_exc()}", file=sys.stderr)
            counts.setdefault(path.name, Counter())[result] += 1
    columns = ("clear error", "read with a warning", "read", "crash")
    print("| log | files | " + " | ".join(columns) + " |\n|" + "---|" * (len(columns) + 2))
    for name, count in [*counts.items(), ("all", sum(counts.values(), Counter()))]:
        print(f"| {name} | {count.total()} | " + " | ".join(str(count[column]) for column in columns) + " |")
    return 1 if any(count["crash"] for count in counts.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
