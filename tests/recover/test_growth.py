"""A machine that changes is watched: since when, what, and how large in every log; healthy logs tell how it was built.

The machine that is measured has six hinges per coordinate, links that are softer and heavier than the machine file's,
zero offsets and noise.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.healthy import as_built
from boom_mj.diagnosis.watch import watch
from boom_mj.effects import make_effect
from boom_mj.machine import load_machine
from boom_mj.recording import Recording
from boom_mj.report import draw_watch
from boom_mj.sensors import measure
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment
from boom_mj.systems.boom import BoomSystem

BOOM = load_machine("boom36")
OWN = (
    make_effect("joint_zero_offset", {"joint": 2, "offset": -0.004}),
    make_effect("link_stiffness", {"link": 3, "axis": "v", "factor": 0.96}),
    make_effect("link_mass", {"link": 4, "factor": 1.03}),
)
LOADS = {"monday": 0.0, "tuesday": 12.0, "wednesday": 24.0}  # kg at the tip
PLAN = CATALOGUE["release_bow_vertical"].model_copy(update={"duration": 14.0})


def record(name: str, load: float = 0.0, seed: int = 0) -> Recording:
    effects = (*OWN, make_effect("tip_payload", {"mass": load})) if load else OWN
    motion = run_experiment(make_plant(BOOM, 6, effects), PLAN)
    return measure(motion, name, BOOM.name, PLAN.duration, np.random.default_rng(seed))


@cache
def healthy() -> tuple[Recording, ...]:
    return record("first", seed=1), record("second", seed=2)


def test_healthy_recordings_say_how_a_boom_was_built_and_what_they_leave_unsure() -> None:
    built = as_built(BoomSystem(BOOM), healthy())
    (softer,) = [e for e in built.built if e.location == {"link": 3, "axis": "v"}]
    assert softer.values["factor"] == pytest.approx(0.96, abs=0.025)
    usual = built.system.nuisances()
    assert len(built.nuisances()) == len(usual)
    assert built.nuisances()[:9] == usual[:9]  # zero offsets, friction of cylinders, pressure sensors


def test_a_load_that_grows(tmp_path: Path) -> None:
    logs = [record(name, load, seed) for seed, (name, load) in enumerate(LOADS.items(), 3)]
    found = watch(BoomSystem(BOOM), healthy(), logs)
    answer = found.document()
    assert [log["changed"] for log in answer["logs"]] == [False, True, True]
    assert answer["since"] == {"log": "tuesday", "time_s": 0.0}
    assert (answer["verdict"], [e["id"] for e in answer["effects"]]) == ("explained", ["tip_payload"])
    sizes = [log["effects"][0]["parameters"]["mass"] for log in answer["logs"]]
    assert [size["value"] for size in sizes] == pytest.approx(list(LOADS.values()), abs=1.2)
    assert [size["value"] - sizes[0]["value"] for size in sizes] == pytest.approx(list(LOADS.values()), abs=0.5)
    assert all(size["high"] - size["low"] < 1.5 for size in sizes)
    draw_watch(answer, tmp_path / "watch.png")
    assert (tmp_path / "watch.png").read_bytes().startswith(b"\x89PNG")


def test_a_load_that_is_hooked_on_within_a_log() -> None:
    """Nothing before it is seen of it, though nuisances would follow."""
    before, after = record("monday", seed=3), record("monday", 30.0, 4)
    joined = {}
    for name, signal in after.signals.items():
        old, moment = before.signals[name], 10.0
        early, late = old.time < moment, signal.time >= moment
        values = np.concatenate([old.values[early], signal.values[late]])
        joined[name] = replace(signal, time=np.concatenate([old.time[early], signal.time[late]]), values=values)
    found = watch(BoomSystem(BOOM), healthy(), [replace(after, signals=joined)], Clock(0.0))
    assert found.since == ("monday", 10.0)
    assert not found.logs[0].effects  # there is no time for sizes
