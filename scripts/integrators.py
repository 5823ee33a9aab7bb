"""Which integrator, step and drive: accuracy, damping added, cost. Writes docs/explanation/integrators.md.

Run: .venv/bin/python scripts/integrators.py   (about 3 minutes on one core)
"""

import time
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from boom_mj.errors import SimulationError
from boom_mj.machine import Machine, load_machine
from boom_mj.simulation import CATALOGUE, Plant, make_plant, run_experiment
from boom_mj.simulation import simulate as simulation

ROOT = Path(__file__).parents[1]
INTEGRATORS = ("EULER", "IMPLICITFAST", "IMPLICIT", "DISCRETE", "RK4")
STEPS = (0.01, 0.005, 0.002, 0.001)


def tip_path(plant: Plant, name: str) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Times, tip positions, wall seconds and worst tracking error (deg) of an experiment."""
    began = time.perf_counter()
    found = run_experiment(plant, CATALOGUE[name])
    wall = time.perf_counter() - began
    wanted = CATALOGUE[name].joint_path(found.time)[0]
    return found.time, found.sensor("marker12"), wall, float(np.degrees(np.abs(found.joints - wanted).max()))


def with_option(plant: Plant, integrator: str, step: float) -> Plant:
    spec = plant.boom.spec.copy()
    spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
    spec.option.timestep = step
    boom = replace(plant.boom, spec=spec)
    return Plant(boom, spec.compile())


def added_damping(machine: Machine, hinges: int, integrator: str, step: float) -> float:
    """Damping ratio of the first vertical mode in a boom without damping, 1 - its peaks' decay, percent."""
    free = machine.model_copy(update={"damping": machine.damping.model_copy(update={"relaxation_time": 0.0})})
    path = tip_path(with_option(make_plant(free, hinges), integrator, step), "release_stretched_vertical")
    when, height = path[0], path[1][:, 2]
    first, last = (np.ptp(height[(when > a) & (when < a + 4)]) for a in (9, 25))
    return 100 * float(np.log(first / last)) / (2 * np.pi * 0.5 * 16)


def table(machine: Machine, hinges: int, name: str) -> list[str]:
    plant = make_plant(machine, hinges)
    when, fine, _, _ = tip_path(with_option(plant, "IMPLICITFAST", 0.0001), name)
    size = np.ptp(fine, axis=0).max()

    def damping(integrator: str, step: float) -> str:
        try:
            return f"{added_damping(machine, hinges, integrator, step):.3f}"
        except SimulationError:
            return "unstable"

    rows = []
    for integrator in INTEGRATORS:
        for step in STEPS:
            label = f"| {hinges} | {integrator.lower()} | {1000 * step:g} |"
            try:
                t, tip, wall, tracking = tip_path(with_option(plant, integrator, step), name)
                exact = np.stack([np.interp(t, when, column) for column in fine.T], axis=1)
                error = 100 * np.abs(tip - exact).max() / size
                rows.append(
                    f"{label} {error:.3f} | {damping(integrator, step)} | {tracking:.1e} | {t[-1] / wall:.0f} |"
                )
            except SimulationError:
                rows.append(f"{label} unstable | | | |")
            print(rows[-1], flush=True)
    return rows


def drives(machine: Machine) -> list[str]:
    """The same motion with drives of other armature and servo frequency."""
    rows, kept = [], (simulation.ARMATURE, simulation.SERVO)
    for armature, frequency in ((1e7, 2.0), (1e9, 2.0), (1e11, 0.5), (1e11, 2.0), (1e11, 8.0), (1e13, 2.0)):
        simulation.ARMATURE, simulation.SERVO = armature, 2 * np.pi * frequency
        found = run_experiment(make_plant(machine, 1), CATALOGUE["mixed"])
        wanted = CATALOGUE["mixed"].joint_path(found.time)[0]
        error = np.degrees(np.abs(found.joints - wanted).max())
        noise = np.std(np.diff(found.joint_torque[:200], axis=0), axis=0).max()
        rows.append(f"| {armature:.0e} | {frequency:g} | {error:.1e} | {noise:.1e} |")
    simulation.ARMATURE, simulation.SERVO = kept
    return rows


def main() -> None:
    machine = load_machine(ROOT / "models" / "boom36.toml")
    rows = [row for hinges in (1, 4) for row in table(machine, hinges, "release_stretched_vertical")]
    text = (ROOT / "docs" / "explanation" / "integrators.md.in").read_text()
    text = text.replace("{integrators}", "\n".join(rows)).replace("{drives}", "\n".join(drives(machine)))
    (ROOT / "docs" / "explanation" / "integrators.md").write_text(text)
    print(f"wrote {ROOT / 'docs' / 'explanation' / 'integrators.md'}")


if __name__ == "__main__":
    main()
