"""Screening: which candidates are worth a fit, by the sensitivity of the simulated recordings to them.

For the screening points of a candidate the columns J = f(point) - f(0) are simulated at the roughest level; in the
inner product of the nuisances the best weights are w = (J^T J + 1 / W^2)^-1 J^T r, and they explain the share
J^T r . w / <r, r> of the training misfit. All candidates go in one batch, and with them what follows freely, so that
what the two have in common is known: the nuisances, and the effects that the machine has already.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from boom_mj.diagnosis.candidate import Candidate, Kind, apart
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.effects import Effect, Values
from boom_mj.estimation.least_squares import OPTIONS
from boom_mj.estimation.linear import LinearPosterior
from boom_mj.systems.system import Hypothesis, LinearResponse

Array = np.ndarray
Part = slice | Array
PART = 32  # columns that are multiplied at once


@dataclass(frozen=True)
class Screened:
    """A candidate at the values that screening suggests, and the share of the training misfit that it may explain.

    Attributes:
        others: the same causes at other values that promise as much: fits have a minimum for each of many periods.
    """

    candidate: Candidate
    share: float
    others: tuple[Candidate, ...] = ()

    @property
    def starts(self) -> tuple[Candidate, ...]:
        """All from which a fit may begin."""
        return self.candidate, *self.others


class NormalEquations(NamedTuple):
    """Of screening columns J and a residual r.

    Attributes:
        slopes: J^T r, (c,).
        curvature: blocks of J^T J by their rows and columns.
        diagonal: of J^T J, (c,).
        whole: <r, r>.
    """

    slopes: Array
    curvature: Callable[[Part, Part], Array]
    diagonal: Array
    whole: float


class Screening:
    """Sensitivity columns of every candidate about a machine, simulated once.

    Args:
        model: of that machine.
        kinds: effects and sites.
        lines_hz: frequencies offered to periodic effects.
        given: effects that the machine has already, free to change.
        near: whether the model's own columns of nuisances do, though it is about another machine.
        done: another one about the same machine, whose points are not simulated again.
    """

    def __init__(
        self,
        model: Linearisation,
        kinds: Sequence[Kind],
        lines_hz: Sequence[float],
        given: tuple[Effect, ...] = (),
        near: bool = False,
        done: "Screening | None" = None,
    ):
        self.model, self.kinds, self.lines_hz, self.given = model, kinds, lines_hz, given
        free = [(kind, site) for kind, site in kinds if apart(kind, site, given)]
        self.rows = [(kind, site, group) for kind, site in free for group in kind.screening(site, lines_hz) if group]
        points = [kind(site, **values) for kind, site, group in self.rows for values in group]
        known, data, noise = Candidate(given), model.data, model.noise
        train, level = data.train, model.facts.fidelity.rough
        steps, moved = known.steps(known.start)
        about = {effect.cause for effect in given} == {effect.cause for effect in model.effects}
        same = near or (about and level == model.facts.fidelity.coarse)  # then the model's own columns are these
        nuisances = [] if same else [(*given, *t.hypothesis) for t in model.nuisances]
        loose = [*nuisances, *moved]
        self.numbers = number = {point: k for k, point in enumerate(points)}
        self.columns = np.empty((int(train.sum()), len(points)), np.float32)  # (training, c)
        ready = {point: done.columns[:, k] for point, k in done.numbers.items() if point in number} if done else {}
        for point, column in ready.items():
            self.columns[:, number[point]] = column
        long = [point for point in self._known_responses(model.columns, number) if point not in ready]
        whole = [given, *loose, *((*given, point) for point in long)]
        found = model.predictor.predictions(whole, level, data.trained)
        base = next(found)
        changes = np.nan_to_num([next(found) - base for _ in loose]).reshape(len(loose), len(base)).T
        simulated = changes[:, : len(nuisances)] * [t.deviation for t in model.nuisances[: len(nuisances)]]
        own = model if same else model.with_noise(noise, simulated)
        known_columns = [noise.white(c)[train] / s for c, s in zip(changes.T[len(nuisances) :], steps)]
        self.follow = np.column_stack([own.posterior.trained, *known_columns])
        for point, prediction in zip(long, found):
            self.columns[:, number[point]] = noise.white(prediction - base)[train]
        if own is not model:
            self._known_responses(own.columns, number)
        for k, point in enumerate(points):
            if number[point] != k:
                self.columns[:, k] = self.columns[:, number[point]]
        ends = np.cumsum([0, *(len(group) for _, _, group in self.rows)])
        self._known: tuple[Array, NormalEquations] | None = None
        self.stretches = [slice(start, stop) for start, stop in pairwise(ends)]

    def rank(self, residual: Array) -> list[Screened]:
        """Candidates by the share of a whitened residual that they may explain, best first, each at its best point."""
        budget, equations = self.model.budget, self.normal_equations(residual)
        looks = list[tuple[Effect, float]]()
        for (kind, site, group), part in zip(self.rows, self.stretches):
            share, weights = self._explained(equations, part)
            values = kind.combine(site, group, weights)
            effect = kind(site, **values)
            looks.append((effect, share if _acts(effect, values) else 0.0))
        before, most = equations.whole / len(self.columns), max((share for _, share in looks), default=0.0)
        explained = self._leaves_little(before, (1 - most) * before)
        found: dict[tuple, list[Screened]] = {}
        for effect, share in looks:
            share = share if explained else max(share, self._of_latent(effect, residual))
            candidate = Candidate((effect,))
            found.setdefault(candidate.places, []).append(Screened(candidate, share))
        least = budget.alike_share * max((s.share for alike in found.values() for s in alike), default=0.0)
        ranked = []
        for alike in found.values():
            best, *others = sorted(alike, key=lambda s: -s.share)
            starts = [best.candidate]
            for other in (s.candidate for s in others if s.share > least):
                if all(np.max(np.abs(other.start - start.start)) > budget.apart for start in starts):
                    starts.append(other)
            ranked.append(replace(best, others=tuple(starts[1:])))
        return sorted(ranked, key=lambda s: -s.share)

    def promises(
        self, effects: Hypothesis, residual: Array, about: Linearisation | None = None, jacobian: Array | None = None
    ) -> dict[tuple, float]:
        """The share of the misfit of the machine that effects make that candidates may explain, by today's columns.

        Beside effects whose size is free a candidate's promise hardly depends on the machine that its column is of.

        Args:
            residual: of that machine, whitened, (N,).
            about: that machine, where it is known; else today's columns follow.
            jacobian: what its effects change there, (N, p).
        """
        if about is None or jacobian is None:
            own = [self.columns[:, part] for part in self.parts_of(effects)]
            equations = self._equations(residual, np.column_stack([self.follow, *own]))
        else:
            equations = self.equations_beside(residual, about, jacobian)
        promise: dict[tuple, float] = {}
        for (kind, site, _), part in zip(self.rows, self.stretches):
            if apart(kind, site, effects):
                share, _ = self._explained(equations, part)
                promise[kind.id, site.key] = max(share, promise.get((kind.id, site.key), 0.0))
        return promise

    def imitations(
        self, effects: Hypothesis, change: Array, about: Linearisation, jacobian: Array
    ) -> tuple[list[Screened], float]:
        """Candidates with the share of a change that each alone makes as well, and how large it is, a mean square.

        Args:
            effects: that stay and follow freely.
            change: whitened, (N,).
            about: the machine of which it is one.
            jacobian: what its effects change there, (N, p).
        """
        equations, found = self.equations_beside(change, about, jacobian), list[Screened]()
        for (kind, site, group), part in zip(self.rows, self.stretches):
            if apart(kind, site, effects):
                share, weights = self._explained(equations, part)
                found.append(Screened(Candidate((kind(site, **kind.combine(site, group, weights)),)), share))
        return found, equations.whole / len(self.columns)

    def equations_beside(self, residual: Array, about: Linearisation, jacobian: Array) -> "NormalEquations":
        """About a machine that is known, where its effects follow as they do there."""
        follow = np.column_stack([about.posterior.trained, jacobian[about.data.train]])
        return self._equations(residual, follow, about.posterior)

    def beside(self, effects: Hypothesis, residual: Array, lines_hz: Sequence[float]) -> dict[Kind, float]:
        """Candidates worth screening about the machine that effects make, best first, with what they promise.

        What had no line to follow, or other ones, comes first: it may promise anything.
        """
        promise, found = self.promises(effects, residual), dict[Kind, float]()
        for kind, site in self.kinds:
            if apart(kind, site, effects):
                same = kind.screening(site, lines_hz) == kind.screening(site, self.lines_hz)
                found[kind, site] = promise.get((kind.id, site.key), np.inf) if same else np.inf
        best = sorted(found, key=lambda one: -found[one])[: self.model.budget.beside]
        return {one: found[one] for one in best}

    def normal_equations(self, residual: Array) -> "NormalEquations":
        """Of a whitened residual (N,), in the inner product of what follows: nuisances below their limits, effects."""
        if not (self._known and self._known[0] is residual):
            self._known = residual, self._equations(residual, self.follow)
        return self._known[1]

    def _equations(self, residual: Array, follow: Array, posterior: LinearPosterior | None = None) -> "NormalEquations":
        """Of a whitened residual (N,), where columns follow (training, k), the first of them of nuisances."""
        posterior = posterior or self.model.posterior
        left, estimate = posterior.left(residual)
        count, free = len(estimate), posterior.free(estimate)
        prior = np.r_[np.ones(count), np.full(follow.shape[1] - count, OPTIONS.prior**-2)]
        follow, prior = (part[..., np.r_[free, np.ones(len(prior) - count, bool)]] for part in (follow, prior))
        across = self._onto(follow)  # (k, c)
        following = np.linalg.solve(np.diag(prior) + follow.T @ follow, across)

        def curvature(rows: Part, columns: Part) -> Array:
            return self.products[rows][:, columns] - across[:, rows].T @ following[:, columns]

        return NormalEquations(
            self._onto(left[:, None])[0] - (left @ follow) @ following,
            curvature,
            np.einsum("nc,nc->c", self.columns, self.columns) - np.einsum("kc,kc->c", across, following),
            float(left @ left),
        )

    def _explained(self, equations: "NormalEquations", part: slice) -> tuple[float, Array]:
        """The share of a misfit that a group of columns explains, none of one that is none, and their weights."""
        slopes, size = equations.slopes[part], part.stop - part.start
        prior = np.eye(size) / self.model.budget.weight_prior**2
        weights = np.linalg.solve(equations.curvature(part, part) + prior, slopes)
        return float(slopes @ weights / equations.whole) if equations.whole else 0.0, weights

    def parts_of(self, effects: Hypothesis) -> list[slice]:
        """Where columns of effects are: of several sizes or periods the nearest."""
        rows = [(kind.id, site.key, group, part) for (kind, site, group), part in zip(self.rows, self.stretches)]
        found = ([(_off(e, group), part) for *cause, group, part in rows if (*cause,) == e.cause] for e in effects)
        return [min(own, key=lambda one: one[0])[1] for own in found if own]

    @cached_property
    def products(self) -> Array:
        """Of all columns with one another, (c, c)."""
        return self.columns.T @ self.columns

    def _onto(self, vectors: Array) -> Array:
        """Products of vectors (training, k) with all columns, (k, c); in parts, whose copies are small."""
        parts = np.split(self.columns, range(PART, self.columns.shape[1], PART), axis=1)
        return np.hstack([vectors.T @ part for part in parts])

    def _known_responses(self, nuisances: Array, number: Mapping[Effect, int]) -> list[Effect]:
        """Fill in what is known without simulation, from what nuisances do; the other points, by column."""
        system, data, unknown = self.model.system, self.model.data, list[Effect]()
        for point, k in number.items():
            known = system.column(point, data, nuisances) if isinstance(system, LinearResponse) else None
            if known is None:
                unknown.append(point)
            else:
                self.columns[:, k] = self.model.noise.white(known)[data.train]
        return unknown

    def _of_latent(self, effect: Effect, residual: Array) -> float:
        """The share of a whitened residual that a latent input of an effect would explain, if it has one.

        Only one that leaves little counts.
        """
        model, train = self.model, self.model.data.train
        if model.latent is not None or not effect.basis(0.0):
            return 0.0
        own = model.coarse.with_latent((*self.given, effect), training_only=True)
        if own.latent is None:
            return 0.0
        left = model.clean(residual)
        before, after = (float(np.mean(white[train] ** 2)) for white in (left, own.latent.without(left)))
        return 1 - after / before if self._leaves_little(before, after) else 0.0

    def _leaves_little(self, before: float, after: float) -> bool:
        """Whether so little is left of a mean square that a latent input that leaves it counts."""
        return after**0.5 - 1 < self.model.budget.latent_left * (before**0.5 - 1)


def _off(effect: Effect, group: Sequence[Values]) -> float:
    """How far screening points are from an effect's values, scaled."""
    pairs = ((effect.declared[name], value, effect.values[name]) for point in group for name, value in point.items())
    return sum(abs(p.coordinate(there) - p.coordinate(here)) for p, there, here in pairs)


def _acts(effect: Effect, named: Iterable[str]) -> bool:
    """Whether any of the values is off neutral: one-sided bounds may forbid what the weights ask for."""
    pairs = ((effect.declared[name], effect.values[name]) for name in named)
    return any(value != p.neutral and abs(p.coordinate(value)) > 1e-6 for p, value in pairs)
