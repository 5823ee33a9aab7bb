"""Sensors that say the same again and again."""

from collections.abc import Iterator

import numpy as np

from boom_mj.recording import Recording
from boom_mj.replay.quality.channels import limits, own_noise, resolution, runs, shortest_run
from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.edits import COMMAND, DRIVE, blanked, together
from boom_mj.replay.quality.evidence import Evidence, sensor_of
from boom_mj.replay.quality.finding import Action

Array = np.ndarray
COARSE = 2.0  # times the noise: in steps as wide a channel repeats itself in good health
STILL = 5.0  # times the noise, by which a command must move for a joint that rests to be wrong


class Constant(Check):
    """Samples that are equal in a row longer than the sensor's own noise allows with CHANCE: dead, or stuck.

    Not samples at the end of a range (`Saturated`), nor those of a coarse converter (`Quantised`).
    """

    kind = "constant"
    turn = Turn.DEAD

    def look(self, evidence: Evidence) -> Iterator[Found]:
        coarse = _coarsest(evidence)
        for index in evidence.indices:
            log = evidence.recordings[index]
            bad: dict[str, Array] = {}
            for name in evidence.measured(index):
                found = self._bad(evidence, index, name, coarse)
                if found.any():
                    bad[name] = found
            for name, where in bad.items():
                pair = [n for n in bad if sensor_of(n) == sensor_of(name)]
                whole = name.startswith("imu/") and len(pair) == 2 and all(_alike(bad[n]) for n in pair)
                if whole and all(np.array_equal(bad[n].all(axis=1), where.all(axis=1)) for n in pair):
                    if name == pair[0]:
                        edit = together([blanked(n, bad[n]) for n in pair])
                        yield self._found(evidence, index, sensor_of(name), name, where[:, 0], edit)
                elif len(where.T) > 1 and _alike(where) and name != DRIVE:
                    yield self._found(evidence, index, name, name, where[:, 0], blanked(name, where))
                else:
                    for column in map(int, np.flatnonzero(where.any(axis=0))):
                        only = where & (np.arange(where.shape[1]) == column)
                        channel = f"{name}/{log[name].channels[column]}" if where.shape[1] > 1 else name
                        rests = name == DRIVE and _rests(log, column, only[:, column], evidence.noise(name))
                        edit = together([]) if rests else blanked(name, only)
                        yield self._found(evidence, index, channel, name, only[:, column], edit, rests, column)

    def _bad(self, evidence: Evidence, index: int, name: str, coarse: dict[tuple[str, int], float]) -> Array:
        signal, noise = evidence.recordings[index][name], evidence.noise(name)
        bad = np.zeros(signal.values.shape, bool)
        for column, values in enumerate(signal.values.T):
            step, own = resolution(values) or coarse[name, column], _while_it_moves(values)
            level = min(noise[column] or own, own or noise[column])
            if step > COARSE * level:
                continue
            ends = limits(values, level)
            least = shortest_run(step, level)
            for start, stop in runs(values, least):
                at_end = values[start] in ends and (values == values[start]).sum() > stop - start
                bad[start:stop, column] = not at_end
        return bad

    def _found(
        self,
        evidence: Evidence,
        index: int,
        channel: str,
        name: str,
        where: Array,
        edit: object,
        rests: bool = False,
        column: int = 0,
    ) -> Found:
        signal = evidence.recordings[index][name]
        time, first = signal.time, int(np.argmax(where))
        last = len(where) - 1 - int(np.argmax(where[::-1]))
        start = evidence.start(index)
        value = signal.values[first, column]
        if where.all():
            text = f"is constant at {value:.6g} {signal.unit}"
        else:
            until = "on" if last == len(where) - 1 else f"to {time[last] - start:.2f} s"
            text = f"is constant at {value:.6g} {signal.unit} from {time[first] - start:.2f} s {until}"
        if where.sum() < 0.9 * (last - first + 1):
            text += f", {where.mean():.0%} of the time"
        text += f" ({int(where.sum())} equal samples)"
        if rests:
            text += ", as its command is; stuck or read in coarse steps"
        action = Action.SAID if rests else Action.REPAIRED if name == DRIVE else Action.LEFT_OUT
        finding = evidence.finding(
            self.kind, index, channel, text, action, rests or name == DRIVE, (float(time[first]), float(time[last]))
        )
        return Found(index, finding, edit)  # type: ignore[arg-type]


def _while_it_moves(values: Array) -> float:
    """Noise of the samples that differ from those before them."""
    return own_noise(values[1:][np.diff(values) != 0])


def _alike(bad: Array) -> bool:
    return bool((bad == bad[:, :1]).all())


def _coarsest(evidence: Evidence) -> dict[tuple[str, int], float]:
    """Widest resolution of every channel over the set: one at rest in a recording does not show its own there."""
    steps: dict[tuple[str, int], float] = {}
    for index in evidence.indices:
        for name in evidence.measured(index):
            for column, values in enumerate(evidence.recordings[index][name].values.T):
                steps[name, column] = max(steps.get((name, column), 0.0), resolution(values))
    return steps


def _rests(log: Recording, column: int, where: Array, noise: Array) -> bool:
    """Whether the command of a joint stands still where the joint does."""
    if COMMAND not in log:
        return False
    joints, command = log[DRIVE], log[COMMAND]
    inside = np.interp(joints.time[where], command.time, command.values[:, column])
    return bool(np.ptp(inside) < STILL * noise[column])
