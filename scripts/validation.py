"""The slow comparisons of docs/results/validation.md, printed as its tables.

Run: .venv/bin/python scripts/validation.py [FOLDER OF LOGS]   (about 5 minutes on two cores)
"""

import sys
from pathlib import Path
from time import process_time

import numpy as np

from boom_mj.logs import read_mcap
from boom_mj.machine import load_machine
from boom_mj.reference import ReferenceModel, Simplifications, integrate
from boom_mj.replay import replay
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment
from boom_mj.simulation.agreement import FIGURES, compare_models, random_poses

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests" / "agree"))
from beam_fe import beam_model  # noqa: E402

MACHINE = load_machine(ROOT / "models" / "boom36.toml")
POSES = {"stretched": [0, 0, 0, 0, 0], "bow": [0, 60, -35, -40, -45], "T": [0, 85, -85, 0, 0]}  # deg
DOWN, SIDE = np.array([0.0, 0.0, -981.0]), np.array([0.0, 981.0, 0.0])


def against_the_reference() -> None:
    found = compare_models(MACHINE, 1, random_poses(MACHINE, 200, 0))
    print("| hinges 1, 200 poses, % | median | 95 % | worst | worst, finite rotations |\n|---|---|---|---|---|")
    for k, figure in enumerate(FIGURES):
        size, like = 100 * np.abs(found.paper[:, k]), 100 * np.abs(found.finite[:, k])
        row = (np.median(size), np.quantile(size, 0.95), size.max(), like.max())
        print(f"| {figure} | " + " | ".join(f"{value:.2f}" for value in row) + " |")
    print("\nworst mass matrix entries:", found.mass_entries)


def against_the_beam() -> None:
    """In the linear regime: a thousandth of weight and load."""
    small = 1e-3
    light = MACHINE.model_copy(update={"gravity": MACHINE.gravity * small})
    poses = {name: np.radians(angles) for name, angles in POSES.items()}
    poses.update({f"random {k}": pose for k, pose in enumerate(random_poses(MACHINE, 25, 1))})
    beams = {name: beam_model(MACHINE, pose) for name, pose in poses.items()}
    sizes = [np.linalg.norm(beams["stretched"].tip_displacement(*load)) for load in _loads()]
    print("\n| hinges | pose | weight, % | down, % | sideways, % | modes 1-6, % | modes 1-8, % |")
    print("|---|---|---|---|---|---|---|")
    for hinges in (1, 2, 3, 4, 6, 8):
        plant, free = make_plant(light, hinges), make_plant(MACHINE.model_copy(update={"gravity": 0.0}), hinges)
        rows = {}
        for name, pose in poses.items():
            straight = np.zeros(plant.model.nq)
            straight[plant.joints] = pose
            rest = plant.tip(plant.static_equilibrium(pose))
            moved = [rest - plant.tip(straight)]
            moved += [plant.tip(plant.static_equilibrium(pose, small * load)) - rest for load in (DOWN, SIDE)]
            true = [beams[name].tip_displacement(*load) for load in _loads()]
            size = [np.linalg.norm(t) for t in true] if name in POSES else sizes
            static = [100 * np.linalg.norm(m / small - t) / s for m, t, s in zip(moved, true, size)]
            modes = 100 * np.abs(free.modes(straight).frequency[:8] / beams[name].modes(8)[0] - 1)
            rows[name] = np.array([*static, modes[:6].max(), modes.max()])
        folded = np.max([row for name, row in rows.items() if name not in POSES], axis=0)
        for name, row in (*((name, rows[name]) for name in POSES), ("25 random, worst", folded)):
            print(f"| {hinges} | {name} | " + " | ".join(f"{value:.3f}" for value in row) + " |", flush=True)
    model = beam_model(MACHINE, np.zeros(5))
    print("beam, stretched: f", model.modes(6)[0].round(4), "cylinders", model.cylinder_forces().round(0))
    plant = make_plant(MACHINE, 4)
    rest = plant.static_equilibrium(np.zeros(5))
    print("hinges 4, stretched, under its weight: f", plant.modes(rest).frequency[:4].round(4))
    for load in (DOWN, SIDE):
        print("  tip under", load, plant.tip(plant.static_equilibrium(np.zeros(5), load)) - plant.tip(rest))


def cost() -> None:
    """The fold-in of 300 s: how far the tip is from that of twelve hinges, and the seconds it takes."""
    plan, tips, seconds = CATALOGUE["fold_in_300"], {}, {}
    for hinges in (12, 1, 2, 3, 4, 6, 8):
        started = process_time()
        tips[hinges] = run_experiment(make_plant(MACHINE, hinges), plan).sensor("marker12")
        seconds[hinges] = process_time() - started
    print("\n| hinges | tip off by at most, mm | CPU s |\n|---|---|---|")
    for hinges in sorted(tips):
        off = 1e3 * np.linalg.norm(tips[hinges] - tips[12], axis=1).max()
        print(f"| {hinges} | {off:.2f} | {seconds[hinges]:.2f} |")


def _loads() -> tuple:
    return ((np.zeros(3), True), (DOWN, False), (SIDE, False))


def release() -> None:
    """Tip of the stretched boom after the cut, hinges 1 against the reference."""
    cut = CATALOGUE["release_stretched_vertical"]
    found, time = run_experiment(make_plant(MACHINE, 1), cut), np.arange(7.9, 18.01, 0.02)
    tip = np.stack([np.interp(time, found.time, column) for column in found.sensor("marker12").T], axis=1)
    print("\n| reference | max over 10 s | over the first 2 s | f1, Hz | f1 MuJoCo, Hz |\n|---|---|---|---|---|")
    own = found.plant.modes(found.plant.static_equilibrium(np.zeros(5))).frequency[1]
    for name, simple in (("paper", Simplifications()), ("finite rotations", Simplifications(linear_kinematics=False))):
        model = ReferenceModel(MACHINE, simple)
        wanted = integrate(
            model,
            lambda t: tuple(part[0] for part in cut.joint_path(np.array([t]))),
            lambda t: cut.tip_force(np.array([t]))[0],
            time,
            1e-6,
        )
        rest = model.static_equilibrium(np.zeros(5))
        size = np.linalg.norm(model.tip(rest)[0] - wanted.tip[0])
        error = 100 * np.linalg.norm((tip - tip[0]) - (wanted.tip - wanted.tip[0]), axis=1) / size
        frequency = model.modes(rest).frequency[1]
        print(f"| {name} | {error.max():.2f} | {error[time < 10].max():.2f} | {frequency:.4f} | {own:.4f} |")


def logs(folder: Path) -> None:
    """Median and worst ratio to the noise per log and kind of sensor."""
    print("\n| log | hinges | accelerometers | gyros | markers | cylinders |\n|---|---|---|---|---|---|")
    for path in sorted(folder.rglob("*.mcap")):
        log = read_mcap(path)
        for hinges in (1, 3):
            groups = replay(make_plant(MACHINE, hinges), log).groups
            kinds = ("specific_force", "angular_rate", "markers", "cylinder")
            ratios = [[g.ratio for g in groups if kind in g.name] for kind in kinds]
            cells = " | ".join(f"{np.median(part):.2f} ({max(part):.2f})" for part in ratios)
            print(f"| {log.name} | {hinges} | {cells} |", flush=True)


if __name__ == "__main__":
    logs(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "logs")
    against_the_beam()
    cost()
    against_the_reference()
    release()
