"""What an experiment would tell: which of several explanations holds, or how large the causes of one are.

Sensors are simulated without noise, by one hinge per elastic coordinate, and averaged over blocks as a diagnosis does,
in units of noise. With r the difference of two explanations, J what the sizes of one may still do (in deviations, as
they are known) and N what nuisances do (in prior deviations),

    d^2 = min |r - J x - N y|^2 + x^2 + y^2 = r^T (1 + J J^T + N N^T)^-1 r

is how far apart they stay when sizes and nuisances are fitted (T-optimality: Atkinson and Fedorov 1975), and

    C = (1 + J^T (1 + N N^T)^-1 J)^-1

the covariance of the sizes after the experiment, in deviations before it (D-optimality: its determinant).
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import permutations
from typing import Any

import numpy as np

from boom_mj.effects import Effect, Parameter, make_effect
from boom_mj.errors import BoomError, ExperimentError, InputError
from boom_mj.estimation.intervals import Z95
from boom_mj.machine import Machine
from boom_mj.sensors import measure, noise_levels, sample_rates
from boom_mj.simulation import CATALOGUE, Experiment, Plant, make_plant, run_experiment
from boom_mj.systems.boom.motions import drawn, fits, varied
from boom_mj.systems.boom.nuisances import nuisances
from boom_mj.systems.boom.timeline import DRIVE

Array = np.ndarray
Hypothesis = tuple[Effect, ...]
BLOCK_S = 0.1  # as of a diagnosis
LONGEST = 125.0  # s, of an experiment of the catalogue
CLEAR, EVERY_S = 1.5, 0.5  # m, that a straight boom stays above the ground: it sags; s, between looks
STEPS, KNOWN = (1e-3, 0.3), 1e-9  # typical sizes: by which derivatives are taken; deviation of what is known
PARENT = 1.5  # mean rank of what is varied
DRAWS = 20  # for each random experiment that is wanted: most come close to the ground


@dataclass(frozen=True)
class Explanation:
    """Effects, and how well their sizes are known.

    Attributes:
        deviations: of every parameter that a fit may change, effect by effect, scaled.
    """

    effects: Hypothesis
    deviations: tuple[float, ...]

    @classmethod
    def of(cls, effects: Hypothesis) -> "Explanation":
        """Of sizes that are not known."""
        return cls(effects, (1.0,) * sum(len(effect.free(effect.site)) for effect in effects))

    @property
    def parameters(self) -> list[tuple[int, str, Parameter]]:
        """Number of the effect, name and parameter of every size."""
        owned = ((k, effect, name) for k, effect in enumerate(self.effects) for name in effect.free(effect.site))
        return [(k, name, effect.declared[name]) for k, effect, name in owned]

    def moved(self, number: int) -> tuple[Hypothesis, float]:
        """With one size otherwise, and by how many of its deviations."""
        owner, name, parameter = self.parameters[number]
        effect, deviation = self.effects[owner], max(self.deviations[number], KNOWN)
        here = parameter.coordinate(effect.values[name])
        step = float(np.clip(deviation, *STEPS))
        value = parameter.value(here + step)
        if abs(parameter.coordinate(value) - here) < step / 2:  # at a bound
            value = parameter.value(here - step)
        other = type(effect)(effect.site, **{**effect.values, name: value})
        moved = (parameter.coordinate(value) - here) / deviation
        return (*self.effects[:owner], other, *self.effects[owner + 1 :]), moved


@dataclass(frozen=True)
class Outlook:
    """What an experiment is expected to tell.

    Attributes:
        separation: of the closest two explanations, in standard deviations; None of a single one.
        left: deviation of every size of the first explanation after the experiment over that before it.
        gain: what a design makes as large as it can.
    """

    separation: float | None
    left: tuple[float, ...]
    gain: float

    @property
    def probability(self) -> float | None:
        """That the right one of two equally likely explanations will have on average, by Bayes' rule."""
        if self.separation is None:
            return None
        nodes, weights = np.polynomial.hermite_e.hermegauss(41)
        odds = self.separation**2 / 2 + self.separation * nodes
        return float(weights @ (1 / (1 + np.exp(-odds))) / weights.sum())


def asked_of(answer: Mapping[str, Any], path: str) -> list[Explanation]:
    """What ties in an answer of a diagnosis, or what it found, with how well that is known.

    Args:
        path: of the answer, for errors.

    Raises:
        InputError: there is neither.
    """
    ties = answer.get("ties") or []
    found = answer.get("effects") or answer.get("suspect") or []
    asked = [[one, *one.get("with", ())] for one in ties[0]] if ties else [found] if found else []
    if not asked:
        raise InputError(f"{path} has neither ties nor effects: say with --between what is to be told apart")
    explanations = []
    for rows in asked:
        effects, deviations = [], list[float]()
        for row in rows:
            if "parameters" not in row:
                raise InputError(f"{path}: {row.get('id')} has no sizes: it is of an older version; diagnose again")
            sizes = row["parameters"]
            values = {name: size["value"] for name, size in sizes.items()}
            effects.append(effect := make_effect(row["id"], {**row["location"], **values}))
            for name in effect.free(effect.site):
                ends = [sizes.get(name, {}).get(end) for end in ("low", "high")]
                known = [effect.declared[name].coordinate(end) for end in ends if end is not None]
                deviations.append(abs(known[1] - known[0]) / (2 * Z95) if len(known) == 2 else 1.0)
        explanations.append(Explanation(tuple(effects), tuple(deviations)))
    return explanations


Rated = tuple[Experiment, Outlook]


@dataclass(frozen=True)
class Design:
    """The best experiment found, and for comparison the catalogue's best and the median of the random ones."""

    best: Rated
    catalogue: Rated | None
    random: Rated | None


class Judge:
    """What experiments would tell of some explanations of a machine."""

    def __init__(self, machine: Machine, explanations: Sequence[Explanation]) -> None:
        self.machine, self.explanations = machine, tuple(explanations)
        self.levels, self.rates = noise_levels(machine), sample_rates(machine)
        self._plants: dict[Hypothesis, Plant] = {}
        self._pool = ThreadPoolExecutor()

    def outlook(self, plan: Experiment) -> Outlook:
        """Of an experiment.

        Raises:
            BoomError: the machine cannot do it.
        """
        plan.check(self.machine)
        asked_for = {effect.cause for own in self.explanations for effect in own.effects}
        beside = [n for n in nuisances() if not asked_for & {effect.cause for effect in n.hypothesis}]
        moved = [[own.moved(k) for k in range(len(own.parameters))] for own in self.explanations]
        asked = [(), *(n.hypothesis for n in beside), *(own.effects for own in self.explanations)]
        asked = [*dict.fromkeys((*asked, *(effects for sizes in moved for effects, _ in sizes)))]  # a plant runs once
        said = dict(zip(asked, self._pool.map(lambda effects: self._said(effects, plan), asked)))
        columns = np.stack([(said[n.hypothesis] - said[()]) * n.deviation for n in beside], axis=1)
        slopes = [  # per deviation
            np.stack([(said[effects] - said[own.effects]) / by for effects, by in sizes], axis=1)
            for own, sizes in zip(self.explanations, moved)
        ]
        first = slopes[0]
        whitened = first - columns @ np.linalg.solve(np.eye(len(beside)) + columns.T @ columns, columns.T @ first)
        information = np.eye(first.shape[1]) + first.T @ whitened
        left = tuple(np.sqrt(np.diag(np.linalg.inv(information))))
        if len(slopes) == 1:
            return Outlook(None, left, float(np.linalg.slogdet(information)[1]))
        whole = [said[own.effects] for own in self.explanations]
        pairs = permutations(range(len(whole)), 2)
        apart = min(_left(whole[a] - whole[b], np.hstack([slopes[b], columns])) for a, b in pairs)
        return Outlook(float(np.sqrt(apart)), left, apart)

    def _said(self, effects: Hypothesis, plan: Experiment) -> Array:
        """Block means of all sensors but the joints', in units of their noise, (N,)."""
        found = measure(run_experiment(self._plant(effects), plan), plan.name, "", plan.duration)
        parts = []
        for name, level in self.levels.items():
            if name != DRIVE:
                count = max(1, round(BLOCK_S * self.rates[name]))
                values = found[name].values[: len(found[name].values) // count * count] / level
                parts.append(values.reshape(-1, count, values.shape[1]).mean(axis=1).ravel() * np.sqrt(count))
        return np.concatenate(parts)

    def _plant(self, effects: Hypothesis) -> Plant:
        if effects not in self._plants:
            self._plants[effects] = make_plant(self.machine, 1, effects)
        return self._plants[effects]

    def high(self, plan: Experiment) -> bool:
        """Whether a straight boom stays above the ground."""
        plain = self._plant(())
        qpos = np.zeros(plain.model.nq)
        for angles in plan.joint_path(np.arange(0.0, plan.duration, EVERY_S))[0]:
            qpos[plain.joints] = angles
            if plain.markers(qpos).reshape(-1, 3)[:, 2].min() < CLEAR:
                return False
        return True


def _left(difference: Array, columns: Array) -> float:
    """Square of a difference (N,) from which columns (N, k), each with a prior of one, take what they can."""
    slope = columns.T @ difference
    return float(difference @ difference - slope @ np.linalg.solve(np.eye(len(slope)) + columns.T @ columns, slope))


def designed(
    machine: Machine,
    explanations: Sequence[Explanation],
    seconds: float,
    load: float = 0.0,
    tries: int = 20,
    rng: np.random.Generator | None = None,
    tell: Callable[[str], None] = lambda line: None,
) -> Design:
    """The experiment that tells most, of the catalogue's, of random ones, and of variations of the best.

    Args:
        explanations: that tie, or one whose sizes are asked for.
        seconds: that it may last.
        load: N, that a rope may pull with before it is cut.
        tries: random experiments that can be done, and as many variations.

    Raises:
        ExperimentError: nothing fits within the time and the machine's limits.
    """
    rng, judge = rng or np.random.default_rng(0), Judge(machine, explanations)

    def judged(plan: Experiment) -> Rated | None:
        try:
            return plan, judge.outlook(plan)
        except BoomError:
            return None

    short = [plan for plan in CATALOGUE.values() if plan.duration <= seconds]
    short = [plan for plan in short if plan.release is None or np.abs(plan.load).max() <= load]
    known = _ranked(filter(None, map(judged, short)))
    tell(f"catalogue: {len(known)} experiments can be done in {seconds:g} s")
    found = list[Rated]()
    for _ in range(DRAWS * tries):
        plan = drawn(machine, seconds, load, rng)
        if len(found) < tries and fits(plan, machine) and judge.high(plan) and (one := judged(plan)):
            found.append(one)
    if not found and not known:
        raise ExperimentError(f"no experiment of {seconds:g} s was found that {machine.name} can do: give it more time")
    tell(f"{len(found)} random experiments")
    pool = _ranked([*known, *found])
    for number in range(1, 1 + tries):
        plan = varied(pool[min(int(rng.exponential(PARENT)), len(pool) - 1)][0], machine, rng)
        if judge.high(plan) and (one := judged(plan)):
            pool = _ranked([*pool, one])
        if number % 10 == 0:
            tell(f"{number} of {tries} variations, best gain {pool[0][1].gain:.3g}")
    return Design(pool[0], known[0] if known else None, _ranked(found)[len(found) // 2] if found else None)


def _ranked(found: Iterable[Rated]) -> list[Rated]:
    return sorted(found, key=lambda one: -one[1].gain)


def next_experiment(machine: Machine, explanations: Sequence[Hypothesis], done: Sequence[str]) -> str | None:
    """The experiment of the catalogue that tells most per second between the two closest of some explanations."""
    judge, found = Judge(machine, [Explanation.of(effects) for effects in explanations]), dict[str, float]()
    for name, plan in CATALOGUE.items():
        if name not in done and plan.duration <= LONGEST:
            try:
                found[name] = judge.outlook(plan).gain / plan.duration
            except BoomError:
                continue
    return max(found, key=lambda name: found[name]) if found else None
