"""Which force in time, without a formula, explains a gap at which place.

A force at a place is a latent input (`estimation.latent_input`) with whitened responses L: a first-order process f of
covariance s^2 Q, regularised by its likeliest strength s,

    f = s^2 Q L^T (1 + s^2 L Q L^T)^-1 r.

L is that of few simulated units; the residual is simulated anew with every f, which is improved by what is left (ROUNDS
times). Noise and errors of sensors can be pushed so as well. So a force is estimated from one half of the channels and
judged by the other, which it has to predict, and the other way round: at a wrong place it closes little. Nuisances are
those of the held-out recordings, since those of training have absorbed what the force does there.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.latent import UnitResponses, units_of
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.scoring import held_out_closure
from boom_mj.effects import ForceEffect, Motion, Site
from boom_mj.estimation.bootstrap import Closure
from boom_mj.estimation.latent_input import KNOT_S, make_part, posterior
from boom_mj.machine import Machine

Array = np.ndarray
EVERY_S = 0.25  # between the numbers that a force in time is made of
ROUNDS = 3  # simulations of a force, each improved by what the last has left
SLOW_S = 10.0  # between the numbers of slow forces, whose responses are simulated as a whole
MOST_UNITS = 200  # that are simulated for one recording
UNIT = 100.0  # N, on a boom
SHARE = 0.1  # of what a joint's actuator exerts, a unit there
APART_S = 1e6  # between the directions of a force, which know nothing of each other


class Push(ForceEffect):
    """A force in time: upwards or to the left on a point of a boom, or on a joint of any MJCF machine."""

    id = "push"
    time: tuple[float, ...] = (0.0,)
    size: tuple[float, ...] = (0.0,)

    @property
    def key(self) -> tuple[object, ...]:
        return *super().key, self.time, self.size

    def following(self, time: Iterable[float], size: Iterable[float]) -> "Push":
        """Of given sizes, in its site's `value`, at given times; in between on straight lines."""
        other = type(self)(self.site)
        object.__setattr__(other, "time", tuple(time))
        object.__setattr__(other, "size", tuple(size))
        return other

    def basis(self, time_s: float) -> "Push":
        return self.following((time_s - KNOT_S, time_s, time_s + KNOT_S), (0.0, 1.0, 0.0))

    def force(self, motion: Motion) -> Mapping[str, Array]:
        place, size = self.location, self.site.value * np.interp(motion.time, self.time, self.size)
        if "joint" in place:
            return {str(place["joint"]): size}
        slew, none = motion.joints[:, 0], np.zeros_like(size)
        way = [none, none, size] if place["direction"] == "up" else [-np.sin(slew) * size, np.cos(slew) * size, none]
        return {str(place["point"]): np.stack(way, axis=1)}


@dataclass(frozen=True, eq=False)
class ForcePlace:
    """Where a force in time may be.

    Attributes:
        acts_on, unit: for people.
        pushes: one for every direction, by its name.
    """

    acts_on: str
    unit: str
    pushes: Mapping[str, Push]

    @property
    def value(self) -> float:
        """A unit of the force."""
        return next(iter(self.pushes.values())).site.value


@dataclass(frozen=True, eq=False)
class ForceInTime:
    """What a force at one place would have to be.

    Attributes:
        closure: of the held-out gap, every channel predicted by a force that the other half of them tells.
        time: by held-out recording, s from its start, (n,); of the best place only.
        force: mean and standard deviation, of noise and nuisances, in the place's unit, (directions, 2, n) each.
    """

    place: ForcePlace
    closure: Closure
    time: Mapping[int, Array] = field(default_factory=dict)
    force: Mapping[int, Array] = field(default_factory=dict)


def forces_in_time(model: Linearisation, raw: Array, clock: Clock) -> tuple[ForceInTime, ...]:
    """At every place that can be pushed, that which closes most first.

    Args:
        raw: whitened residual of the nominal machine, (N,).
    """
    data, found = model.data, list[tuple[ForceInTime, list[_Recording]]]()
    held = [k for k in range(len(data.recordings)) if data.held_out[data.rows(k)].any()]
    if max(len(units_of(model.predictor, k)[1]) for k in held) > MOST_UNITS:
        clock.tell("forces in time are not estimated: poses change too fast for responses of few units")
        return ()
    for place in _places(model):
        if clock.over(f"the force in time on {place.acts_on}"):
            break
        pushes = place.pushes.values()
        begun = [[UnitResponses.begin(model.predictor, (push,), push, k) for push in pushes] for k in held]
        recordings = [_Recording.of(model, raw, place, units) for units in begun]
        found.append((ForceInTime(place, _closure(model, raw, recordings)), recordings))
        clock.tell(f"a force in time on {place.acts_on} closes {found[-1][0].closure.value:.0%}")
    found.sort(key=lambda one: -one[0].closure.value)
    return tuple(_with_history(one, own) if k == 0 else one for k, (one, own) in enumerate(found))


def _places(model: Linearisation) -> Iterator[ForcePlace]:
    for site in model.system.sites():
        if {"mjcf", "measured"} <= site.tags and site.keys == ("joint",):
            push = Push(Site(site.key, value=SHARE * site.value))
            yield ForcePlace(f"joint {site.location['joint']}", site.force_unit, {"positive": push})
        elif "boom" in site.tags and not site.keys:
            machine: Machine = model.system.machine  # type: ignore[attr-defined]
            links = range(2, 2 + len(machine.links))
            points = {machine.middle_marker(link): f"the middle of link {link}" for link in links}
            for point, acts_on in {"tip": "the tip", **points}.items():
                ways = {way: Push(Site((("point", point), ("direction", way)), value=UNIT)) for way in ("up", "left")}
                yield ForcePlace(acts_on, "N", ways)


def _closure(model: Linearisation, raw: Array, recordings: Sequence["_Recording"]) -> Closure:
    before, after = raw.copy(), raw.copy()
    for one in recordings:
        half = model.data.channel_of[one.rows] % 2 == 0
        for told in (half, ~half):
            before[one.rows][~told] = one.cleaned(raw[one.rows], ~told)
            after[one.rows][~told] = one.cleaned(one.fitted(told)[1], ~told)
    return held_out_closure(model, before, after)


def _with_history(found: ForceInTime, recordings: Sequence["_Recording"]) -> ForceInTime:
    """By all channels."""
    everything = ((one, np.ones(len(one.responses), bool)) for one in recordings)
    force = {one.index: one.refined().fitted(told)[0] * one.place.value for one, told in everything}
    return replace(found, time={one.index: one.time for one in recordings}, force=force)


@dataclass(frozen=True, eq=False)
class _Recording:
    """A recording in which a force at a place is sought.

    Attributes:
        rows: its entries of the long vector.
        raw: residual of the nominal machine in all, whitened, (N,).
        time: of the numbers that the force is made of, by direction, (m,), s.
        responses: whitened, of these entries to these numbers, one direction after the other, (n, directions m).
    """

    model: Linearisation
    place: ForcePlace
    index: int
    rows: slice
    raw: Array
    time: Array
    responses: Array

    @classmethod
    def of(cls, model: Linearisation, raw: Array, place: ForcePlace, units: Sequence[UnitResponses]) -> "_Recording":
        """By simulated units; a force that ends as the recording begins is a unit of its own."""
        predictor, noise, knots = model.predictor, model.noise.plain, units[0].knots
        time = np.arange(0.0, knots[-1] + EVERY_S, EVERY_S)
        hats = np.maximum(1 - np.abs(knots[:, None] - time) / EVERY_S, 0).astype(np.float32)
        responses = [one.whitened(predictor, noise) @ hats for one in units]
        found = cls(model, place, index := units[0].index, model.data.rows(index), raw, time, np.hstack(responses))
        found.responses[:, :: len(time)] = found.simulated((0.0, EVERY_S), [(1.0, 0.0)])
        return found

    def refined(self) -> "_Recording":
        """With responses to slow forces that are simulated as a whole: sums of units ring where poses change."""
        slow = np.arange(0.0, self.time[-1] + SLOW_S, SLOW_S)
        wide = np.maximum(1 - np.abs(self.time[:, None] - slow) / SLOW_S, 0)
        each = np.kron(np.eye(len(self.place.pushes)), wide)
        missing = self.simulated(self.time, wide.T) - self.responses @ each
        return replace(self, responses=(self.responses + missing @ np.linalg.pinv(each)).astype(np.float32))

    def simulated(self, time: Iterable[float], histories: Iterable[Iterable[float]]) -> Array:
        """Whitened responses to histories over given times, one direction after the other, (n, directions k)."""
        predictor, level = self.model.predictor, self.model.facts.fidelity.coarse
        pushes = [push.following(time, one) for push in self.place.pushes.values() for one in histories]
        without, *found = (predictor.begin(whole, level, self.index) for whole in ((), *((push,) for push in pushes)))
        changes = np.stack([future.result() - without.result() for future in found], axis=1)
        changes = np.nan_to_num(changes)  # what cannot be simulated does nothing
        return self.model.noise.plain.whitened(self.rows, changes)

    @property
    def nuisances(self) -> Array:
        """Whitened columns in these entries, (n, m)."""
        return self.model.posterior.basis.whole[self.rows]

    def cleaned(self, white: Array, told: Array) -> Array:
        """Some entries of a residual (n,) without what nuisances explain of them."""
        columns, own = self.nuisances[told].astype(float), white[told]
        return own - columns @ np.linalg.solve(columns.T @ columns + np.eye(columns.shape[1]), columns.T @ own)

    def fitted(self, told: Array) -> tuple[Array, Array]:
        """By some entries, (n,) of bool: mean and deviation, (directions, 2, m), and what is left of all, (n,)."""
        pushes = self.place.pushes.values()
        turn, size, _ = np.linalg.svd(np.where(told[:, None], self.nuisances, 0), full_matrices=False)
        share = 1 - 1 / np.sqrt(1 + size**2)

        def heard(white: Array) -> Array:
            """Told entries, whitened for nuisances that may be anything, too."""
            own = (white.T * told).T
            return own - turn @ (share * (turn.T @ own).T).T

        apart = (self.time + APART_S * np.arange(len(pushes))[:, None]).ravel()
        part = make_part(self.rows, heard(self.responses), apart)
        predictor, level, wanted = self.model.predictor, self.model.facts.fidelity.coarse, self.raw.copy()
        without = predictor.begin((), level, self.index)
        wanted[self.rows] = heard(self.raw[self.rows])
        for _ in range(ROUNDS):
            mean, deviation = (x.reshape(len(pushes), -1) for x in posterior(part, wanted))
            whole = tuple(push.following(self.time, size) for push, size in zip(pushes, mean))
            change = np.nan_to_num(predictor.begin(whole, level, self.index).result() - without.result())
            left = self.raw[self.rows] - self.model.noise.plain.whitened(self.rows, change[:, None])[:, 0]
            wanted[self.rows] = heard(left + self.responses @ mean.ravel())
        return np.stack([mean, deviation], axis=1), left
