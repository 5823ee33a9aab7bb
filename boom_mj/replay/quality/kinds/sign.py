"""Channels with their sign turned."""

from collections.abc import Iterator, Sequence

import numpy as np

from boom_mj.replay.quality.beside import SHOWN, Pair, by_case, concerned, having, pairs
from boom_mj.replay.quality.check import Check, Found, Turn
from boom_mj.replay.quality.edits import DRIVE, mapped
from boom_mj.replay.quality.evidence import Evidence
from boom_mj.replay.quality.finding import Action, Repair

TURNED = 5.0  # times better with the sign turned; sound logs reach 2.6, of a channel that a base tilts
DELAYS = np.arange(-2.0, 2.01, 0.08)  # s, of a late clock: an eighth of a period of the second mode apart
PLACES = "markers"
MANY = 0.5  # of the IMUs' channels: as many are turned by a clock that is half a period late


class JointSign(Check):
    """A joint angle that is the negative of its command."""

    kind = "sign"
    turn = Turn.JOINT_SIGNS

    def look(self, evidence: Evidence) -> Iterator[Found]:
        yield from _turned(evidence, [DRIVE])


class Sign(Check):
    """A channel that is the negative of what the model predicts, be it with its mean or about it."""

    kind = "sign"
    turn = Turn.SIGNS

    def look(self, evidence: Evidence) -> Iterator[Found]:
        names = dict.fromkeys(name for k in evidence.indices for name in evidence.measured(k) if name != DRIVE)
        yield from _turned(evidence, [name for name in names if name.startswith("imu/")])
        yield from _turned(evidence, [name for name in names if not name.startswith("imu/")])


def _at_any_delay(evidence: Evidence, index: int, name: str) -> np.ndarray:
    """How much better the swings fit with the other sign if each sign may have a delay of its own, (k,)."""
    signal, noise = evidence.recordings[index][name], evidence.noise(name)
    misfits: dict[int, list[np.ndarray]] = {1: [], -1: []}
    for delay in DELAYS:
        predicted = evidence.predicted(index, name, float(delay))
        if predicted is not None:
            pair = Pair(signal.values / noise, predicted / noise).moving
            for sign, found in misfits.items():
                found.append(pair.misfit(sign))
    return np.min(misfits[1], axis=0) / np.min(misfits[-1], axis=0)


def _turned(evidence: Evidence, names: Sequence[str]) -> Iterator[Found]:
    """Findings on signals among which not most are turned."""
    ratios: dict[int, dict[tuple[str, int], float]] = {}
    still: set[tuple[int, int]] = set()  # channels of places that do not move
    for name in names:
        for index, pair in pairs(evidence, name):
            worse = []
            for part in (pair, pair.moving) if name.startswith("imu/") else (pair,):
                worse.append(np.where(part.power > SHOWN, part.misfit() / part.misfit(-1), 1.0))
            most, least = np.max(worse, axis=0), np.min(worse, axis=0)
            both = np.where(most * least > 1, most, least)  # the clearer one
            late = (both > TURNED) & (pair.moving.power > pair.power / 2) & name.startswith("imu/")
            if late.any():  # by its swings alone, which a late clock turns as well
                both = np.where(late, np.minimum(both, _at_any_delay(evidence, index, name)), both)
            told = np.max([part.power for part in (pair, pair.moving)], axis=0) > SHOWN
            if name == PLACES:  # a bent link turns the mean of a place, not how it moves
                moves = pair.moving.power > SHOWN
                still |= {(index, int(k)) for k in np.flatnonzero(~moves)}
                both = np.where(moves & (pair.moving.misfit() < pair.moving.misfit(-1)), np.minimum(both, 1.0), both)
            ratios.setdefault(index, {}).update({(name, int(k)): float(both[k]) for k in np.flatnonzero(told)})
    ratios = {
        index: found
        for index, found in ratios.items()
        if names == [DRIVE] or sum(r > TURNED for r in found.values()) < MANY * len(found)
    }
    for (name, column), ratio in by_case(ratios).items():
        sound = min(ratio.values()) < 1 / TURNED
        for index in concerned(ratio, having(evidence, name), TURNED):
            if sound and name == PLACES and (index, column) in still:
                continue
            signal = evidence.recordings[index][name]
            turned = np.where(np.arange(len(signal.channels)) == column, -1.0, 1.0)
            channel, told = signal.channels[column], ratio.get(index, 0.0) > TURNED
            text = (
                f"is turned: with the other sign it fits {ratio[index]:.3g} times better"
                if told
                else "is turned in other logs, and nothing here speaks against it"
            )
            repair = Repair(name, channel, sign=-1)
            finding = evidence.finding("sign", index, f"{name}/{channel}", text, Action.REPAIRED, True, repair=repair)
            yield Found(index, finding, mapped(name, turned, np.zeros_like(turned)))
