"""Blind cases on a Dask cluster of two workers, one of which is killed on the way: is anything lost or done twice?

python scripts/cluster_demo.py [FOLDER] [--cases 4] [--compare]     (about a minute a case; needs boom_mj[cluster])

Makes short cases in FOLDER (out/cluster_demo), starts a scheduler and two workers on loopback, runs `gap blind run
--cluster`, kills a worker with SIGKILL while it has a case and another is answered, and counts. `--compare` diagnoses
the cases on this machine alone, too, and holds the answers against each other.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from contextlib import ExitStack
from pathlib import Path

from dask import distributed

ROOT = Path(__file__).parents[1]
FEW = {"none": 1.0, "single": 1.0}


def blind(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "boom_mj", "gap", "blind", *map(str, arguments)]


def executing(dask_worker: distributed.Worker) -> list[str]:
    """What a worker is at."""
    return [task.key for task in dask_worker.state.executing]


def start_cluster(stack: ExitStack, folder: Path) -> tuple[str, dict[str, subprocess.Popen]]:
    """Address of a scheduler, and its two workers by address; all end with the stack."""
    quiet = {"stderr": (folder / "cluster.log").open("w"), "cwd": ROOT}
    file = folder / "scheduler.json"
    file.unlink(missing_ok=True)
    dask = [sys.executable, "-m", "dask"]
    said = ["--scheduler-file", str(file)]

    def start(*words: str) -> subprocess.Popen:
        process = subprocess.Popen([*dask, *words, *said], **quiet)
        stack.callback(process.wait)
        stack.callback(process.kill)
        return process

    start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    while not file.exists():
        time.sleep(0.1)
    workers = {name: start("worker", "--nthreads", "1", "--no-nanny", "--name", name) for name in ("one", "two")}
    address = json.loads(file.read_text())["address"]
    with distributed.Client(address, set_as_default=False) as client:
        client.wait_for_workers(2)
        names = {worker["name"]: place for place, worker in client.scheduler_info()["workers"].items()}
    return address, {names[name]: process for name, process in workers.items()}


def watch(
    run: subprocess.Popen, address: str, workers: dict[str, subprocess.Popen], answers: Path
) -> dict[str, object]:
    """Kill a worker once; what was begun and written until the run ends."""
    begun: set[tuple[str, str]] = set()
    written: set[tuple[str, int]] = set()
    dead: list[str] = []
    with distributed.Client(address, set_as_default=False) as client:
        while run.poll() is None:
            now = client.run(executing, on_error="ignore")
            begun |= {(key, worker) for worker, keys in now.items() for key in keys if key.startswith("_call")}
            written |= {(path.name, path.stat().st_ino) for path in answers.glob("*.json")}
            busy = [worker for worker, keys in now.items() if keys]
            if written and busy and not dead:
                dead.append(busy[0])
                workers[busy[0]].send_signal(signal.SIGKILL)
            time.sleep(0.5)
    written |= {(path.name, path.stat().st_ino) for path in answers.glob("*.json")}
    times = Counter(key for key, _ in begun)
    return {
        "workers killed": len(dead),
        "cases begun": len(times),
        "begun again": sum(times.values()) - len(times),
        "of these, begun by the killed worker": sum(times[key] > 1 and (key, dead[0]) in begun for key in times),
        "answers written": len({name for name, _ in written}),
        "written again": len(written) - len({name for name, _ in written}),
        "half-written files": len(list(answers.glob(".*"))),
        "exit status": run.returncode,
    }


def same(one: Path, other: Path) -> int:
    """How many answers are the same but for the time they took."""

    def read(path: Path) -> dict:
        return {key: value for key, value in json.loads(path.read_text()).items() if key != "wall_s"}

    return sum(read(path) == read(other / path.name) for path in one.glob("*.json"))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", default=ROOT / "out" / "cluster_demo")
    parser.add_argument("--cases", type=int, default=4)
    parser.add_argument("--compare", action="store_true")
    given = parser.parse_args()
    folder = given.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    cases, secret, answers = folder / "cases", folder / "secret", folder / f"answers_{time.time_ns()}"
    answers.mkdir()
    if not (cases / "seal.sha256").exists():
        secret.write_bytes(os.urandom(32))
        mix = ",".join(f"{kind}={share}" for kind, share in FEW.items())
        made = ("--cases", given.cases, "--seed-file", secret, "-o", cases, "--seal", folder / "seal.json")
        subprocess.run(blind("make", *made, "--short", "--mix", mix), check=True, cwd=ROOT)
    with ExitStack() as stack:
        address, workers = start_cluster(stack, folder)
        run = subprocess.Popen(blind("run", cases, "-o", answers, "--cluster", address), cwd=ROOT)
        stack.callback(run.kill)
        found = {"cases": len(list(cases.glob("*/withhold.json"))), **watch(run, address, workers, answers)}
    if given.compare:
        alone = folder / "alone"
        subprocess.run(blind("run", cases, "-o", alone, "--jobs", 1), check=True, cwd=ROOT)
        found["answers as on one machine"] = same(answers, alone)
    print("| what | count |\n|---|---|", *(f"| {what} | {count} |" for what, count in found.items()), sep="\n")


if __name__ == "__main__":
    main()
