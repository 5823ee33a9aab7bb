"""Simulated over wall seconds on one core, and `simulate` against a bare rollout of the same model, steps and controls.

Run: .venv/bin/python benchmarks/speed.py
"""

import time
from pathlib import Path

import mujoco
import numpy as np
from mujoco import rollout

from boom_mj.machine import load_machine
from boom_mj.simulation import CATALOGUE, driven_model, make_plant, run, step_times

ROOT = Path(__file__).parents[1]
REPEATS = 5


def best(work) -> float:  # type: ignore[no-untyped-def]
    """Shortest of a few runs, s."""
    walls = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        work()
        walls.append(time.perf_counter() - began)
    return min(walls)


def main() -> None:
    machine, experiment = load_machine(ROOT / "models" / "boom36.toml"), CATALOGUE["fold_in_300"]
    print(
        "| hinges | steps | simulate, s | simulated s per s | bare rollout, s | simulate / bare | without sensors, s |"
    )
    print("|---|---|---|---|---|---|---|")
    for hinges in (1, 2, 4):
        plant = make_plant(machine, hinges)
        steps = step_times(plant, experiment.duration)
        angles, force = experiment.joint_path(steps)[0], experiment.tip_force(steps)
        model = driven_model(plant)
        data, start = mujoco.MjData(model), plant.static_equilibrium(angles[0])
        data.qpos[:] = start
        state = np.zeros(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
        mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        control = np.zeros((1, len(steps), model.nu))
        control[0, :, [model.actuator(f"drive{k + 1}").id for k in range(5)]] = angles.T
        silent = plant.boom.spec.copy()
        for sensor in list(silent.sensors):
            silent.delete(sensor)
        quiet = silent.compile()
        quiet.dof_armature[:], quiet.actuator_gainprm[:] = model.dof_armature, model.actuator_gainprm
        quiet.actuator_biasprm[:], quiet.actuator_ctrllimited[:] = model.actuator_biasprm, False
        whole = best(lambda: run(plant, angles, force))  # noqa: B023
        bare = best(lambda: rollout.rollout(model, data, state, control))  # noqa: B023
        mute = best(lambda: rollout.rollout(quiet, mujoco.MjData(quiet), state, control))  # noqa: B023
        row = (hinges, len(steps), f"{whole:.2f}", f"{steps[-1] / whole:.0f}", f"{bare:.2f}", f"{whole / bare:.2f}")
        print("| " + " | ".join(map(str, row)) + f" | {mute:.2f} |", flush=True)


if __name__ == "__main__":
    main()
