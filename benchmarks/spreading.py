"""What spreading work gains: one, two, four workers on simulation, rendering, diagnosis: docs/results/spreading.md.

python benchmarks/spreading.py [-o docs/results/spreading.md]
    [--points 40] [--frames 48] [--cases 8] [--full] [--turns 3]

(About half an hour on two cores that have nothing else to do.) Workers are processes of a Dask cluster
on this machine. They have imported what they need before the clock starts, numbers of workers take turns, and figures
are medians over turns. Processor seconds are all that the workers used, whoever waited for what. Cases for the
diagnosis and all figures stay in the work folder: what is there is not made again.
"""

import argparse
import json
import os
import resource
import shutil
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from statistics import median

import cv2
from dask import distributed

from boom_mj.blind import SHORT, SUITE, BoomBench, Suite, answer_cases, make_cases
from boom_mj.cameras.dataset import write_json
from boom_mj.cameras.describe import describe
from boom_mj.cameras.film import Film, film_of
from boom_mj.cameras.formats import write_coco, write_nerfstudio
from boom_mj.cameras.rig import rig_of
from boom_mj.cameras.shooting import BATCH, Look, frames_of, render_frames
from boom_mj.machine import load_machine
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment
from boom_mj.spreading import spread
from boom_mj.sweeping import Axis, Sweep, run_sweep

ROOT = Path(__file__).parents[1]
FILE = ROOT / "models" / "boom36.toml"
MOTION = CATALOGUE["release_stretched_vertical"]
WORKERS = (1, 2, 4)
MODULES = ("boom_mj.sweeping", "boom_mj.cameras.shooting", "boom_mj.blind")
NOTHING = 1000  # items without work
JPEG = 90  # percent
LOGS, IMAGES, CORES, DAY = 10_000, 10_000_000, 64, 24.0  # the plan: machines of so many cores, for so many hours

Work = Callable[[Path, str], None]
"""Does all items in an empty folder on a cluster."""


@dataclass(frozen=True)
class Cost:
    """What a number of workers took: wall s, processor s of all of them, largest memory of one so far, bytes."""

    wall: float
    processor: float
    memory: float


def simulate(folder: Path, cluster: str, points: int) -> None:
    """A sweep of a payload: recordings of 30 s with noise."""
    axis = Axis("tip_payload", "mass", 0.0, 100.0, points)
    _refuse(error for _, error in run_sweep(Sweep(load_machine(FILE), MOTION, (axis,)), folder, cluster=cluster))


def render(folder: Path, cluster: str, film: Film, frames: int) -> None:
    """Labelled pictures of 1920 x 1080 px by three cameras, as PNG."""
    wanted = frames_of(film, 8.0, 8.0 + (frames // len(film.rig) - 1) / 20, 1)
    render_frames(film, wanted, Look(), folder, lambda done, total: None, cluster=cluster)


def diagnose(folder: Path, cluster: str, cases: list[Path]) -> None:
    """Blind cases."""
    _refuse(error for _, error in answer_cases(cases, folder, cluster=cluster))


def nothing(folder: Path, cluster: str) -> None:
    """What spreading itself costs."""
    for _ in spread(abs, range(NOTHING), cluster=cluster):
        pass


def _refuse(errors: Iterable[BaseException | None]) -> None:
    for error in errors:
        if error is not None:
            raise error


def blind_cases(folder: Path, count: int, suite: Suite) -> list[Path]:
    """Cases to diagnose, half of them healthy; made once."""
    if not (folder / "seal.sha256").exists():
        secret, mix = b"everybody may know this one", {"none": 1.0, "single": 1.0}
        jobs, seal = os.cpu_count() or 1, folder.with_suffix(".json")
        for done in make_cases(count, secret, BoomBench(FILE.read_text(), suite), mix, folder, seal, jobs):
            print(f"cases made: {done} of {count}", flush=True)
    return sorted(path.parent for path in folder.glob("*/withhold.json"))


def measure(works: Mapping[str, Work], workers: int, scratch: Path) -> dict[str, Cost]:
    """Every work once, by workers that have imported everything."""
    options = {"n_workers": workers, "threads_per_worker": 1, "dashboard_address": None, "host": "127.0.0.1"}
    found = {}
    with (
        distributed.LocalCluster(**options, local_directory=str(scratch / "dask")) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        for module in MODULES:
            client.run(import_module, module)
        for name, work in works.items():
            folder = Path(tempfile.mkdtemp(dir=scratch))
            used, began = sum(client.run(time.process_time).values()), time.perf_counter()
            work(folder, cluster.scheduler_address)
            wall = time.perf_counter() - began
            used = sum(client.run(time.process_time).values()) - used
            memory = max(usage.ru_maxrss for usage in client.run(resource.getrusage, resource.RUSAGE_SELF).values())
            found[name] = Cost(wall, used, 1024.0 * memory)
            print(f"{workers} workers, {name}: {wall:.1f} s, {used:.1f} s of processors", flush=True)
            shutil.rmtree(folder)
    return found


def sizes(film: Film, points: int, frames: int, cases: list[Path], scratch: Path) -> dict[str, float]:
    """Bytes of what is written, and the caller's own seconds per picture for the layouts."""
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
        for name, work in (
            ("sweep", partial(simulate, points=points)),
            ("set", partial(render, film=film, frames=frames)),
        ):
            (scratch / name).mkdir()
            work(scratch / name, cluster.scheduler_address)
    pictures, labels = (list((scratch / "set").glob(f"{kind}/*/*")) for kind in ("images", "labels"))
    jpeg = [cv2.imencode(".jpg", cv2.imread(str(path)), [cv2.IMWRITE_JPEG_QUALITY, JPEG])[1].size for path in pictures]
    wanted = frames_of(film, 8.0, 8.0 + (frames // len(film.rig) - 1) / 20, 1)
    dataset = describe(film, wanted, Look(), False, MOTION.name, MOTION.description, {})
    began = time.perf_counter()
    write_json(scratch / "set" / "dataset.json", dataset.model_dump(mode="json"), indent=1)
    write_coco(scratch / "set", dataset, [film.model.body(k).name for k in range(film.model.nbody)])
    write_nerfstudio(scratch / "set", dataset)
    layouts = (time.perf_counter() - began) / len(pictures)
    return {
        "log": _mean([*(scratch / "sweep").glob("*.mcap")]),
        "case_log": _mean([path for case in cases for path in case.glob("*/*.mcap")]),
        "png": _mean(pictures),
        "jpeg": sum(jpeg) / len(jpeg),
        "label": _mean(labels),
        "layouts_s": layouts,
    }


def _mean(paths: list[Path]) -> float:
    return sum(path.stat().st_size for path in paths) / len(paths)


def run_all(given: argparse.Namespace) -> dict:
    """Everything that is measured, as it is kept in the work folder."""
    suite = SUITE if given.full else SHORT
    cases = blind_cases(given.work / ("cases_full" if given.full else "cases"), given.cases, suite)[: given.cases]
    plant = make_plant(load_machine(FILE), 1)
    film = film_of(run_experiment(plant, MOTION), rig_of(plant.machine))
    frames = given.frames // len(film.rig) * len(film.rig)
    works: dict[str, Work] = {  # the largest memory last
        "nothing": nothing,
        "simulation": partial(simulate, points=given.points),
        "diagnosis": partial(diagnose, cases=cases),
        "rendering": partial(render, film=film, frames=frames),
    }
    turns: list[dict[int, dict[str, Cost]]] = []
    with tempfile.TemporaryDirectory(dir=given.work) as scratch:
        for _ in range(given.turns):
            turns.append({workers: measure(works, workers, Path(scratch)) for workers in WORKERS})
        written = sizes(film, given.points, frames, cases, Path(scratch))
    costs = {
        name: {
            str(n): {key: median(vars(turn[n][name])[key] for turn in turns) for key in ("wall", "processor", "memory")}
            for n in WORKERS
        }
        for name in works
    }
    logs = len(suite.train) + len(suite.holdout)
    seconds = sum(CATALOGUE[name].duration for name in (*suite.train, *suite.holdout))
    return {
        "items": {"simulation": given.points, "rendering": frames, "diagnosis": len(cases), "nothing": NOTHING},
        "cores": os.cpu_count(),
        "turns": given.turns,
        "case": {"logs": logs, "seconds": seconds},
        "costs": costs,
        "sizes": written,
    }


def efficiency_rows(found: dict) -> list[str]:
    """A row per work and number of workers."""
    labels = {"simulation": "simulation, logs", "diagnosis": "diagnosis, cases", "rendering": "rendering, pictures"}
    rows = []
    for name, label in labels.items():
        items, costs = found["items"][name], found["costs"][name]
        for workers, cost in costs.items():
            gain = costs["1"]["wall"] / cost["wall"]
            rows.append(
                f"| {label} | {items} | {workers} | {60 * items / cost['wall']:.1f} | {gain:.2f} | "
                f"{gain / min(int(workers), found['cores']):.0%} | {cost['processor'] / items:.2f} | "
                f"{cost['memory'] / 1e9:.2f} |"
            )
    return rows


def plan(found: dict) -> dict[str, str]:
    """The big jobs on paper: rows of the table, and the figures of the sentences about it."""
    costs, items, size, case = (found[key] for key in ("costs", "items", "sizes", "case"))
    busy = str(min(2, found["cores"]))  # workers on as many cores

    def row(what: str, name: str, count: float, disk: float) -> str:
        each = costs[name][busy]["processor"] / items[name]
        gain = costs[name]["1"]["wall"] / costs[name][busy]["wall"] / int(busy)
        hours, memory = count * each / 3600, CORES * costs[name][busy]["memory"]
        return (
            f"| {what} | {each:.2f} | {_spaced(hours, 1)} | {disk / 1e12:.3g} | {hours / gain / CORES / DAY:.2g} | "
            f"{memory / 1e9:.0f} |"
        )

    cases = -(-LOGS // case["logs"])
    picture = costs["rendering"][busy]["processor"] / items["rendering"]
    rate = NOTHING / costs["nothing"][busy]["wall"]
    rows = [
        row(f"simulate {_spaced(LOGS)} logs of {MOTION.duration:.0f} s", "simulation", LOGS, LOGS * size["log"]),
        row(
            f"diagnose {_spaced(LOGS)} logs, {_spaced(cases)} cases of {case['logs']}",
            "diagnosis",
            cases,
            LOGS * size["case_log"],
        ),
        row(f"render {_spaced(IMAGES)} pictures, PNG", "rendering", IMAGES, IMAGES * (size["png"] + size["label"])),
        row(f"the same, JPEG of quality {JPEG}", "rendering", IMAGES, IMAGES * (size["jpeg"] + size["label"])),
    ]
    return {
        "plan": "\n".join(rows),
        "rate": f"{rate:.0f}",
        "feeds": _spaced(rate * picture * BATCH),
        "layouts": f"{1000 * size['layouts_s']:.1f}",
        "layouts_h": f"{IMAGES * size['layouts_s'] / 3600:.1f}",
        "stream": f"{CORES / picture * size['png'] / 1e6:.0f}",
    }


def _spaced(number: float, digits: int = 0) -> str:
    return f"{number:,.{digits}f}".replace(",", " ")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", dest="output", type=Path)
    parser.add_argument("--points", type=int, default=40)
    parser.add_argument("--frames", type=int, default=48)
    parser.add_argument("--cases", type=int, default=8)
    parser.add_argument("--full", action="store_true", help="cases of eight logs, 350 s, instead of three of 30 s")
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--work", type=Path, default=ROOT / "out" / "spreading")
    given = parser.parse_args()
    given.work = given.work.resolve()
    given.work.mkdir(parents=True, exist_ok=True)
    os.environ.setdefault("MUJOCO_GL", "egl")
    kept = given.work / "figures.json"
    if not kept.is_file():
        kept.write_text(json.dumps(run_all(given), indent=1))
    found = json.loads(kept.read_text())
    filled = {
        "efficiency": "\n".join(efficiency_rows(found)),
        "cores": str(found["cores"]),
        "turns": str(found["turns"]),
        **{f"{name}_items": str(found["items"][name]) for name in ("simulation", "rendering", "diagnosis")},
        "case_logs": str(found["case"]["logs"]),
        "case_s": f"{found['case']['seconds']:.0f}",
        "machine_cores": str(CORES),
        **plan(found),
    }
    print(filled["efficiency"], filled["plan"], sep="\n\n")
    if given.output is not None:
        text = (ROOT / "docs" / "results" / "spreading.md.in").read_text()
        for name, value in filled.items():
            text = text.replace("{" + name + "}", value)
        given.output.write_text(text)


if __name__ == "__main__":
    main()
