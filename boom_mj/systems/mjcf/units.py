"""Channels in another unit, or of another sign, than a map says, as what the nominal model says of them shows."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import mujoco
import numpy as np

from boom_mj.errors import BoomError
from boom_mj.estimation.dataset import Dataset
from boom_mj.recording import UNITS, Recording
from boom_mj.replay.quality import Action, DataFinding
from boom_mj.replay.quality.kinds.unit import OFF, named_unit
from boom_mj.systems.mjcf.channel_map import ChannelEntry
from boom_mj.systems.mjcf.system import BASE, MjcfSystem

Array = np.ndarray
ALIKE = 0.9  # correlation of what is measured and what the nominal model says: four fifths of the variance are one


def unit_findings(system: MjcfSystem, data: Dataset) -> Iterator[DataFinding]:
    """Of every log: positions beyond what their joints can do, compared channels that are as many times too large as a
    unit is, or negative, and motion that fits its forces in another unit only.

    They are said, not mended: in a map that is right a machine may be so far off.
    """
    logs: dict[str, list[int]] = {}
    for index, log in enumerate(data.recordings):
        logs.setdefault(log.description, []).append(index)
    for path, indices in logs.items():
        first, last = data.recordings[indices[0]], data.recordings[indices[-1]]
        for entry, kind, text, factor in _wrong(system, data, indices):
            lasts = float(last[entry.name].time[-1] - first[entry.name].time[0])
            text += f": scale = {factor * entry.scale:.6g}"
            yield DataFinding(path, entry.name, kind, 0.0, lasts, text, Action.SAID, used=True)


def _wrong(system: MjcfSystem, data: Dataset, indices: list[int]) -> Iterator[tuple[ChannelEntry, str, str, float]]:
    """Channels of a log's stretches, what is wrong, in a word and in a sentence, and the factor that would mend it."""
    beyond, model = set(), system.spec.copy().compile()
    for entry in system.channels.channel:
        if wide := _beyond(model, entry, [data.recordings[k] for k in indices]):
            reach, limit, word, factor = wide
            beyond.add(entry.name)
            yield entry, "unit", f"reaches {reach:.4g}, its joint {limit:.4g} {entry.unit}, as if in {word}", factor
    found = _compared(system, data, indices)
    for entry in system.channels.role("compare"):
        alike, scale = found.get(entry.name, (0.0, 1.0))
        if abs(alike) > ALIKE and (unit := named_unit(entry.unit, scale)):
            text = f"is {scale:.4g} times what the model says, as if in {unit[0]} instead of {entry.unit or '1'}"
            yield entry, "unit", text, float(np.sign(alike)) * unit[1]
        elif alike < -ALIKE and 1 / OFF < scale < OFF:
            yield entry, "sign", "is the negative of what the model says", -1.0
    for entry in system.channels.role("drive") if not _fits(found) else ():
        for word, factor in UNITS.get(entry.unit, {}).items():
            if entry.name not in beyond and factor != 1 and _fits(_compared(system, data, indices, entry, factor)):
                yield entry, "unit", f"moves the model as its forces say if it is in {word}, not {entry.unit}", factor


def _compared(
    system: MjcfSystem, data: Dataset, indices: list[int], driving: ChannelEntry | None = None, factor: float = 1.0
) -> Mapping[str, tuple[float, float]]:
    """Correlation of compared channels with what the nominal model says, and by how many times they are larger.

    Args:
        driving: whose motion is taken `factor` times.
    """
    pairs: dict[str, list[Array]] = {}
    for index in indices:
        log = data.recordings[index]
        if driving is not None:
            motion = log[driving.name]
            log = log.with_signals({driving.name: replace(motion, values=factor * motion.values)})
        try:
            dense = system.simulate((), BASE, log)
        except BoomError:
            continue
        for channel in data.of(index):
            told = data.means(index, channel.signal, dense[channel.signal])
            pairs.setdefault(channel.signal, []).append(np.stack([channel.measured, told]))
    found = {}
    for name, parts in pairs.items():
        both = np.concatenate(parts, axis=1)
        both = both[:, np.isfinite(both).all(axis=0)]
        size = both.std(axis=1) if both.size else np.zeros(2)
        if size.all():
            found[name] = float(np.corrcoef(both)[0, 1]), float(size[0] / size[1])
    return found


def _beyond(
    model: mujoco.MjModel, entry: ChannelEntry, logs: Sequence[Recording]
) -> tuple[float, float, str, float] | None:
    """How far a position goes that no joint with such limits can have, they, and the unit in which it could."""
    if not (entry.joint and entry.sensed and entry.what == "position"):
        return None
    limit = float(np.abs(model.joint(entry.joint).range).max())
    reach = float(np.nanmax(np.abs(np.concatenate([log[entry.name].values for log in logs]))))
    for word, factor in UNITS.get(entry.unit, {}).items():
        if reach > OFF * limit > 0 and reach * factor < OFF * limit:
            return reach, limit, word, factor
    return None


def _fits(found: Mapping[str, tuple[float, float]]) -> bool:
    return any(alike > ALIKE and 1 / OFF < scale < OFF for alike, scale in found.values())
