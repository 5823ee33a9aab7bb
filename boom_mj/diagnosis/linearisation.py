"""A machine about which hypotheses are screened and fitted: its prediction, model error, noise and nuisances there.

What refining the model still changes is added by Richardson extrapolation; a share of it counts as the model's own
error (`estimation.noise`). Nuisances - zero offsets, initial states, what varies between healthy machines - are linear
columns with priors (`estimation.linear`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from boom_mj.diagnosis.criteria import OF_KIND, Criteria, SearchBudget
from boom_mj.diagnosis.latent import latent_input_of
from boom_mj.effects import Effect
from boom_mj.estimation.dataset import Dataset
from boom_mj.estimation.latent_input import NONE, LatentInput
from boom_mj.estimation.linear import Basis, LinearPosterior
from boom_mj.estimation.noise import NoiseModel, noise_model
from boom_mj.systems.fidelity import Level
from boom_mj.systems.predictor import Predictor
from boom_mj.systems.system import Hypothesis, Nuisance, System, SystemFacts

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Linearisation:
    """A machine, and what is known about it.

    Attributes:
        predictor: of its system.
        effects: of the machine about which all this is taken.
        individual: nuisances that are simulated along, at sizes estimated before.
        level: of fidelity at which changes of that machine are simulated.
        base: prediction of its simulation at the middle level less what those nuisances do in it, linearly, (N,).
        mean_error: what a finer model would add to it, (N,).
        posterior: nuisances, and the noise model.
        nuisances: what the columns of the posterior are.
        all_nuisances: the same of a machine without effects.
        criteria, budget: what decides, and what is tried.
    """

    predictor: Predictor
    effects: Hypothesis
    individual: Hypothesis
    level: Level
    base: Array
    mean_error: Array
    posterior: LinearPosterior
    nuisances: tuple[Nuisance, ...]
    all_nuisances: tuple[Nuisance, ...]
    criteria: Criteria
    budget: SearchBudget = field(default_factory=SearchBudget)

    @property
    def data(self) -> Dataset:
        return self.predictor.data

    @property
    def system(self) -> System:
        return self.predictor.system

    @cached_property
    def facts(self) -> SystemFacts:
        return self.system.facts

    @property
    def noise(self) -> NoiseModel:
        return self.posterior.noise

    @property
    def columns(self) -> Array:
        """What nuisances change per prior deviation, (N, m)."""
        return self.posterior.basis.columns

    @property
    def latent(self) -> LatentInput | None:
        return self.noise.latent

    def predict(self, hypotheses: Sequence[Hypothesis], training_only: bool = False) -> list[Array]:
        """Predictions of hypotheses, (N,) each: the base, and what a model of our level says that they change in it."""
        whole = [(*effects, *self.individual) for effects in (self.effects, *hypotheses)]
        own, *found = self.predictor.predict(whole, self.level, self.data.trained if training_only else None)
        return [self.base + (other - own) for other in found]

    def residual(self, prediction: Array) -> Array:
        """Whitened measured - (prediction + mean error), (N,)."""
        return self.noise.white(self.data.measured - prediction - self.mean_error)

    def residuals(self, hypotheses: Sequence[Hypothesis]) -> list[Array]:
        """Whitened residuals of hypotheses on the training entries, zero elsewhere, (N,) each."""
        train = self.data.train
        return [np.where(train, self.residual(p), 0.0) for p in self.predict(hypotheses, training_only=True)]

    def clean(self, white: Array) -> Array:
        """A whitened residual (N,) without what nuisances explain of its training entries."""
        return self.posterior.clean(white)

    def with_noise(self, noise: NoiseModel, columns: Array | None = None) -> "Linearisation":
        """With another noise model, and perhaps other columns."""
        basis = Basis(noise, self.columns if columns is None else columns)
        return replace(self, posterior=LinearPosterior(basis, _there(self.nuisances)))

    @property
    def coarse(self) -> "Linearisation":
        """With changes simulated by the coarse model."""
        return replace(self, level=self.facts.fidelity.coarse)

    @property
    def blurred(self) -> "Linearisation":
        """Of slow changes alone, simulated roughly: a fit has one minimum in it where vibration makes many."""
        noise = replace(self.noise, blur_s=self.facts.correlation_s)
        return replace(self.with_noise(noise), level=self.facts.fidelity.rough)

    def conditional_on(self, effects: Hypothesis) -> "Linearisation":
        """Without nuisances that effects leave nothing of, and with the latent inputs that they have."""
        found, nuisances = self, tuple(t.conditional_on(effects) for t in self.nuisances)
        if nuisances != self.nuisances:
            left = LinearPosterior(self.posterior.basis, _there(nuisances))
            found = replace(self, posterior=left, nuisances=nuisances)
        return found.with_latent(effects)

    def with_latent(self, effects: Hypothesis, training_only: bool = False) -> "Linearisation":
        """Without what latent inputs of effects explain; those that are known already stay."""
        if any(effect.basis(0.0) for effect in effects) == (self.latent is not None):
            return self
        plain = self.with_noise(self.noise.plain)
        residual = plain.clean(plain.residual(*plain.predict([effects], training_only)))
        recordings = self.data.trained if training_only else range(len(self.data.recordings))
        found = latent_input_of(self.predictor, effects, plain.noise, residual, recordings)
        return self.with_noise(replace(self.noise, latent=found))

    def allowing(self, effects: Hypothesis) -> "Linearisation":
        """Without latent inputs that are stronger than effects allow: without a wind there are no gusts."""
        if self.latent is None or self.latent.strength <= max(effect.latent_limit for effect in effects):
            return self
        return self.with_noise(replace(self.noise, latent=NONE))

    def rebased(self, effects: Hypothesis, estimate: Array, training_only: bool = False) -> "Linearisation":
        """With the base of a machine that has effects and nuisances; weights, columns, model error stay."""
        found = self.conditional_on(effects)
        individual = of_size(found.nuisances, estimate)
        recordings = self.data.trained if training_only else None
        middle = self.facts.fidelity.middle
        (base,) = self.predictor.predict([(*effects, *individual)], middle, recordings)
        return replace(
            found, effects=effects, individual=individual, base=base - found.columns @ estimate.astype(np.float32)
        )

    def relinearised(self, effects: Hypothesis, estimate: Array) -> "Linearisation":
        """About a machine that has effects and nuisances: a heavier boom swings slower, with its own model error.

        Changes are simulated as the base is: the cost of a coarse model has minima of its own where nuisances meet
        limits.
        """
        kept, fidelity = self.rebased(effects, estimate), self.facts.fidelity
        nuisances = tuple(t.conditional_on(effects) for t in self.all_nuisances)
        whole, moving = (*effects, *kept.individual), [t for t in nuisances if not t.slow]
        self.predictor.ahead([whole], *fidelity.others)
        coarse = [whole, *((*whole, *t.hypothesis) for t in moving)]
        base, *shifted = self.predictor.predict(coarse, fidelity.coarse)
        found = iter([(prediction - base) * t.deviation for prediction, t in zip(shifted, moving)])
        columns = [column if t.slow else next(found) for column, t in zip(kept.columns.T, nuisances)]
        about = replace(kept, nuisances=nuisances, level=fidelity.middle)
        return _weighed(about, columns, estimate).with_latent(effects)


def linearise(
    predictor: Predictor,
    criteria: Criteria | None = None,
    budget: SearchBudget | None = None,
    nuisances: tuple[Nuisance, ...] | None = None,
) -> Linearisation:
    """Simulate the healthy machine at several fidelities and with every nuisance.

    Args:
        criteria: those of the kind of machine if left out.
        nuisances: those of the system if left out.
    """
    facts = predictor.system.facts
    nuisances = predictor.system.nuisances() if nuisances is None else nuisances
    fidelity, empty = facts.fidelity, np.zeros(len(predictor.data.time))
    predictor.ahead([()], *fidelity.others, fidelity.middle)
    coarse, *shifted = predictor.predict([(), *(t.hypothesis for t in nuisances)], fidelity.coarse)
    columns = [(s - coarse) * t.deviation for s, t in zip(shifted, nuisances)]
    posterior = LinearPosterior.of(NoiseModel(predictor.data, empty, empty), empty[:, None])
    about = Linearisation(
        predictor,
        effects=(),
        individual=(),
        level=fidelity.coarse,
        base=empty,
        mean_error=empty,
        posterior=posterior,
        nuisances=nuisances,
        all_nuisances=nuisances,
        criteria=criteria or OF_KIND[facts.kind],
        budget=budget or SearchBudget(),
    )
    return _weighed(about, columns, np.zeros(len(columns)))


def _there(nuisances: Sequence[Nuisance]) -> Array:
    """Which nuisances are some, (m,) of bool."""
    return np.array([bool(nuisance.hypothesis) for nuisance in nuisances], bool)


def of_size(nuisances: Sequence[Nuisance], estimate: Array) -> Hypothesis:
    """Nuisances as effects, one per cause, of sizes in prior deviations, (m,)."""
    kinds: dict[tuple, Effect] = {}
    values: dict[tuple, dict[str, float]] = {}
    for share, nuisance in zip(estimate, nuisances):
        for whole in nuisance.hypothesis:
            sizes, kinds[whole.cause] = values.setdefault(whole.cause, {}), whole
            for name, value in whole.values.items():
                declared = whole.declared[name]
                if value != declared.neutral:
                    size = sizes.get(name, declared.neutral) + share * nuisance.deviation * (value - declared.neutral)
                    sizes[name] = float(np.clip(size, *declared.bounds))
    return tuple(type(whole)(whole.site, **values[cause]) for cause, whole in kinds.items())


def _weighed(about: Linearisation, columns: Sequence[Array], estimate: Array) -> Linearisation:
    """With base, model error and noise of its machine, from its columns, without NaN."""
    fidelity, predictor = about.facts.fidelity, about.predictor
    levels = fidelity.middle, *fidelity.others
    base, *others = (predictor.predict([(*about.effects, *about.individual)], at)[0] for at in levels)
    changes = iter([found - base for found in others])
    missing, doubts = np.zeros_like(base), []
    for check in fidelity.checks:
        own = np.array([next(changes) for _ in check.levels])
        missing += np.nan_to_num(check.missing @ own)
        doubts.append(np.nan_to_num(check.doubtful @ own))
    starts = np.nan_to_num([*changes]).T if fidelity.starts else None
    noise = noise_model(about.data, np.array(doubts), fidelity.along, starts)
    clean = np.empty((len(base), len(columns)), np.float32)
    for k, column in enumerate(columns):
        clean[:, k] = np.nan_to_num(column)
    return replace(about.with_noise(noise, clean), base=base - clean @ estimate.astype(np.float32), mean_error=missing)
