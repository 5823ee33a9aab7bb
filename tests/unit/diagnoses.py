"""Diagnoses of every verdict, made without a search."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from boom_mj.diagnosis import Diagnosis
from boom_mj.diagnosis.budget import odds
from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.criteria import BOOM as CRITERIA
from boom_mj.diagnosis.fitting import Fit
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.scoring import Scored, held_out_closure
from boom_mj.diagnosis.screening import Screened
from boom_mj.diagnosis.steps import ChannelSteps
from boom_mj.effects import make_effect
from boom_mj.estimation.bootstrap import gap
from boom_mj.estimation.linear import LinearPosterior
from boom_mj.estimation.noise import NoiseModel
from boom_mj.logs import read_log
from boom_mj.machine import load_machine
from boom_mj.recording import Recording, window
from boom_mj.systems.boom import BoomSystem
from boom_mj.systems.predictor import Predictor, dataset_of

ROOT = Path(__file__).parents[2]
BOOM = load_machine(ROOT / "models" / "boom36.toml")
HOSTILE = '<script src="https://evil.example/x.js"></script>'
NAMES = ("one.mcap", f"{HOSTILE}.mcap", "\"'><img src=//evil.example onerror=alert(1)>.mcap")
CHANNELS = [ChannelSteps(name, f"{HOSTILE}/x", 8.25, 7.5, 1.125, 0.1) for name in NAMES]
PAYLOAD = (make_effect("tip_payload", {"mass": 40.0}),)
HEAVIER = (make_effect("link_mass", {"link": 5, "factor": 1.1}),)
SOFT = (make_effect("hydraulic_compliance", {"joint": 3, "stiffness": 2e7}),)
VERDICTS = (
    "consistent",
    "explained",
    "ambiguous",
    "unexplained",
    "partial",
    "partial beside a suspect",
    "unexplained without a suspect",
)


def short_log() -> Recording:
    log = read_log(ROOT / "logs" / "independent_release_stretched_vertical.mcap")
    cut = {name: window(signal, 7.0, 11.0) for name, signal in log.signals.items()}
    return replace(log, name=HOSTILE, signals=cut)


@cache
def predictor(training: int) -> Predictor:
    system = BoomSystem(BOOM)
    return Predictor(system, dataset_of(system, [short_log()] * 3, training), threads=1)


def model_of(training: int) -> Linearisation:
    """Noise alone, nuisances that do nothing."""
    found, data = predictor(training), predictor(training).data
    nuisances, none = found.system.nuisances(), np.zeros(len(data.time))
    noise = NoiseModel(data, np.where(data.used, 1 / data.noise, 0.0), none)
    return Linearisation(
        found,
        effects=(),
        individual=(),
        level=found.system.facts.fidelity.coarse,
        base=np.nan_to_num(data.measured),
        mean_error=none,
        posterior=LinearPosterior.of(noise, np.zeros((len(none), len(nuisances)))),
        nuisances=nuisances,
        all_nuisances=nuisances,
        criteria=CRITERIA,
    )


def residual(model: Linearisation, size: float) -> np.ndarray:
    """White, of a given gap."""
    used = model.data.used
    return np.where(used, size * np.random.default_rng(1).standard_normal(len(used)), 0.0)


def scored(model: Linearisation, effects: tuple, size: float) -> Scored:
    candidate, left = Candidate(effects), residual(model, size)
    count = len(candidate.parameters)
    fit = Fit(candidate, candidate.start, effects, left, np.zeros((len(left), count)), 0.0)
    train, held_out = (gap(left, rows) for rows in (model.data.train, model.data.held_out))
    return Scored(fit, model, train, held_out, np.full(count, 0.02))


def diagnosis(case: str, training: int = 2) -> Diagnosis:
    model, verdict = model_of(training), case.split()[0]
    before = 1.0 if verdict == "consistent" else 8.0
    model = replace(model, base=model.base - model.data.noise * residual(model, before))
    after = {"consistent": before, "partial": 2.0, "unexplained": 6.0}.get(verdict, 0.98)
    pair = case.endswith("beside a suspect")
    found = (
        *((scored(model, (*PAYLOAD, *HEAVIER), 0.95 * after),) if pair else ()),
        scored(model, PAYLOAD, after),
        scored(model, HEAVIER, 1.1 if verdict == "ambiguous" else 1.2 * before),
        scored(model, SOFT, 1e6),
    )
    best = None if case in ("consistent", VERDICTS[-1]) else found[0]
    ties = found[1:2] if verdict == "ambiguous" else ()
    nominal = residual(model, before)
    share = held_out_closure(model, nominal, best.fit.residual if best else nominal)
    following = "release_bow_vertical" if ties else None
    screened = tuple(Screened(Candidate(effects), 0.3) for effects in (PAYLOAD, (make_effect("end_hose", {}),)))
    return Diagnosis(
        verdict, best, found, ties, screened, nominal, share, 0.1, following, model, odds(nominal, found, model)
    )
