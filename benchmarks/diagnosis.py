"""Where the time of a diagnosis goes: python benchmarks/diagnosis.py CASE (a folder with train/ and holdout/).

Wall and processor seconds at the end of every stage, then processor seconds of what the threads did, counted by
themselves: simulation at each level of fidelity, and what is made of simulations.
"""

import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from threading import Lock

from boom_mj.cli.arguments import find_machine
from boom_mj.diagnosis import diagnose
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.screening import Screening
from boom_mj.estimation.dataset import Dataset
from boom_mj.estimation.linear import LinearPosterior
from boom_mj.logs import read_log
from boom_mj.systems.boom import system as boom
from boom_mj.systems.predictor import Predictor, dataset_of

SPENT: Counter[str] = Counter()
CALLS: Counter[str] = Counter()
LOCK = Lock()


def count(owner: object, function: str, name: Callable[..., str]) -> None:
    """Replace a function by one that counts its calls and its thread's processor time."""
    plain = getattr(owner, function)

    def counted(*args: object, **options: object) -> object:
        began = time.thread_time()
        result = plain(*args, **options)
        with LOCK:
            SPENT[name(*args)] += time.thread_time() - began
            CALLS[name(*args)] += 1
        return result

    setattr(owner, function, counted)


def main() -> None:
    case = Path(sys.argv[1])
    train, held_out = (sorted(case.glob(f"{part}/*.mcap")) for part in ("train", "holdout"))
    count(boom, "run", lambda plant, *rest: f"MuJoCo and statics, {plant.model.nv} degrees of freedom")
    count(boom, "ideal_signals", lambda *args: "signals of ideal sensors")
    count(boom, "apply_sensor_effects", lambda *args: "effects of sensors")
    count(Dataset, "means", lambda *args: "block means")
    count(LinearPosterior, "estimate", lambda *args: "nuisances")
    count(LinearPosterior, "project", lambda *args: "projections")
    count(Screening, "rank", lambda *args: "ranking")
    wall, processor = time.perf_counter(), time.process_time()
    recordings = [read_log(path) for path in (*train, *held_out)]
    system = boom.BoomSystem(find_machine(recordings[0].machine))
    predictor = Predictor(system, dataset_of(system, recordings, len(train)))

    def tell(line: str) -> None:
        spent = time.perf_counter() - wall, time.process_time() - processor
        print(
            f"{spent[0]:7.1f} s wall {spent[1]:7.1f} s CPU {predictor.simulated_s:8.0f} s simulated | {line}",
            flush=True,
        )

    answer = diagnose(predictor, clock=Clock(tell=tell))
    tell(answer.verdict)
    for name, seconds in SPENT.most_common():
        print(f"{seconds:7.1f} s CPU in {CALLS[name]:6d} calls: {name}")


if __name__ == "__main__":
    main()
