"""Changes of a recording; each is a function of a recording that leaves its argument as it is."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import reduce

import numpy as np

from boom_mj.recording import Recording, Signal

Array = np.ndarray
Edit = Callable[[Recording], Recording]
DRIVE, COMMAND = "joint/position", "joint_command/position"  # joint angles drive the model and have no holes


def unchanged(recording: Recording) -> Recording:
    return recording


def together(edits: Sequence[Edit]) -> Edit:
    """One after the other."""
    return lambda recording: reduce(lambda done, edit: edit(done), edits, recording)


def blanked(name: str, bad: Array) -> Edit:
    """Without the samples where `bad` (n, k) is: NaN; joint angles are bridged, along a command if there is one."""

    def edit(recording: Recording) -> Recording:
        signal = recording[name]
        if name == DRIVE:
            return recording.with_signals({name: replace(signal, values=_bridged(recording, bad))})
        values = np.where(bad, np.nan, signal.values)
        if np.isnan(values).all():
            return dropped(name)(recording)
        return recording.with_signals({name: replace(signal, values=values)})

    return edit


def _bridged(recording: Recording, bad: Array) -> Array:
    joints = recording[DRIVE]
    command = _commanded(recording, joints)
    beyond = joints.values - command
    for column in range(beyond.shape[1]):
        good = ~bad[:, column]
        if good.any():
            beyond[:, column] = np.interp(joints.time, joints.time[good], beyond[good, column])
        elif COMMAND in recording:
            beyond[:, column] = 0.0
    return np.where(bad, command + beyond, joints.values)


def _commanded(recording: Recording, joints: Signal) -> Array:
    if COMMAND not in recording:
        return np.zeros_like(joints.values)
    command = recording[COMMAND]
    return np.stack([np.interp(joints.time, command.time, column) for column in command.values.T], axis=1)


def dropped(name: str) -> Edit:
    """Without a signal."""

    def edit(recording: Recording) -> Recording:
        return replace(recording, signals={k: v for k, v in recording.signals.items() if k != name})

    return edit


def mapped(name: str, factor: Array, offset: Array) -> Edit:
    """With factor * value + offset, (k,) both."""

    def edit(recording: Recording) -> Recording:
        signal = recording[name]
        return recording.with_signals({name: replace(signal, values=signal.values * factor + offset)})

    return edit


def rearranged(sources: Mapping[str, str]) -> Edit:
    """Signals that take each other's places: name -> the one whose samples it takes."""

    def edit(recording: Recording) -> Recording:
        found = {name: replace(recording[source], frame=recording[name].frame) for name, source in sources.items()}
        return recording.with_signals(found)

    return edit


def reordered(name: str, order: Sequence[int]) -> Edit:
    """Channels that take each other's places: `order[k]` is the column whose samples channel k takes."""

    def edit(recording: Recording) -> Recording:
        signal = recording[name]
        return recording.with_signals({name: replace(signal, values=signal.values[:, list(order)])})

    return edit


def restamped(names: Sequence[str], stamps: Callable[[Array], Array]) -> Edit:
    """With other times, a function of those that were."""

    def edit(recording: Recording) -> Recording:
        return recording.with_signals({n: replace(recording[n], time=stamps(recording[n].time)) for n in names})

    return edit
