"""How fast the 300 s fold-in is: whole command, inner loop, other models, other steps. Writes docs/results/speed.md.

Run: .venv/bin/python -m pip install -e ".[bench]"; .venv/bin/python benchmarks/speed.py   (about 4 minutes)
Times are CPU times of one thread, medians; ratios compare runs that took turns.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from statistics import median

import mujoco
import numpy as np
from exudyn_boom import ExudynBoom
from mujoco import rollout
from scipy.signal import find_peaks

from boom_mj.logs import read_log
from boom_mj.machine import Machine, load_machine
from boom_mj.reference import ReferenceModel, integrate
from boom_mj.replay import replay
from boom_mj.replay.quality import assess
from boom_mj.sensors import driving_angles, noise_levels
from boom_mj.simulation import CATALOGUE, Plant, Trajectory, driven_model, make_plant, run, run_experiment, step_times

Array = np.ndarray
ROOT = Path(__file__).parents[1]
LOG = ROOT / "logs" / "fold_in_300.mcap"
EXPERIMENT = CATALOGUE["fold_in_300"]
PAPER = 93.0  # s for the paper's 300 s on its authors' PC
TURNS = 5
REFERENCE_STRETCH = (40.0, 42.0)  # s: joint 5 starts to move
EXUDYN_STEP = 0.01  # s


def seconds() -> float:
    """CPU time of this process and of those it has waited for: what one core needs, whoever else uses the computer."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def costs(*works: Callable[[], object], turns: int = TURNS) -> list[float]:
    """Median cost of each work, s; they take turns, so that what else the computer does meets all of them."""
    found: list[list[float]] = [[] for _ in works]
    for _ in range(turns):
        for work, times in zip(works, found):
            began = seconds()
            work()
            times.append(seconds() - began)
    return [median(times) for times in found]


def command(*arguments: str) -> Callable[[], object]:
    """A run of Python in a process of its own."""
    line = [sys.executable, *arguments]
    return lambda: subprocess.run(
        line, check=True, capture_output=True, cwd=ROOT, env={**os.environ, "PYTHONWARNINGS": "ignore"}
    )


def loop_and_bare(machine: Machine, hinges: int) -> tuple[float, float]:
    """CPU times of `run` and of a bare mujoco.rollout of the same model, steps and controls, s."""
    plant = make_plant(machine, hinges)
    steps = step_times(plant, EXPERIMENT.duration)
    angles, force = EXPERIMENT.joint_path(steps)[0], EXPERIMENT.tip_force(steps)
    model, kind = driven_model(plant, bool(force.any())), mujoco.mjtState.mjSTATE_FULLPHYSICS
    data, state = mujoco.MjData(model), np.zeros(mujoco.mj_stateSize(model, kind))
    data.qpos[:] = plant.static_equilibrium(angles[0])
    mujoco.mj_getState(model, data, state, kind)
    control = np.zeros((1, len(steps), model.nu))
    control[0, :, [model.actuator(f"drive{k + 1}").id for k in range(5)]] = angles.T
    whole, bare = costs(lambda: run(plant, angles, force), lambda: rollout.rollout(model, data, state, control))
    return whole, bare


def others(machine: Machine) -> tuple[float, float, float]:
    """CPU times scaled to 300 s of the reference model and of Exudyn, s, and how far their tips end from ours, m."""

    @lru_cache(maxsize=4)
    def path(t: float) -> tuple[Array, ...]:
        return tuple(part[0] for part in EXPERIMENT.joint_path(np.array([t])))

    first, last = REFERENCE_STRETCH
    began = seconds()
    integrate(ReferenceModel(machine), path, lambda t: np.zeros(3), np.arange(first, last + 0.01, 0.02), 1e-5)
    reference = (seconds() - began) * EXPERIMENT.duration / (last - first)
    boom = ExudynBoom(machine, lambda t: path(t)[0])
    began = seconds()
    tip = boom.run(EXPERIMENT.duration, EXUDYN_STEP)
    exudyn = seconds() - began
    ours = run_experiment(make_plant(machine, 4), EXPERIMENT)
    apart = tip[:, 1:] - np.stack([np.interp(tip[:, 0], ours.time, c) for c in ours.sensor("marker12").T], axis=1)
    return reference, exudyn, float(np.sqrt(np.mean(np.sum(apart**2, axis=1))))


def stages(machine: Machine) -> list[tuple[str, float]]:
    """What the replay command spends its time on, s."""
    log, plant = read_log(LOG), make_plant(machine, 1)
    steps, noise = step_times(plant, EXPERIMENT.duration), noise_levels(machine)["joint/position"][0]
    result = replay(plant, log)
    with tempfile.TemporaryDirectory() as folder:
        files = ["-o", f"{folder}/twin.mcap", "--picture", f"{folder}/twin.png"]
        call = ["-m", "boom_mj", "replay", str(LOG)]
        python, imports, whole, written = costs(
            command("-c", "pass"),
            command("-c", "import boom_mj.cli, boom_mj.replay.quality"),
            command(*call),
            command(*call, *files),
        )
    reading, building, judging, smoothing, replaying, loop = costs(
        lambda: read_log(LOG),
        lambda: make_plant(machine, 1),
        lambda: assess(plant, log),
        lambda: driving_angles(log, noise, steps),
        lambda: replay(plant, log),
        lambda: run(plant, result.trajectory.joints, result.trajectory.tip_force),
    )
    return [
        ("Python", python),
        ("imports", imports - python),
        ("reading 126 000 messages", reading),
        ("building the model", building),
        ("checking the log", judging),
        ("smoothing", smoothing),
        ("simulating 60 001 steps", loop),
        ("sensors and comparison", replaying - smoothing - loop),
        ("**whole command**", whole),
        ("whole command with simulated log and picture written", written),
    ]


def with_step(machine: Machine, step: float) -> Plant:
    boom = make_plant(machine, 1).boom
    spec = boom.spec.copy()
    spec.option.timestep = step
    return Plant(replace(boom, spec=spec), spec.compile())


def tip_at(motion: Trajectory, time: Array) -> Array:
    return np.stack([np.interp(time, motion.time, column) for column in motion.sensor("marker12").T], axis=1)


def damping_ratio(plant: Plant) -> float:
    """Of the first vertical mode, by the decay of its peaks from 4 s after the cut on."""
    motion = run_experiment(plant, CATALOGUE["release_stretched_vertical"])
    height = motion.sensor("marker12")[:, 2] - plant.tip(plant.static_equilibrium(np.zeros(5)))[2]
    free = height[motion.time > 12]
    peaks = find_peaks(free)[0]
    decrement = -np.polyfit(np.arange(peaks.size), np.log(free[peaks]), 1)[0]
    return float(decrement / np.hypot(2 * np.pi, decrement))


def step_rows(machine: Machine) -> list[str]:
    """Steps of the integrator: speed, error against half the step, damping ratio of the first vertical mode."""
    plants = {step: with_step(machine, step) for step in (0.01, 0.005, 0.0025, 0.00125)}
    motions = {step: run_experiment(plant, EXPERIMENT) for step, plant in plants.items()}
    coarse = np.arange(0, EXPERIMENT.duration, 0.05)
    straight, plant = np.zeros(plants[0.005].model.nq), plants[0.005]
    deflections = []
    for joints in motions[0.005].joints[::200]:
        straight[plant.joints] = joints
        deflections.append(plant.tip(straight))
    bent = np.linalg.norm(motions[0.005].sensor("marker12")[::200] - deflections, axis=1).max()
    damping = {step: damping_ratio(plant) for step, plant in plants.items()}
    rows = []
    for step in (0.01, 0.005, 0.0025):
        plant = plants[step]
        (cost,) = costs(lambda: run_experiment(plant, EXPERIMENT))  # noqa: B023
        apart = np.linalg.norm(tip_at(motions[step], coarse) - tip_at(motions[step / 2], coarse), axis=1).max()
        added = 100 * (damping[step] - damping[0.00125])
        rows.append(
            f"| {1e3 * step:g} | {cost:.2f} | {EXPERIMENT.duration / cost:.0f} | {1e3 * apart:.2f} | "
            f"{100 * apart / bent:.2f} | {100 * damping[step]:.3f} | {added:+.3f} |"
        )
    return rows


def main() -> None:
    machine = load_machine(ROOT / "models" / "boom36.toml")
    parts = stages(machine)
    whole = dict(parts)["**whole command**"]
    loops = {hinges: loop_and_bare(machine, hinges) for hinges in (1, 2, 4)}
    reference, exudyn, apart = others(machine)
    loop, bare = loops[1]
    times = [
        ("inner loop, hinges 1", loop),
        ("bare mujoco.rollout, same model and steps", bare),
        ("whole replay command", whole),
        ("inner loop, hinges 4", loops[4][0]),
        (f"Exudyn, {apart * 1e3:.0f} mm rms from hinges 4 at the tip", exudyn),
        ("the paper, its authors' PC", PAPER),
        ("real time", EXPERIMENT.duration),
        ("reference model, scaled from 2 s", reference),
    ]
    filled = {
        "times": [
            f"| {name} | {cost:.2f} | {cost / loop:.2f} | {float(f'{EXPERIMENT.duration / cost:.3g}'):g} |"
            for name, cost in times
        ],
        "loops": [f"| {n} | {w:.2f} | {b:.2f} | {w / b:.2f} |" for n, (w, b) in loops.items()],
        "stages": [f"| {name} | {cost:.2f} |" for name, cost in parts],
        "written": [f"{parts[-1][1] / whole:.2f}"],
        "steps": step_rows(machine),
    }
    text = (ROOT / "docs" / "results" / "speed.md.in").read_text()
    for name, rows in filled.items():
        text = text.replace("{" + name + "}", "\n".join(rows))
    (ROOT / "docs" / "results" / "speed.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
