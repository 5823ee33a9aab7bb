"""From files to a campaign of an MJCF machine, and from its diagnosis to a corrected file."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from boom_mj.diagnosis.diagnose import Diagnosis
from boom_mj.errors import InputError
from boom_mj.files import inside
from boom_mj.recording import Recording
from boom_mj.systems.mjcf.channel_map import load_channel_map
from boom_mj.systems.mjcf.model_file import load_model
from boom_mj.systems.mjcf.segments import noise_of, split, stretches_of
from boom_mj.systems.mjcf.system import MjcfSystem
from boom_mj.systems.predictor import Campaign

MOST_STEPS = 10**6  # of a stretch


def robot_campaign(
    logs: Sequence[Path], held_out: Sequence[Path], map_file: Path, model_file: Path | None = None
) -> Campaign:
    """A campaign of an MJCF machine: logs to learn from, logs to judge by; without any, a log's end is held out.

    Raises:
        InputError: no model, or one that MuJoCo does not take.
    """
    channels = load_channel_map(map_file)
    if model_file is None and not channels.model:
        raise InputError(f"{map_file} names no model; say which with --model")
    path = model_file or inside(map_file.parent, channels.model, InputError, map_file)
    spec = load_model(path)
    if channels.window > MOST_STEPS * spec.option.timestep:
        step, window = spec.option.timestep, channels.window
        raise InputError(f"{map_file}: a window of {window} s is too long for steps of {step} s, those of {path}")
    learnt, judged = [], []
    for log in logs:
        found = stretches_of(log, channels)
        first = len(found) if held_out else split(found, channels.train)
        learnt += found[:first]
        judged += found[first:]
    for log in held_out:
        judged += stretches_of(log, channels)
    robot = MjcfSystem(spec, channels, learnt, noise_of(logs[0], channels))
    return Campaign(robot, [*learnt, *judged], len(learnt))


def corrected_model(found: Diagnosis) -> str:
    """MJCF text with the best explanation's effects in it."""
    robot = found.metric.campaign.subject
    assert isinstance(robot, MjcfSystem)
    return robot.corrected(found.best.fit.effects if found.best else ())


def twin_tables(campaign: Campaign, twins: Sequence[Mapping[str, np.ndarray]]) -> dict[str, dict[str, np.ndarray]]:
    """Twins of all stretches as one table per log, by its path: time, and channels by name and unit, as compared."""
    logs: dict[str, list[tuple[Recording, Mapping[str, np.ndarray]]]] = {}
    for log, twin in zip(campaign.recordings, twins):
        logs.setdefault(log.description, []).append((log, twin))
    return {
        path: {
            "time [s]": np.concatenate([log[next(iter(twin))].time for log, twin in parts]),
            **{
                f"{name} [{parts[0][0][name].unit}]": np.concatenate([twin[name][:, 0] for _, twin in parts])
                for name in parts[0][1]
            },
        }
        for path, parts in logs.items()
    }
