"""Mutants of the rooms that decide, each run against the fast tests that reach it: a table of docs/results/mutants.md.

    python scripts/mutants.py [--each 20] [--keep FILE.jsonl] [--again] [--commit ID]

A mutant is a room's file with one change: a comparison, a sign, an operator, a constant, `and` and `or`, a condition, a
value that is returned. `--each` are drawn from every room, by SHA-256 of the commit and the name of this script. First
every file of TESTS runs once, watched: which of its tests reach a line that is to be changed. Then every mutant meets
those, the quick ones first; one that fails, or lasts longer than LONGEST, kills it. A mutant that no test reaches
survives. Lines of FILE.jsonl are results, and a second call goes on; with `--again` survivors are tried anew, against
tests that were written since. Slow tests (`tests/recover`) are left out: what they would kill counts as surviving.
"""

import argparse
import ast
import hashlib
import importlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from mutations import Point, mutated, points

ROOT = Path(__file__).parents[1]
ROOMS = ("estimation", "diagnosis", "effects", "replay/quality")
TESTS = (
    "unit/test_quality", "unit/test_decision", "unit/test_choice_by_error", "unit/test_shares", "unit/test_watch",
    "unit/test_candidate", "unit/test_scoring", "unit/test_linearisation", "unit/test_play_and_rest",
    "unit/test_angle_errors", "laws/test_mjcf", "unit/test_latent_input", "unit/test_screening", "unit/test_passes",
    "unit/test_laws", "unit/test_any_machine_answers", "unit/test_diagnosis_page", "unit/test_diagnosis_answer",
    "unit/test_law_search", "unit/test_known_of_logs", "unit/test_diagnosis_of_algebra",
    "unit/test_effect_files", "unit/test_blind_answers", "unit/test_deciding", "golden/test_numbers",
    "unit/test_logs_check", "unit/test_channel_checks", "laws/test_systems", "agree/test_effects_at_rest",
    "laws/test_estimation", "laws/test_effects", "laws/test_data_checks", "unit/test_fits_of_algebra",
    "unit/test_sure", "unit/test_localisation", "unit/test_least_squares", "unit/test_dataset", "unit/test_as_built",
    "unit/test_single_effects", "unit/test_answers_of_algebra", "unit/test_outlying", "unit/test_blocks",
)  # fmt: skip
LONGEST = 180.0  # s of all tests of a mutant, which take half of it at most without it
LONGEST_FILE = 300.0  # s of a file of tests that is watched
HEAVY = ("numpy", "scipy.optimize", "scipy.signal", "scipy.stats", "mujoco", "typer", "rich.console", "pytest", "mcap")


def drawn(commit: str, each: int) -> list[Point]:
    """As many from every room."""
    found = []
    for room in ROOMS:
        seed = hashlib.sha256(f"{commit} mutants.py {room}".encode()).hexdigest()
        every = [point for path in sorted((ROOT / "boom_mj" / room).rglob("*.py")) for point in points(path, ROOT)]
        found += random.Random(seed).sample(every, each)
    return found


class Watch:
    """A plugin of pytest: which tests reach which lines."""

    def __init__(self, wanted: dict[str, set[int]]) -> None:
        self.wanted, self.now, self.reached = wanted, "", {}
        self.seconds: dict[str, float] = {}
        self.failed: set[str] = set()  # without any mutant: they tell nothing
        self._codes: dict[CodeType, set[int]] = {}
        self._met: set[tuple[str, int]] = set()

    def pytest_runtest_protocol(self, item: Any, nextitem: Any) -> None:
        self._close()
        self.now, self.began = item.nodeid, time.monotonic()

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed:
            self.failed.add(report.nodeid)

    def pytest_sessionfinish(self) -> None:
        self._close()

    def _close(self) -> None:
        if self.now:
            self.reached[self.now] = [] if self.now in self.failed else sorted(self._met)
            self.seconds[self.now] = time.monotonic() - self.began
        self._met = set()

    def trace(self, frame: FrameType, event: str, argument: Any) -> Any:
        code = frame.f_code
        lines = self._codes.get(code)
        if lines is None:
            name = code.co_filename
            at = name.find("boom_mj/")
            here = {line for *_, line in code.co_lines() if line}
            lines = self._codes[code] = here & self.wanted.get(name[at:], set()) if at >= 0 else set()
        return self._local if lines else None

    def _local(self, frame: FrameType, event: str, argument: Any) -> Any:
        if event == "line" and frame.f_lineno in self._codes[frame.f_code]:
            name = frame.f_code.co_filename
            self._met.add((name[name.find("boom_mj/") :], frame.f_lineno))
        return self._local


def in_a_fork(folder: Path, seconds: float, work: Callable[[], int]) -> int | None:
    """The status of work in a process of its own, whose boom_mj is that of a folder; None if it takes too long."""
    child = os.fork()
    if child == 0:
        status = 1
        try:
            os.setsid()
            os.chdir(folder)
            sys.path.insert(0, str(folder))
            os.environ["PYTHONPATH"] = str(folder)
            quiet = os.open(os.devnull, os.O_WRONLY)
            os.dup2(quiet, 1), os.dup2(quiet, 2)
            status = work()
        finally:
            os._exit(status)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.02)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None


def tests_of(names: Sequence[str], *plugins: Any) -> int:
    import pytest

    stop = () if plugins else ("-x",)
    return int(pytest.main([*names, *stop, "-q", "-p", "no:cacheprovider", "-p", "no:xdist"], list(plugins)))


def watched(folder: Path, file: str, wanted: dict[str, set[int]]) -> dict[str, Any]:
    """What tests of a file reach, and how long they take."""
    out = folder / "reached.json"
    out.unlink(missing_ok=True)

    def work() -> int:
        watch = Watch(wanted)
        threading.settrace(watch.trace)
        sys.settrace(watch.trace)
        status = tests_of([file], watch)
        sys.settrace(None)
        out.write_text(json.dumps({"reached": watch.reached, "seconds": watch.seconds}))
        return status

    status = in_a_fork(folder, LONGEST_FILE, work)
    if status != 0:
        print(f"{file} ends with {status} without any mutant", file=sys.stderr)
    return json.loads(out.read_text()) if out.exists() else {"reached": {}, "seconds": {}}


def copied(folder: Path) -> None:
    """What tests need: copies of what is changed, links to the rest."""
    for name in ("boom_mj", "tests"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    for path in ROOT.iterdir():
        if path.name not in ("boom_mj", "tests", ".git") and not (folder / path.name).exists():
            (folder / path.name).symlink_to(path)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--each", type=int, default=20, help="mutants of every room")
    parser.add_argument("--keep", type=Path, default=Path("mutants.jsonl"))
    parser.add_argument("--again", action="store_true", help="try survivors anew")
    parser.add_argument("--commit", default="", help="whose id the sample follows from; HEAD if left out")
    given = parser.parse_args()
    commit = given.commit or subprocess.check_output(["git", "rev-parse", "HEAD"], cwd=ROOT, text=True).strip()
    rows = [json.loads(line) for line in given.keep.read_text().splitlines()] if given.keep.exists() else []
    known = {(row["file"], row["number"]): row["end"] for row in rows}
    sample = drawn(commit, given.each)
    waiting = [p for p in sample if (end := known.get((p.file, p.number))) is None or (given.again and end != "killed")]
    os.environ |= {"OMP_NUM_THREADS": "1", "MUJOCO_GL": "disabled", "PYTHONDONTWRITEBYTECODE": "1"}
    sys.dont_write_bytecode = True
    for name in HEAVY:
        importlib.import_module(name)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        copied(folder)
        reached = dict(reach(folder, sample, given.keep.with_suffix(".reached.json"))) if waiting else {}
        for point in waiting:
            rows.append({"room": room_of(point), **vars(point), **judged(folder, point, reached.get(key(point), []))})
            with given.keep.open("a") as stream:
                stream.write(json.dumps(rows[-1]) + "\n")
            print(f"{point.file}:{point.line} {point.what}: {rows[-1]['end']} {rows[-1]['by']}", file=sys.stderr)
    wanted = {(point.file, point.number) for point in sample}
    print(table([row for row in rows if (row["file"], row["number"]) in wanted]))
    return 0


def key(point: Point) -> str:
    return f"{point.file}:{point.line}"


def room_of(point: Point) -> str:
    return next(room for room in ROOMS if point.file.startswith(f"boom_mj/{room}/"))


def reach(folder: Path, sample: Sequence[Point], kept: Path) -> Iterator[tuple[str, list[tuple[float, str]]]]:
    """Line -> the tests that reach it, quick ones first; a file that was watched and has not changed is not again."""
    known = json.loads(kept.read_text()) if kept.exists() else {}
    wanted: dict[str, set[int]] = {}
    for point in sample:
        wanted.setdefault(point.file, set()).add(point.line)
    lines = sorted({key(point) for point in sample})
    tests: dict[str, list[tuple[float, str]]] = {}
    for name in TESTS:
        path = ROOT / "tests" / f"{name}.py"
        if not path.exists():
            continue
        print_of = hashlib.sha256(path.read_bytes() + json.dumps(lines).encode()).hexdigest()
        if known.get(name, {}).get("of") != print_of:
            known[name] = {"of": print_of, **watched(folder, f"tests/{name}.py", wanted)}
            kept.write_text(json.dumps(known))
            print(f"watched {name}: {sum(known[name]['seconds'].values()):.0f} s", file=sys.stderr)
        for test, met in known[name]["reached"].items():
            for file, line in met:
                tests.setdefault(f"{file}:{line}", []).append((known[name]["seconds"][test], test))
    imported = [(0.0, "tests/unit/test_decision.py")]  # what runs when a module is imported, all tests reach
    if "golden/test_numbers" in known:
        imported.append((0.1, "tests/golden/test_numbers.py"))
    for point in sample:
        path = ROOT / point.file
        inside = any(
            isinstance(node, ast.FunctionDef) and node.body[0].lineno <= point.line <= (node.end_lineno or 0)
            for node in ast.walk(ast.parse(path.read_text()))
        )
        if not inside:
            everywhere = sorted(
                {(s, t) for k, found in tests.items() if k.startswith(f"{point.file}:") for s, t in found}
            )
            files = [(sum(known[n]["seconds"].values()), f"tests/{n}.py") for n in TESTS if n in known]
            tests[key(point)] = everywhere + imported if everywhere else sorted(imported + files)
        yield key(point), sorted(set(tests.get(key(point), [])))


def judged(folder: Path, point: Point, tests: Sequence[tuple[float, str]]) -> dict[str, Any]:
    """Whether the tests that reach a mutant kill it."""
    if not tests:
        return {"end": "not reached", "by": "", "tests": 0}
    path, original = folder / point.file, (folder / point.file).read_text()
    path.write_text(mutated(ROOT / point.file, point.number))
    try:
        names, spent = [], 0.0
        for seconds, name in tests:
            if spent + seconds <= LONGEST / 2 or not names:
                names.append(name)
                spent += seconds
        status = in_a_fork(folder, LONGEST, lambda: tests_of(names))
    finally:
        path.write_text(original)
    end = "survived" if status == 0 else "killed"
    return {"end": end, "by": "time" if status is None else f"status {status}" if status else "", "tests": len(names)}


def table(rows: Sequence[dict[str, Any]]) -> str:
    """By room, first and last results, as Markdown; then what survived."""
    first: dict[tuple[str, int], dict] = {}
    last: dict[tuple[str, int], dict] = {}
    for row in rows:
        first.setdefault((row["file"], row["number"]), row)
        last[row["file"], row["number"]] = row
    lines = ["| room | mutants | killed before | killed after | survived | not reached |", "|---|---|---|---|---|---|"]
    for room in (*ROOMS, "all"):
        before, after = ([r for r in found.values() if room in (r["room"], "all")] for found in (first, last))
        count = {end: sum(r["end"] == end for r in after) for end in ("killed", "survived", "not reached")}
        killed = sum(r["end"] == "killed" for r in before)
        share = [f"{k} ({100 * k / max(1, len(after)):.0f} %)" for k in (killed, count["killed"])]
        lines.append(f"| {room} | {len(after)} | {' | '.join(share)} | {count['survived']} | {count['not reached']} |")
    lines.append("")
    left = [row for row in last.values() if row["end"] != "killed"]
    lines += [f"- {row['file']}:{row['line']}: {row['what']} ({row['end']})" for row in left]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
