"""Experiments drawn at random: poses, moves and holds within a machine's limits, after a rope that may be cut."""

import numpy as np

from boom_mj.errors import ExperimentError
from boom_mj.machine import Machine
from boom_mj.simulation import Experiment
from boom_mj.simulation.experiments import Chirp, Move

Rng = np.random.Generator
NAME = "designed"
REST, SWING = 2.0, 8.0  # s: before anything moves and in the end; from a cut rope to the first move
SPEED, BLEND, HOLD = (0.2, 1.0), (0.8, 2.0), (0.5, 5.0)  # of a joint's fastest; s
TURN, FASTER = 15.0, 0.3  # deg, share: by which an experiment is varied
WAYS = ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0))  # of a rope on the tip
MOST_JOINTS = 3  # that move at a time
TRIES = 20
CHIRPS, CHIRP, FREQUENCY, SWINGS = 0.5, 20.0, (0.3, 1.5), 0.5  # share with one; s; Hz; of a joint's fastest


def drawn(machine: Machine, seconds: float, load: float, rng: Rng) -> Experiment:
    """Joints move from pose to pose, up to three at a time, and rest in between.

    Args:
        seconds: that it lasts.
        load: N, that a rope may pull with before it is cut; 0 for none.
    """
    pose = [_number(rng, *drive.range_deg) for drive in machine.drives]
    cut = load > 0 and seconds > REST + SWING and rng.random() < 0.5
    now, moves, angles = REST + SWING * cut, list[Move](), list(pose)
    while now < seconds - REST:
        ends = [now]
        for k in rng.choice(len(angles), rng.integers(1, MOST_JOINTS + 1), replace=False):
            drive = machine.drives[k]
            target = _number(rng, *drive.range_deg)
            speed = _number(rng, *(share * drive.max_speed_deg_s for share in SPEED))
            move = Move(joint=k + 1, start=round(now, 1), angle_deg=round(target - angles[k], 1), speed_deg_s=speed)
            if move.angle_deg and speed and move.start + move.duration < seconds - REST:
                moves.append(move.model_copy(update={"blend": _number(rng, *BLEND)}))
                angles[k], ends = target, [*ends, move.start + moves[-1].duration]
        now = max(ends) + _number(rng, *HOLD)
    swing = _chirp(machine, seconds, rng) if rng.random() < CHIRPS else ()
    pull = tuple(load * x for x in WAYS[rng.integers(len(WAYS))]) if cut else (0.0, 0.0, 0.0)
    what = {"pose_deg": pose, "duration": seconds, "load": pull, "release": REST if cut else None}
    return Experiment.model_validate({"name": NAME, **what, "move": moves, "chirp": swing})


def _chirp(machine: Machine, seconds: float, rng: Rng) -> tuple[Chirp, ...]:
    """One joint swings as well, as fast as it may at the highest frequency."""
    joint = int(rng.integers(1, 1 + len(machine.drives)))
    high = _number(rng, *FREQUENCY)
    amplitude = round(SWINGS * machine.drives[joint - 1].max_speed_deg_s / (2 * np.pi * high), 2)
    length = round(min(seconds / 2, CHIRP), 1)
    start = round(float(rng.uniform(REST, seconds - REST - length)), 1)
    return (Chirp(joint=joint, start=start, duration=length, amplitude_deg=amplitude, frequencies_hz=(0.1, high)),)


def varied(experiment: Experiment, machine: Machine, rng: Rng) -> Experiment:
    """One number of an experiment otherwise, or one move less; itself where nothing fits within the limits."""
    for _ in range(TRIES):
        moves, pose = list(experiment.move), list(experiment.pose_deg)
        what = int(rng.integers(4))
        if what == 0 or not moves:
            joint = rng.integers(len(pose))
            pose[joint] = round(pose[joint] + TURN * rng.normal(), 1)
        else:
            k = int(rng.integers(len(moves)))
            angle = round(moves[k].angle_deg + TURN * rng.normal(), 1)
            speed = round(moves[k].speed_deg_s * (1 + FASTER * rng.normal()), 1)
            change = {1: {"angle_deg": angle}, 2: {"speed_deg_s": max(speed, 0.1)}}
            moves[k : k + 1] = [moves[k].model_copy(update=change[what])] if what in change else []
        update = {"name": NAME, "description": "", "pose_deg": tuple(pose), "move": tuple(moves)}
        found = experiment.model_copy(update=update)
        if fits(found, machine):
            return found
    return experiment


def fits(experiment: Experiment, machine: Machine) -> bool:
    """Whether a machine can follow, and no move of a joint begins before its last has ended, or ends too late."""
    free = dict.fromkeys(range(1, 1 + len(machine.drives)), 0.0)
    for move in experiment.move:
        end = move.start + move.duration
        if move.start < free[move.joint] or end > experiment.duration:
            return False
        free[move.joint] = end
    try:
        experiment.check(machine)
    except ExperimentError:
        return False
    return True


def as_toml(experiment: Experiment) -> str:
    """The file that `simulate` runs."""
    text = f'description = "{experiment.description}"\npose_deg = {list(experiment.pose_deg)}\n'
    text += f"duration = {experiment.duration}\n"
    if experiment.release is not None:
        text += f"load = {list(experiment.load)}  # N on the tip, world frame, by a rope\n"
        text += f"release = {experiment.release}  # s, when it is cut\n"
    for kind, motions in (("move", experiment.move), ("chirp", experiment.chirp)):
        for motion in motions:
            rows = (f"{key} = {_toml(value)}\n" for key, value in motion.model_dump().items())
            text += f"\n[[{kind}]]\n{''.join(rows)}"
    return text


def _toml(value: object) -> object:
    return list(value) if isinstance(value, tuple) else value


def _number(rng: Rng, low: float, high: float) -> float:
    """In tenths: people read it."""
    return round(float(rng.uniform(low, high)), 1)
