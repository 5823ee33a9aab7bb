"""From files to an MJCF machine and its dataset."""

from collections.abc import Sequence
from pathlib import Path

from boom_mj.errors import InputError
from boom_mj.estimation.dataset import Dataset
from boom_mj.files import inside
from boom_mj.systems.mjcf.channel_map import load_channel_map
from boom_mj.systems.mjcf.model_file import load_model
from boom_mj.systems.mjcf.segments import noise_of, split, stretches_of
from boom_mj.systems.mjcf.system import MjcfSystem
from boom_mj.systems.predictor import dataset_of

MOST_STEPS = 10**6  # of a stretch


def load_mjcf(
    logs: Sequence[Path], held_out: Sequence[Path], map_file: Path, model_file: Path | None = None
) -> tuple[MjcfSystem, Dataset]:
    """An MJCF machine, with logs to learn from and logs to judge by; without any, a log's end is held out.

    Raises:
        InputError: no model, or one that MuJoCo does not take.
    """
    channels = load_channel_map(map_file)
    if model_file is None and not channels.model:
        raise InputError(f"{map_file} names no model; say which with --model")
    path = model_file or inside(map_file.parent, channels.model, InputError, map_file)
    spec = load_model(path)
    window, step = channels.settle + channels.window, spec.option.timestep
    if window > MOST_STEPS * step:
        raise InputError(f"{map_file}: a window of {window} s is too long for steps of {step} s, those of {path}")
    train, judged = [], []
    for log in logs:
        found = stretches_of(log, channels)
        first = len(found) if held_out else split(found, channels.train)
        train += found[:first]
        judged += found[first:]
    for log in held_out:
        judged += stretches_of(log, channels)
    system = MjcfSystem(spec, channels, train, noise_of(logs[0], channels))
    return system, dataset_of(system, [*train, *judged], len(train))
