"""Laws that every effect and every system obeys; call these in the tests of a package that adds its own."""

import pickle
from collections.abc import Sequence
from copy import deepcopy

import numpy as np

from boom_mj.effects import BOOM_SITES, Effect, InputEffect, ModelEffect, Site, effect_library, parse_effect
from boom_mj.errors import EffectError
from boom_mj.machine import Machine
from boom_mj.mjcf import build
from boom_mj.recording import Recording
from boom_mj.simulation.plant import with_effects
from boom_mj.systems.system import System

EXACT = 0.02  # of the scale of an input, by which the way there and back may miss


def check_effect(kind: type[Effect], sites: Sequence[Site] = BOOM_SITES, machine: Machine | None = None) -> None:
    """Refuse an effect that breaks a law: see the messages.

    Args:
        sites: of a machine; those of a boom if left out.
        machine: a boom, on which neutral values of a `ModelEffect` must change no byte.

    Raises:
        EffectError: which law is broken, and where.
    """
    name = getattr(kind, "id", kind.__name__)
    allowed = kind.allowed(sites)
    _law(bool(allowed), name, "it can be somewhere: no site of this machine has its keys and tags")
    _law(bool(kind.__doc__), name, "its docstring tells the physics")
    unknown = set(kind.confused_with) - {*effect_library(), name}
    _law(not unknown, name, f"confused_with holds ids of the library: {', '.join(sorted(unknown))} are none")
    for site in allowed:
        neutral, here = kind(site), f" at {site.location or 'the machine'}"
        _law(kind.shapes < set(neutral.declared), name, f"some parameter is none of its shapes{here}")
        _law(bool(kind.free(site)), name, f"a parameter is free{here}")
        for key, parameter in neutral.declared.items():
            inside = parameter.low <= parameter.neutral <= parameter.high
            _law(inside, name, f"low <= neutral <= high of {key}{here}")
            value = parameter.value(0.7)
            again = parameter.value(parameter.coordinate(value))
            _law(bool(np.isclose(again, value, rtol=1e-12)), name, f"value(coordinate(v)) = v of {key}{here}")
        for group in kind.screening(site, (0.45,)):
            for point in group:
                _check_data(kind(site, **point), sites)
        if isinstance(neutral, ModelEffect) and machine is not None:
            boom = build(machine)
            same = with_effects(boom, [neutral]).boom.to_xml() == boom.to_xml()
            _law(same, name, f"neutral values change no byte of the model{here}")
        if isinstance(neutral, InputEffect):
            _check_inverse(neutral, here)


def _check_data(effect: Effect, sites: Sequence[Site]) -> None:
    """Plain data: it can be copied, sent to other processes, and written down."""
    for way, found in (
        ("pickled", pickle.loads(pickle.dumps(effect))),
        ("copied", deepcopy(effect)),
        ("read from its text", parse_effect(str(effect), sites) if effect.id in effect_library() else effect),
    ):
        _law(type(found) is type(effect) and found == effect, effect.id, f"{effect} is itself when it is {way}")


def _check_inverse(neutral: InputEffect, here: str) -> None:
    time = np.linspace(0.0, 10.0, 1001)
    true = np.sin(time)
    unchanged = np.array_equal(neutral.apply(time, true), true) and np.array_equal(neutral.invert(time, true), true)
    _law(unchanged, neutral.id, f"neutral values change no input{here}")
    point = type(neutral).screening(neutral.site)[0][0]
    effect = type(neutral)(neutral.site, **point)
    miss = np.abs(effect.invert(time, effect.apply(time, true)) - true)[50:-50]
    _law(float(np.median(miss)) < EXACT, neutral.id, f"invert(apply(u)) = u{here}")


def check_system(system: System, log: Recording) -> None:
    """Refuse a system that breaks a law.

    Args:
        log: one of its recordings.

    Raises:
        EffectError: which law is broken.
    """
    name, sites = system.facts.name, system.sites()
    _law(len({site.key for site in sites}) == len(sites), name, "its sites differ")
    level = system.facts.fidelity.rough
    first, again = (system.simulate((), level, log) for _ in range(2))
    same = all(np.array_equal(first[k].values, again[k].values, equal_nan=True) for k in first)
    _law(same and set(first) == set(again), name, "it says the same twice")
    untouched = system.observe((), first)
    _law(all(untouched[k] is first[k] for k in first), name, "signals that no effect touches are the same objects")


def _law(holds: bool, name: str, law: str) -> None:
    if not holds:
        raise EffectError(f"{name} breaks a law: {law}")
