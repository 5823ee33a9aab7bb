"""Machines that exist, measured by others: what is named, and whether it agrees with what is known of them another way.

    python scripts/real_machines.py DATA [-o TABLE.md] [--keep FILE.jsonl] [--jobs N] [--sets NAME ...]

DATA is the folder of the recordings, with one folder a machine; docs/results/machines.md says where they come from. The
quick ones are tests as well (tests/recover/test_real_machines.py). Answers are kept line by line in FILE.jsonl with the
commit that gave them, and a second call goes on.
"""

import argparse
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from gap_cases import brief
from healthy_first import all_rows

from boom_mj.diagnosis import diagnose, document
from boom_mj.files import write_text
from boom_mj.systems.mjcf import load_mjcf
from boom_mj.systems.predictor import Predictor

ROOT = Path(__file__).parents[1]
MAPS = ROOT / "models" / "real"
Answer = dict[str, Any]
HEAD = "| set | known | verdict | named | gap held out | agrees | not | CPU s | commit |"


@dataclass(frozen=True)
class RealMachine:
    """Recordings of a machine and what is known of it.

    Attributes:
        name: of its channel map in models/real.
        train, held_out: paths of recordings below the data folder; without any held out their last parts are.
        known: from another source.
        checks: by what they ask whether an answer agrees with what is known.
        quick: whether a diagnosis takes but a minute of CPU time.
    """

    name: str
    train: tuple[str, ...]
    held_out: tuple[str, ...]
    known: str
    checks: Callable[[Answer], dict[str, bool]]
    quick: bool = False

    @property
    def map(self) -> Path:
        return MAPS / f"{self.name}.toml"

    @property
    def number(self) -> int:
        """Among all, by which its answer is kept."""
        return [one.name for one in MACHINES].index(self.name)

    def missing(self, data: Path) -> list[str]:
        """Recordings that are not below a folder."""
        return [path for path in (*self.train, *self.held_out) if not (data / path).exists()]

    def answer(self, data: Path) -> Answer:
        """Of the diagnosis of its recordings."""
        logs, held_out = ([data / path for path in paths] for paths in (self.train, self.held_out))
        given = load_mjcf(logs, held_out, self.map)
        found = diagnose(Predictor(given.system, given.data))
        return document(found, given.names, given.findings)


def sizes(answer: Answer, name: str, **location: str) -> dict[str, dict[str, float]]:
    """Parameters of a named effect; none where it is not named."""
    effects = (e["parameters"] for e in answer["effects"] if e["id"] == name and e["location"] == location)
    return next(effects, {})


def holds(size: dict[str, float] | None, known: float, within: float = np.inf) -> bool:
    """Whether a size's interval holds what is known, from which it differs by a share of that at most."""
    return bool(size and size["low"] < known < size["high"] and abs(size["value"] / known - 1) <= within)


def rubs(effect: dict[str, Any], joint: str) -> bool:
    return bool(effect["location"] == {"joint": joint} and effect["id"].endswith("friction"))


def left(answer: Answer) -> float:
    return float(answer["gap"]["holdout"]["after"] / answer["gap"]["holdout"]["before"])


def emps(answer: Answer) -> dict[str, bool]:
    """Janot, Gautier, Brunot 2019."""
    friction = sizes(answer, "directional_friction", joint="slide")
    force = answer["gap"]["holdout"]["after"] * 0.2515 / 52.4  # noise of a block and rms of what is held out, N
    return {
        "partial": answer["verdict"] == "partial",
        "167 N s/m forward": holds(friction.get("forward"), 167.0, 0.06),
        "240 N s/m backward": holds(friction.get("backward"), 240.0, 0.06),
        "20 N dry": holds(friction.get("force"), 20.0, 0.06),
        "2.6 % of the force left": force < 0.026,
    }


def so101(answer: Answer) -> dict[str, bool]:
    rubbing = {effect["location"].get("joint") for effect in answer["effects"] if effect["id"].endswith("friction")}
    return {
        "elbow, pitch, wrist pitch rub": {"elbow", "pitch", "wrist_pitch"} <= rubbing,
        "half of the 29 of 93 left": left(answer) < 0.5 * 29 / 93,  # that were left when three joints were named
    }


def damper(answer: Answer) -> dict[str, bool]:
    """By eye at reversals."""
    play = sizes(answer, "friction_behind_play", joint="slide")
    return {
        "play of 3 to 4 mm": bool(play) and 3e-3 < 2 * play["half_gap"]["value"] < 4e-3,
        "6 kN/mm": holds(play.get("stiffness"), 6e6),
        "0.45 left": left(answer) < 0.45,
    }


def pendulum(answer: Answer) -> dict[str, bool]:
    """From its owners' rig."""
    friction = [effect for effect in answer["effects"] if rubs(effect, "shaft")]
    return {
        "friction alone": len(friction) == len(answer["effects"]) == 1,
        "0.184 N m dry": bool(friction) and holds(friction[0]["parameters"].get("force"), 0.184),
    }


def beam(answer: Answer) -> dict[str, bool]:
    """Of its owners' Young's modulus the tone tells the ratio to the density alone; what relaxes damps, too."""
    damping = sizes(answer, "link_damping", link="beam").get("relaxation_time")
    spring = [effect for effect in answer["effects"] if effect["id"] in ("link_stiffness", "link_density")]
    others = {effect["id"] for effect in answer["effects"]} - {"link_damping", "relaxing_stiffness"}
    return {
        "damped by 2 to 4 ms": bool(damping) and 2e-3 < damping["value"] < 4e-3 and damping["low"] > 1e-3,
        "as stiff as published": all(abs(one["parameters"]["factor"]["value"] - 1) < 0.03 for one in spring),
        "nothing else": others <= {one["id"] for one in spring},
        "falls silent the same way": answer["gap"]["holdout"]["after"] < 2,
    }


def flexible_joint(answer: Answer) -> dict[str, bool]:
    """Steady speeds of `scope_data_deadzone_pos.mat`, by whatever form of friction and however strong the motor is.

    Beside which these sizes are the best, be that sure or a suspect.
    """
    at_hub = [effect for effect in answer["effects"] if effect["location"] == {"joint": "hub"}]
    hub = [effect for effect in at_hub if rubs(effect, "hub")]
    beside = {"effects": [*answer["effects"], *answer["suspect"]]}
    gain = sizes(beside, "actuator_gain", actuator="motor").get("factor", {"value": 1.0})["value"]

    def voltage(speed: float) -> float:
        total = 0.87 * speed  # of the nominal model
        for effect in hub:
            size = {name: one["value"] for name, one in effect["parameters"].items()}
            total += size.get("force", 0.0) + size.get("forward", size.get("damping", 0.0)) * speed
            total += size.get("excess", 0.0) * np.exp(-((speed / size.get("speed", 1.0)) ** 2))
        return float(total / gain)

    known = {0.445: 0.45, 1.628: 1.1}  # V, of speeds in rad/s
    right = {f"{v} V at {speed} rad/s": bool(hub) and abs(voltage(speed) / v - 1) < 0.1 for speed, v in known.items()}
    return {"nothing but friction at the hub": all(rubs(effect, "hub") for effect in at_hub), **right}


MACHINES = (
    RealMachine("emps", ("emps/DATA_EMPS.mat",), (), "167 and 240 N s/m by direction, 20 N dry", emps, quick=True),
    RealMachine(
        "clamped_beam",
        ("clamped_beam/beam_gravity_V2_a.csv.gz",),
        ("clamped_beam/beam_gravity_V2_b.csv.gz",),
        "Young's modulus within 3 %; another release falls silent the same way",
        beam,
        quick=True,
    ),
    RealMachine(
        "friction_damper",
        ("friction_damper/sine_1Hz_25lb.csv",),
        ("friction_damper/sine_0.5Hz_25lb.csv",),
        "play of 3 to 4 mm, about 6 kN/mm to and from it",
        damper,
    ),
    RealMachine(
        "simple_pendulum",
        ("simple_pendulum/energy_shaping.csv", "simple_pendulum/ddp.csv"),
        ("simple_pendulum/sac.csv", "simple_pendulum/direct_collocation.csv"),
        "0.184 N m dry; what acts beside it the data do not tell",
        pendulum,
    ),
    RealMachine(
        "so101",
        ("so101/friction_gravity/state_motor.csv.gz",),
        ("so101/step_response/state_motor.csv.gz",),
        "elbow and pitch stick",
        so101,
    ),
    RealMachine(
        "flexible_joint",
        ("flexible_joint/scope_data_PRBS.mat", "flexible_joint/scope_data_deadzone_pos.mat"),
        ("flexible_joint/scope_data_square.mat",),
        "0.45 V at 0.445 rad/s, 1.1 V at 1.628 rad/s",
        flexible_joint,
    ),
)


def tried(machine: RealMachine, data: Path, commit: str) -> dict[str, Any]:
    """Its answer as it is kept."""
    began = time.process_time()
    answer = machine.answer(data)
    return {"number": machine.number, "commit": commit, "cpu_s": time.process_time() - began, "answer": answer}


def row(machine: RealMachine, kept: Answer) -> str:
    """Of the table."""
    answer, asked = kept["answer"], machine.checks(kept["answer"])
    held_out = answer["gap"]["holdout"]
    said = (", ".join(name for name, so in asked.items() if so is wanted) or "-" for wanted in (True, False))
    cells = [machine.name, machine.known, answer["verdict"], brief(answer["effects"], "parameters")]
    cells += [f"{held_out['before']:.1f} -> {held_out['after']:.1f}", *said, f"{kept['cpu_s']:.0f}", kept["commit"][:7]]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Diagnose what is not kept, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("-o", type=Path)
    parser.add_argument("--keep", type=Path, default=Path("out/real_machines.jsonl"))
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--sets", nargs="+", choices=[one.name for one in MACHINES])
    given = parser.parse_args()
    asked = [one for one in MACHINES if given.sets is None or one.name in given.sets]
    for one in asked:
        if missing := one.missing(given.data):
            parser.error(f"{one.name}: {', '.join(missing)} not in {given.data}; --sets names those to be asked")
    commit = subprocess.check_output(["git", "rev-parse", "HEAD"], cwd=ROOT, text=True).strip()
    given.keep.parent.mkdir(parents=True, exist_ok=True)
    work = partial(tried, data=given.data, commit=commit)
    rows = {one["number"]: one for one in all_rows(work, asked, given.keep, given.jobs)}
    table = [HEAD, "|---" * HEAD.count(" | ") + "|---|"]
    table += [row(machine, rows[machine.number]) for machine in asked]
    print("\n".join(table))
    if given.o:
        write_text(given.o, "\n".join(table) + "\n")


if __name__ == "__main__":
    main()
