"""Long commands stopped at random moments, and called again; prints a table of docs/results/robustness.md.

    python scripts/kills.py [--tries 100] [--keep FILE.jsonl] [--only JOB ...] [--commit ID]

Five jobs with real work - a diagnosis, a calibration, a watch, a rendering, blind cases - meet five faults at a random
moment of the time that the whole call takes: kill -9, Ctrl-C (to all of its processes), a full disk, a disk that can
only be read, no more memory than it has (`ulimit -v`). Every call writes to a disk of its own, a tmpfs, so it takes
root, or `unshare -Urm`. Then files are looked at - each is whole, or not there; what a killed process leaves has a
hidden name - and the same call is made again, until it says whether it goes on or begins afresh (`render`: to its end,
whose files must be those of an undisturbed call). The moments follow from SHA-256 of the commit and the name of this
script; what is done is kept line by line in FILE.jsonl, and a second call goes on. About half an hour.
"""

import argparse
import hashlib
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

ROOT = Path(__file__).parents[1]
FAULTS = ("kill -9", "Ctrl-C", "full disk", "read-only disk", "memory limit")
ENDS = ("done", "error", "killed", "crash")
COLUMNS = ("tried", *ENDS, "half-written", "left behind", "goes on", "afresh", "says nothing")
DISK, MORE = 64, 2**20  # MiB of a call's own disk; bytes that memory may still grow
LONGEST, PATIENCE = 240.0, 90.0  # s of a call; until a second one says what it does


@dataclass(frozen=True)
class Job:
    """A call that is stopped.

    Attributes:
        command: its words; {case} is a case of three logs of 30 s, {disk} where it writes.
        same: whether its files are the same to the byte whenever it ends.
    """

    name: str
    command: str
    same: bool = False


JOBS = (
    Job(
        "gap diagnose",
        "gap diagnose {case}/train/release_bow_vertical.mcap {case}/train/slew_t.mcap --holdout "
        "{case}/holdout/release_bow_horizontal.mcap --time 8 --json {disk}/out.json -o {disk}/out.toml "
        "--html {disk}/out.html --predictions {disk}/out",
    ),
    Job(
        "calibrate",
        "calibrate boom36 {case}/train/release_bow_vertical.mcap --free youngs_modulus_y --json {disk}/out.json "
        "-o {disk}/out.toml",
    ),
    Job(
        "gap watch",
        "gap watch {case}/train/slew_t.mcap --healthy {case}/train/release_bow_vertical.mcap --time 8 "
        "--json {disk}/out.json",
    ),
    Job(
        "render",
        "render boom36 --experiment release_bow_vertical --stop 1 --every 5 --scale 0.05 -o {disk}/out --jobs 2",
        same=True,
    ),
    Job("gap blind run", "gap blind run {set} -o {disk}/out --jobs 1"),
)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tries", type=int, default=100)
    parser.add_argument("--keep", type=Path, default=Path("kills.jsonl"))
    parser.add_argument("--only", nargs="*", default=(), help="jobs")
    parser.add_argument("--commit", default="", help="whose id the moments follow from; HEAD if left out")
    given = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # calls of a job in the background would ignore it
    commit = given.commit or subprocess.check_output(["git", "rev-parse", "HEAD"], cwd=ROOT, text=True).strip()
    rows = [json.loads(line) for line in given.keep.read_text().splitlines()] if given.keep.exists() else []
    done = {row["number"] for row in rows}
    folder = given.keep.resolve().with_suffix(".inputs")
    make_inputs(folder)
    for number in range(given.tries):
        job, fault = JOBS[number % len(JOBS)], FAULTS[number // len(JOBS) % len(FAULTS)]
        if number in done or (given.only and job.name not in given.only):
            continue
        draw = hashlib.sha256(f"{commit} kills.py {number}".encode()).digest()
        share = int.from_bytes(draw[:8], "big") / 2**64
        row = {"number": number, "job": job.name, "fault": fault, "share": share, "commit": commit}
        rows.append(row | tried(job, fault, share * whole_call(job, folder), folder))
        with given.keep.open("a") as stream:
            stream.write(json.dumps(rows[-1]) + "\n")
        print(f"{number}: {', '.join(str(v) for k, v in rows[-1].items() if k != 'commit')}", file=sys.stderr)
    print(table(rows))
    return 1 if any(row["end"] == "crash" or row["half-written"] or row["left behind"] for row in rows) else 0


def make_inputs(folder: Path) -> None:
    """A sealed set of two short cases, whose library has but two effects left, as a diagnosis would take minutes."""
    if (folder / "set" / "seal.sha256").exists():
        return
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "seed").write_bytes(bytes(range(32)))
    words = f"gap blind make --cases 2 --seed-file {folder}/seed --seal {folder}/seal -o {folder}/set --short".split()
    subprocess.run([sys.executable, "-m", "boom_mj", *words, "--mix", "single=1"], check=True, env=environment())
    from boom_mj.effects import effect_library

    withheld = [name for name in effect_library() if name not in ("tip_payload", "structural_damping")]
    for case in (folder / "set").glob("*/withhold.json"):
        case.write_text(json.dumps({"without": withheld}))


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}


def words_of(job: Job, folder: Path, disk: Path) -> list[str]:
    case = min(path.parent for path in (folder / "set").glob("*/withhold.json"))
    places = {"case": case, "set": folder / "set", "disk": disk}
    return [sys.executable, "-m", "boom_mj", *job.command.format(**places).split()]


def whole_call(job: Job, folder: Path) -> float:
    """Seconds that an undisturbed call takes; what it writes is kept beside the inputs."""
    kept = folder / job.name.replace(" ", "_")
    if not (kept / "wall").exists():
        kept.mkdir(exist_ok=True)
        with own_disk(folder) as disk:
            began = time.monotonic()
            subprocess.run(words_of(job, folder, disk), check=True, env=environment(), capture_output=True)
            shutil.copytree(disk, kept / "whole", dirs_exist_ok=True)
            (kept / "wall").write_text(f"{time.monotonic() - began:.2f}")
    return float((kept / "wall").read_text())


@contextmanager
def own_disk(folder: Path) -> Iterator[Path]:
    """A small disk, mounted for one try."""
    disk = folder / "disk"
    disk.mkdir(exist_ok=True)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={DISK}m", "tmpfs", disk], check=True)
    try:
        yield disk
    finally:
        subprocess.run(["umount", "-l", disk], check=True)


class Call:
    """A call in a session of its own, what it says in a file."""

    def __init__(self, words: Sequence[str], said: Path) -> None:
        self.said = said
        with said.open("wb") as stream:
            self.process = subprocess.Popen(
                words, stdout=stream, stderr=stream, stdin=subprocess.DEVNULL, env=environment(), start_new_session=True
            )

    def wait(self, seconds: float) -> int | None:
        with suppress(subprocess.TimeoutExpired):
            return self.process.wait(max(seconds, 0.0))
        return None

    def told(self) -> str:
        return self.said.read_text(errors="replace")

    def processes(self) -> list[int]:
        """Of its session that still live."""
        found = []
        for entry in Path("/proc").iterdir():
            if entry.name.isdigit():
                with suppress(OSError):
                    fields = (entry / "stat").read_text().rpartition(")")[2].split()
                    if int(fields[3]) == self.process.pid and fields[0] != "Z":
                        found.append(int(entry.name))
        return found

    def end(self) -> None:
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()


def limit_memory(call: Call, disk: Path) -> None:
    """What `ulimit -v` would have set: no process of the call grows from here on."""
    for process in call.processes():
        with suppress(OSError, ProcessLookupError):
            now = int((Path("/proc") / str(process) / "statm").read_text().split()[0]) * resource.getpagesize()
            resource.prlimit(process, resource.RLIMIT_AS, (now + MORE, now + MORE))


def fill(call: Call, disk: Path) -> None:
    with suppress(OSError), (disk / "filler").open("wb", buffering=0) as stream:
        while True:
            stream.write(bytes(2**16))
    with suppress(OSError), (disk / "filler").open("ab", buffering=0) as stream:
        while True:
            stream.write(b"x")


def protect(call: Call, disk: Path) -> None:
    """Only to be read, as soon as no file is being written."""
    for _ in range(2000):
        if subprocess.run(["mount", "-o", "remount,ro", disk], capture_output=True, check=False).returncode == 0:
            return
        time.sleep(0.001)


STRIKE: dict[str, Callable[[Call, Path], object]] = {
    "kill -9": lambda call, disk: call.process.kill(),
    "Ctrl-C": lambda call, disk: os.killpg(call.process.pid, signal.SIGINT),
    "full disk": fill,
    "read-only disk": protect,
    "memory limit": limit_memory,
}


def tried(job: Job, fault: str, moment: float, folder: Path) -> dict[str, object]:
    """One call, stopped after `moment` s, and the next one."""
    whole, words = folder / job.name.replace(" ", "_") / "whole", words_of(job, folder, folder / "disk")
    with own_disk(folder) as disk:
        call = Call(words, folder / "said")
        status = call.wait(moment)
        if status is None:
            with suppress(ProcessLookupError):
                STRIKE[fault](call, disk)
            status = call.wait(LONGEST)
        deadline = time.monotonic() + 10
        while call.processes() and time.monotonic() < deadline:
            time.sleep(0.1)
        left = [f"process {number}" for number in call.processes()]
        call.end()
        end, story = ended(status, call.told(), fault), call.told()[-1500:]
        (disk / "filler").unlink(missing_ok=True) if fault != "read-only disk" else subprocess.run(
            ["mount", "-o", "remount,rw", disk], check=False, capture_output=True
        )
        half = half_written(job, disk, whole)
        if fault in ("Ctrl-C", "full disk", "memory limit"):
            left += [path.name for path in disk.rglob(".*.part")]
        again = Call(words, folder / "said")
        says, deadline = "says nothing", time.monotonic() + PATIENCE
        while says == "says nothing" and time.monotonic() < deadline:
            over = again.wait(0.05) is not None
            says = said(again.told())
            if over:
                break
        if job.same:
            if again.wait(LONGEST) != 0 or contents(disk) != contents(whole):
                half.append(f"not finished: {again.told()[-500:]}")
        elif again.process.poll() is None:
            with suppress(ProcessLookupError):
                os.killpg(again.process.pid, signal.SIGINT)
            again.wait(60)
        again.end()
        left += [path.name for path in disk.rglob(".*.part")]
        bad = end == "crash" or half or left or says == "says nothing"
        return {
            "moment": round(moment, 2), "end": end, "half-written": half, "left behind": left, "again": says,
            "story": story if bad else "", "second": again.told()[-500:] if bad else "",
        }  # fmt: skip


def ended(status: int | None, told: str, fault: str) -> str:
    """One of ENDS."""
    if status == 0:
        return "done"
    if status == -signal.SIGKILL and fault == "kill -9":
        return "killed"
    clear = (
        status in (1, 2) and "Traceback" not in told and any(line.startswith("error: ") for line in told.splitlines())
    )
    return "error" if clear else "crash"


def said(told: str) -> str:
    """What a call says of calls before."""
    if "begins afresh" in told:
        return "afresh"
    return "goes on" if "goes on" in told else "says nothing"


def half_written(job: Job, disk: Path, whole: Path) -> list[str]:
    """Files under their names that are not whole."""
    bad = []
    for path in disk.rglob("*"):
        if not path.is_file() or path.name == "filler" or path.name.endswith(".part"):
            continue
        name = str(path.relative_to(disk))
        try:
            if job.same and path.read_bytes() != (whole / name).read_bytes():
                bad.append(f"{name} differs")
            elif path.suffix == ".json":
                document = json.loads(path.read_text())
                if "verdict" in document and "complete" not in document and job.name == "gap diagnose":
                    bad.append(f"{name} does not say whether it is complete")
            elif path.suffix == ".toml":
                tomllib.loads(path.read_text())
            elif path.suffix == ".mcap":
                from boom_mj.logs import read_mcap

                read_mcap(path)
            elif path.suffix == ".html" and "</html>" not in path.read_text()[-200:]:
                bad.append(f"{name} has no end")
            elif path.suffix == ".png" and cv2.imdecode(np.frombuffer(path.read_bytes(), np.uint8), 0) is None:
                bad.append(f"{name} is no picture")
        except Exception as error:
            bad.append(f"{name}: {error}")
    return bad


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def table(rows: Sequence[dict]) -> str:
    """Counts by job and by fault, as Markdown."""
    lines = []
    for key, names in (("job", [job.name for job in JOBS]), ("fault", FAULTS)):
        lines += [f"| {key} | " + " | ".join(COLUMNS) + " |", "|---" * (len(COLUMNS) + 1) + "|"]
        for name in (*names, *(("all",) if key == "fault" else ())):
            mine = [row for row in rows if name in (row[key], "all")]
            count = Counter([row["end"] for row in mine] + [row["again"] for row in mine])
            count.update({"tried": len(mine)})
            for what in ("half-written", "left behind"):
                count[what] = sum(bool(row[what]) for row in mine)
            lines.append(f"| {name} | " + " | ".join(str(count[column]) for column in COLUMNS) + " |")
        lines.append("")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
