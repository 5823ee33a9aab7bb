"""The experiments that everyone knows by name."""

from collections.abc import Mapping

from boom_mj.errors import ExperimentError
from boom_mj.mjcf import POSES_DEG
from boom_mj.simulation.experiments import Chirp, Experiment, Move, parse_experiment

STRETCHED, BOW, T_SHAPE = POSES_DEG["stretched"], POSES_DEG["bow"], (0.0, 85.0, -85.0, 0.0, 0.0)


def _release(name: str, pose: tuple, load: tuple, text: str) -> Experiment:
    return Experiment(name=name, description=text, pose_deg=pose, duration=30, load=load, release=8.0)


def _there_and_back(joint: int, start: float, angle: float, speed: float) -> tuple[Move, ...]:
    moves = []
    for turn in (angle, -2 * angle, angle):
        moves.append(Move(joint=joint, start=start, angle_deg=turn, speed_deg_s=speed, blend=0.8))
        start += moves[-1].duration
    return tuple(moves)


def _moves(rows: tuple[tuple[int, float, float, float, float], ...]) -> tuple[Move, ...]:
    return tuple(Move(joint=j, start=t, angle_deg=a, speed_deg_s=v, blend=b) for j, t, a, v, b in rows)


CATALOGUE: Mapping[str, Experiment] = {
    e.name: e
    for e in (
        _release("release_stretched_vertical", STRETCHED, (0, 0, -981), "stretched, 100 kg on a rope, cut at 8 s"),
        _release("release_stretched_horizontal", STRETCHED, (0, 981, 0), "stretched, 100 kg over a pulley, cut at 8 s"),
        _release("release_bow_vertical", BOW, (0, 0, -981), "bow pose, 100 kg on a rope, cut at 8 s"),
        _release("release_bow_horizontal", BOW, (0, 981, 0), "bow pose, 100 kg over a pulley, cut at 8 s"),
        _release("release_stretched_vertical_half", STRETCHED, (0, 0, -490.5), "stretched, 50 kg on a rope"),
        Experiment(
            name="slew_t",
            description="T pose, joint 1 moves 6 deg in 4 s and stops",
            pose_deg=T_SHAPE,
            duration=30,
            move=_moves(((1, 3.0, 6.0, 2.0, 1.0),)),
        ),
        Experiment(
            name="sweep",
            description="bow pose, joints 2 and 3 slowly +-5 deg with reversals, then slewing",
            pose_deg=BOW,
            duration=60,
            move=_there_and_back(2, 1.5, 5, 1) + _there_and_back(3, 20.5, 5, 1) + _there_and_back(1, 44, 5, 2),
        ),
        Experiment(
            name="fold_in",
            description="from the bow pose to the folded transport pose, then rest",
            pose_deg=BOW,
            duration=80,
            move=_moves(
                ((5, 1.5, -125, 4.8, 2.5), (4, 4, -130, 4.2, 2.5), (3, 11, -130, 2.9, 2.5), (2, 40, -25, 1.4, 2))
            ),
        ),
        Experiment(
            name="fold_in_300",
            description="the fold-in with long holds and one joint after the other, 300 s",
            pose_deg=BOW,
            duration=300,
            move=_moves(
                (
                    (1, 10, 20, 1.0, 2),
                    (5, 40, -60, 2.4, 2),
                    (4, 70, -60, 2.2, 2),
                    (5, 105, -65, 2.4, 2),
                    (4, 140, -70, 2.2, 2),
                    (3, 160, -130, 2.0, 2.5),
                    (1, 200, -20, 1.0, 2),
                    (2, 240, -25, 1.0, 2),
                )
            ),
        ),
        Experiment(
            name="mixed",
            description="stop-and-go moves of all joints, slewing included",
            pose_deg=(-4, 62, -50, -5, -15),
            duration=60,
            move=_moves(
                (
                    (1, 3, 8, 1.8, 1.7),
                    (5, 5, -24, 3, 1.6),
                    (2, 10, 7, 1, 1.6),
                    (3, 14, -10, 1.8, 1.8),
                    (4, 20, -16, 2.6, 1.8),
                    (1, 23.1, -6, 1.8, 1.7),
                    (5, 23.6, 16, 3, 1.6),
                    (2, 30.6, -5, 1, 1.6),
                    (3, 34.3, 6, 1.8, 1.8),
                    (4, 38.9, 10, 2.6, 1.8),
                    (5, 39.5, -12, 3, 1.6),
                )
            ),
        ),
        Experiment(
            name="chirp_joint2",
            description="stretched, joint 2 swings 0.1 deg from 0.1 to 1.1 Hz",
            pose_deg=STRETCHED,
            duration=30,
            chirp=(Chirp(joint=2, start=1, duration=27, amplitude_deg=0.1, frequencies_hz=(0.1, 1.1)),),
        ),
        Experiment(
            name="chirp_joint4",
            description="bow pose, joint 4 swings 0.3 deg from 0.1 to 1.3 Hz",
            pose_deg=BOW,
            duration=30,
            chirp=(Chirp(joint=4, start=1, duration=27, amplitude_deg=0.3, frequencies_hz=(0.1, 1.3)),),
        ),
        Experiment(
            name="slew_tour",
            description="bow pose, holds at slewing 0, 90 and 180 deg",
            pose_deg=BOW,
            duration=120,
            move=_moves(((1, 12, 90, 2.6, 2), (1, 62, 90, 2.6, 2))),
        ),
        Experiment(
            name="hold",
            description="bow pose, 60 s with 100 kg on a rope, 60 s without",
            pose_deg=BOW,
            duration=120,
            load=(0, 0, -981),
            release=60.0,
        ),
    )
}
"""Experiments by name."""


def load_experiment(name: str) -> Experiment:
    """An experiment by its name in the catalogue, or from a TOML file of one's own.

    Raises:
        ExperimentError: neither a known name nor a good file.
    """
    if name in CATALOGUE:
        return CATALOGUE[name]
    if not name.endswith(".toml"):
        raise ExperimentError(f"no experiment {name!r}; known: {', '.join(CATALOGUE)}; or a .toml file of your own")
    return parse_experiment(name)
