"""Breaks logs of every format in 10 000 ways, counts how reading ends; prints a table of docs/results/robustness.md.

    python scripts/fuzz_logs.py [--files 10000] [--seed 1]

Every broken file is read by `read_log` and looked into by `inspect_log`, tables of any machine through a channel map
and cut into stretches; anything but a recording or a LogError that names the file is a crash, printed with what made
it, and the exit status is 1.
"""

import argparse
import contextlib
import json
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path

import h5py
import numpy as np
from scipy.io import savemat

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "tests" / "unit"), str(ROOT / "tests" / "faults")]

import foreign  # noqa: E402
from harms import HARMS, broken, unprotected  # noqa: E402

from boom_mj.errors import LogError  # noqa: E402
from boom_mj.logs import load_topic_map, read_log  # noqa: E402
from boom_mj.logs.columns import write_columns  # noqa: E402
from boom_mj.logs.inspection import inspect_log  # noqa: E402
from boom_mj.logs.proposal import propose_map  # noqa: E402
from boom_mj.logs.topic_map import TopicMap  # noqa: E402
from boom_mj.systems.mjcf.channel_map import parse_channel_map  # noqa: E402
from boom_mj.systems.mjcf.log_table import read_table  # noqa: E402
from boom_mj.systems.mjcf.segments import stretches_of  # noqa: E402

CHANNELS = parse_channel_map("""
name = "slide"
time = "t"
window = 2.0
channel = [
  {name = "way", role = "drive", joint = "slide", field = "q"},
  {name = "force", role = "compare", actuator = "motor", field = "f"},
]
""")


def outcome(path: Path, read: Callable[[Path], object]) -> str:
    """How reading a file ends: read, read with a warning, a clear error, or a crash."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            read(path)
            return "read with a warning" if told else "read"
        except LogError as error:
            return "clear error" if path.name in str(error) else "crash"


def as_boom(path: Path, topic_map: TopicMap) -> None:
    """Read and inspect."""
    try:
        read_log(path, topic_map)
    finally:
        with contextlib.suppress(LogError):
            propose_map(inspect_log(path))


def as_any_machine(path: Path) -> None:
    """Read and cut into stretches."""
    stretches_of(read_table(path, CHANNELS))


def tables(folder: Path) -> list[Path]:
    """A motion and a force in every format that a channel map takes."""
    time = np.arange(0, 10, 0.01)
    columns = {"t": time, "q": np.sin(time), "f": np.cos(time)}
    write_columns(folder / "table.csv", columns)
    (folder / "table.txt").write_text((folder / "table.csv").read_text().replace(",", " "))
    (folder / "table.json").write_text(json.dumps({name: list(values) for name, values in columns.items()}))
    np.savez(folder / "table.npz", **columns)
    savemat(folder / "table.mat", columns)
    with h5py.File(folder / "table.h5", "w") as file:
        file.update(columns)
    return sorted(folder.glob("table.*"))


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
                read = partial(as_boom, topic_map=load_topic_map(place / "map.toml"))
                wholes.append((log, log.read_bytes(), read))
        wholes += [(log, log.read_bytes(), as_any_machine) for log in tables(Path(folder))]
        for number in range(options.files):
            path, content, read = wholes[number % len(wholes)]
            harm = HARMS[(number // len(wholes)) % len(HARMS)]
            path.write_bytes(broken(content, harm, rng))
            try:
                result = outcome(path, read)
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
