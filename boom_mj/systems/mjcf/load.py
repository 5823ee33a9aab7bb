"""From files to an MJCF machine and its recordings."""

from collections.abc import Sequence
from pathlib import Path

from boom_mj.errors import InputError
from boom_mj.files import inside
from boom_mj.systems.mjcf.channel_map import load_channel_map
from boom_mj.systems.mjcf.log_table import read_table
from boom_mj.systems.mjcf.model_file import load_model
from boom_mj.systems.mjcf.segments import noise_of, split, stretches_of
from boom_mj.systems.mjcf.system import MjcfSystem
from boom_mj.systems.mjcf.units import unit_findings
from boom_mj.systems.predictor import dataset_of
from boom_mj.systems.recorded import RecordedMachine

MOST_STEPS = 10**6  # of a stretch


def load_mjcf(
    logs: Sequence[Path], held_out: Sequence[Path], map_file: Path, model_file: Path | None = None
) -> RecordedMachine[MjcfSystem]:
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
    tables = [read_table(log, channels) for log in logs]
    judges = [read_table(log, channels) for log in held_out]
    train, judged = [], []
    for table in tables:
        found = stretches_of(table)
        first = len(found) if held_out else split(found, channels.train)
        train += found[:first]
        judged += found[first:]
    for table in judges:
        judged += stretches_of(table)
    system = MjcfSystem(spec, channels, train, noise_of(tables[0]))
    data = dataset_of(system, [*train, *judged], len(train))
    findings = dict.fromkeys(finding for table in (*tables, *judges) for finding in table.findings)
    findings |= dict.fromkeys(unit_findings(system, data))
    return RecordedMachine(system, data, tuple(log.name for log in data.recordings), tuple(findings))
