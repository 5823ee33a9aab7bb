"""Golden answers: what the commands say of fixed inputs, to show what a change moved.

    python scripts/golden.py record DIR [--only GLOB]    run them in this checkout; what DIR holds already stays
    python scripts/golden.py compare OLD NEW [--only GLOB]    record into NEW what it lacks, then one table row a case

Inputs: the logs of ../shared (or of --shared), those of this repository, and a fixed secret. What two runs of one
commit differ in - times, versions, where files lie - is masked. `compare` ends with status 1 where an answer moved
beyond GAP or HALF. A record takes about 40 minutes on two cores; one that was stopped goes on.
"""

import argparse
import fnmatch
import hashlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
MASKED = {"wall_s", "simulated_s", "boom_mj", "mujoco", "loop_wall_s", "duration", "seed"}
SECRET = b"golden answers: no secret at all"
GAP, HALF = 0.005, 0.05  # how far a gap, and a size in terms of half its interval, may move


def commands(shared: Path) -> dict[str, list[str]]:
    """By name of the case: arguments of the command; `OUT` stands for a folder of its own."""
    found: dict[str, list[str]] = {}
    for kind in ("examples", "blind"):
        for case in sorted(path for path in (shared / kind).glob("*") if path.is_dir()):
            train, held_out = (sorted(map(str, case.glob(f"{part}/*.mcap"))) for part in ("train", "holdout"))
            found[f"{kind}-{case.name}"] = ["gap", "diagnose", *train, "--holdout", *held_out, "--json", "-"]
    logs = sorted(map(str, (ROOT / "examples" / "unknown_payload").glob("*.mcap")))
    found["unknown_payload"] = ["gap", "diagnose", logs[0], "--holdout", *logs[1:], "--json", "-"]
    for name, log, *held_out in (
        ("emps", "emps/DATA_EMPS.mat"),
        ("two_link_arm", "two_link_arm/lqr_full_10deg.mat"),
        ("clamped_beam", "clamped_beam/beam_gravity_V2_a.csv.gz", "clamped_beam/beam_gravity_V2_b.csv.gz"),
        ("flexible_joint", "flexible_joint/scope_data_PRBS.mat"),
        ("so101", "so101/friction_gravity/state_motor.csv.gz"),
    ):
        paths = [str(shared / "real" / one) for one in (log, *held_out)]
        judged = ["--holdout", *paths[1:]] if held_out else []
        machine = ["--map", str(ROOT / "models" / "real" / f"{name}.toml")]
        found[f"real-{name}"] = ["gap", "diagnose", paths[0], *judged, *machine, "--json", "-"]
    healthy = sorted(map(str, (shared / "examples" / "0472b1d86ab2" / "train").glob("release_*.mcap")))
    found["calibrate"] = ["calibrate", "boom36", *healthy, "--json", "-"]
    found["plan"] = ["calibrate", "boom36", healthy[0], "--plan", "--json", "-"]
    found["replay"] = ["replay", str(ROOT / "logs" / "fold_in_300.mcap"), "--json"]
    found["replay-free"] = ["replay", str(ROOT / "logs" / "independent_release_stretched_vertical.mcap"), "--json"]
    found["validate"] = ["validate", "boom36", "--json"]
    for hinges in (1, 2, 4):
        found[f"generate-{hinges}"] = ["generate", "boom36", "--hinges", str(hinges), "-o", "OUT/model.xml"]
    found["blind-make"] = [
        *("gap", "blind", "make", "--cases", "8", "--short", "--seed-file", "OUT/secret", "--seal", "OUT/seal"),
        *("-o", "OUT/cases"),
    ]
    return found


def answer(arguments: list[str]) -> tuple[Any, dict[str, float]]:
    """What a command says, masked, and what it cost."""
    with tempfile.TemporaryDirectory() as scratch:
        out = Path(scratch)
        (out / "secret").write_bytes(SECRET)
        words = [word.replace("OUT/", f"{out}/") for word in arguments]
        with (out / "stdout").open("wb") as stdout, (out / "stderr").open("wb") as stderr:
            process = subprocess.Popen(
                [sys.executable, "-m", "boom_mj", *words], cwd=ROOT, stdout=stdout, stderr=stderr
            )
            _, status, used = os.wait4(process.pid, 0)
        cost = {"cpu_s": round(used.ru_utime + used.ru_stime, 1), "memory_gb": round(used.ru_maxrss / 2**20, 2)}
        if status:
            return {"failed": (out / "stderr").read_text(errors="replace")[-2000:]}, cost
        if "--json" in arguments:
            return masked(json.loads((out / "stdout").read_text())), cost
        (out / "secret").unlink()
        files = sorted(path for path in out.rglob("*") if path.is_file() and path.parent != out)
        files += [path for path in (out / "model.xml", out / "seal") if path.exists()]
        return {str(path.relative_to(out)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}, cost


def masked(value: Any) -> Any:
    """Without what two runs of one commit differ in."""
    if isinstance(value, dict):
        return {key: masked(item) for key, item in value.items() if key not in MASKED}
    if isinstance(value, list):
        return [masked(item) for item in value]
    return Path(value).name if isinstance(value, str) and value.startswith("/") else value


def record(folder: Path, shared: Path, only: str, jobs: int) -> None:
    """Run what a folder lacks."""
    folder.mkdir(parents=True, exist_ok=True)
    todo = {k: v for k, v in commands(shared).items() if fnmatch.fnmatch(k, only)}
    todo = {name: words for name, words in todo.items() if not (folder / f"{name}.json").exists()}

    def run(item: tuple[str, list[str]]) -> None:
        name, words = item
        said, cost = answer(words)
        part = folder / f".{name}.part"
        part.write_text(json.dumps({"cost": cost, "answer": said}, indent=1) + "\n")
        part.rename(folder / f"{name}.json")
        print(f"{name}: {cost['cpu_s']:.0f} CPU s, {cost['memory_gb']:.1f} GB", file=sys.stderr, flush=True)

    with ThreadPoolExecutor(jobs) as pool:
        list(pool.map(run, todo.items()))


def leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """All numbers and words of a document, by their path."""
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else None
    if pairs is None:
        yield path, value
        return
    for key, item in pairs:
        yield from leaves(item, f"{path}/{key}")


def essence(document: Mapping[str, Any]) -> Any:
    """Of a diagnosis: verdict, causes at their places, ties."""
    named = [(e["id"], sorted(e["location"].items())) for e in document["effects"]]
    tied = [sorted(e["id"] for e in tie) for tie in document["ties"]]
    return json.loads(json.dumps([document["verdict"], sorted(named), tied]))


def moved(old: Any, new: Any) -> tuple[float, float]:
    """Between diagnoses of one essence: the largest move of a gap, and of a size in halves of its interval."""
    gaps = [
        abs(old["gap"][part][end] - new["gap"][part][end])
        for part in ("train", "holdout")
        for end in ("before", "after")
    ]
    sizes = [0.0]
    for a in old["effects"]:
        b = next(e for e in new["effects"] if (e["id"], e["location"]) == (a["id"], a["location"]))
        for name, size in a["parameters"].items():
            if None not in (size["low"], size["high"]) and size["high"] > size["low"]:
                sizes.append(2 * abs(size["value"] - b["parameters"][name]["value"]) / (size["high"] - size["low"]))
    return max(gaps), max(sizes)


def compare(old: Path, new: Path, only: str) -> bool:
    """Print a row a case; whether all stays within bounds."""
    fine = True
    print("| case | answer | gap moved | size moved | CPU s before, after |\n|---|---|---|---|---|")
    for path in sorted(old.glob("*.json")):
        if not fnmatch.fnmatch(path.stem, only):
            continue
        before, after = json.loads(path.read_text()), json.loads((new / path.name).read_text())
        a, b, figures = before["answer"], after["answer"], ("", "")
        if a == b:
            words = "identical"
        elif "verdict" in a and "verdict" in b and essence(a) == essence(b):
            gap, size = moved(a, b)
            words, figures = "same causes", (f"{gap:.2g}", f"{size:.1%}")
            fine &= gap <= GAP and size <= HALF
        else:
            one, other = dict(leaves(a)), dict(leaves(b))
            changed = [k for k in {**one, **other} if one.get(k) != other.get(k)]
            words = f"{len(changed)} of {len(one)} entries: " + "; ".join(
                f"{k}: {one.get(k)} -> {other.get(k)}"[:100] for k in changed[:3]
            )
            if "verdict" in a and "verdict" in b:
                words = f"**{essence(a)} -> {essence(b)}**"
            fine = False
        spent = f"{before['cost']['cpu_s']:.0f}, {after['cost']['cpu_s']:.0f}"
        print(f"| {path.stem} | {words} | {figures[0]} | {figures[1]} | {spent} |")
    return fine


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", choices=("record", "compare"))
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--only", default="*", help="cases whose name matches")
    parser.add_argument("--shared", type=Path, default=ROOT.parent / "shared")
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    if len(given.folders) != {"record": 1, "compare": 2}[given.work]:
        parser.error(f"{given.work} takes {'one folder' if given.work == 'record' else 'two folders'}")
    record(given.folders[-1].resolve(), given.shared.resolve(), given.only, given.jobs)
    if given.work == "compare" and not compare(*given.folders, given.only):
        sys.exit(1)


if __name__ == "__main__":
    main()
