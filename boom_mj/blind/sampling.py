"""What a case is made of: its class, its effects with places and sizes, and what it leaves out of the library."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import cycle

import numpy as np

from boom_mj.blind.unlisted import UNLISTED
from boom_mj.effects import BOOM_SITES, Effect, Parameter, Site, builtin
from boom_mj.errors import EquilibriumError, InputError, SimulationError

MIX: Mapping[str, float] = {"single": 50, "none": 20, "pair": 12, "withheld": 25, "stranger": 13}
"""Shares of the classes of cases: of 120, every effect is there twice alone and is once withheld."""
MORE = ("several", "clutter")
"""Classes that a mix may ask for besides: three to five effects; one effect on a machine as it was built."""
SEVERAL = 3, 4, 5  # effects
SMALL, LARGE = 0.5, 2.0  # times a size worth finding
CLUTTER = 0.1, 0.3  # times a size worth finding, a fifth in the mean: what every machine has a little of
VISIBLE = 0.1  # of the noise, in training and held out, beyond what nuisances explain; what shows less is drawn again
TRIES = 40
# times the library's size worth finding, where that hardly shows
SIZES: Mapping[tuple[str, str], float] = {
    ("thermal_bending", "displacement"): 2.5,
    ("joint_friction", "cylinder_force"): 2.0,
}
# what is an angle, a frequency or a share rather than a size
RANGES: Mapping[tuple[str, str], tuple[float, float]] = {
    ("pump_pulsation", "frequency"): (0.2, 0.8),
    ("pump_pulsation", "harmonic_ratio"): (0.0, 0.5),
    ("pump_pulsation", "phase"): (-np.pi, np.pi),
    ("wind", "direction"): (-np.pi, np.pi),
    ("wind", "gust_strength"): (0.0, 0.2),
    ("joint_sensor_nonlinearity", "periods"): (1.0, 4.0),
    ("joint_sensor_nonlinearity", "phase"): (-np.pi, np.pi),
    ("moving_slug", "period"): (2.0, 6.0),
    ("moving_slug", "phase"): (-np.pi, np.pi),
    ("breathing_crack", "threshold"): (-0.003, -0.0005),
    ("mistracked_marker", "since"): (5.0, 20.0),
}


@dataclass(frozen=True)
class Order:
    """What a case shall be, before places and sizes are drawn.

    Attributes:
        kind: single, none, pair, withheld, stranger, several or clutter.
        ids: of its effects.
        without: the one id that its diagnosis leaves out: the effect's own if it is withheld, else any other.
    """

    kind: str
    ids: tuple[str, ...]
    without: str


def orders(
    cases: int,
    mix: Mapping[str, float],
    rng: np.random.Generator,
    known: Sequence[str] = (),
    unlisted: Sequence[str] = tuple(UNLISTED),
) -> list[Order]:
    """Cases of all classes in their shares, every effect as often as any other, in random order.

    Args:
        known: ids of the machine's effects; a boom's if left out.
        unlisted: ids of effects that the library does not hold.

    Raises:
        InputError: a class that does not exist, or shares that are none.
    """
    if unknown := [kind for kind in mix if kind not in (*MIX, *MORE)]:
        raise InputError(f"no class of cases is called {', '.join(unknown)}; there are {', '.join((*MIX, *MORE))}")
    if min(mix.values()) < 0 or sum(mix.values()) <= 0:
        raise InputError(f"shares of classes must not be negative, nor all zero; got {dict(mix)}")
    if mix.get("stranger") and not unlisted:
        raise InputError("stranger=: machines of this kind have no effects outside the library")
    known = known or known_effects()
    asked = (*MIX, *(kind for kind in MORE if kind in mix))  # more decks than before would shuffle all others
    deal = {kind: _deck(unlisted if kind == "stranger" else known, rng) for kind in asked}
    found = []
    for kind, count in _shared_out(cases, mix).items():
        for _ in range(count):
            ids = [] if kind == "none" else [next(deal[kind])]
            wanted = int(rng.choice(SEVERAL)) if kind == "several" else 2 if kind == "pair" else len(ids)
            while len(ids) < wanted:
                ids.append(str(rng.choice([name for name in known if name not in ids])))
            others = [name for name in known if name not in ids]
            found.append(Order(kind, tuple(ids), ids[0] if kind == "withheld" else str(rng.choice(others))))
    return [found[k] for k in rng.permutation(len(found))]


def known_effects(sites: Sequence[Site] = BOOM_SITES) -> list[str]:
    """Ids of what the library has for a machine."""
    return [name for name, kind in builtin().items() if kind.competes and kind.allowed(sites)]


def others(order: Order, rng: np.random.Generator, sites: Sequence[Site] = BOOM_SITES) -> Order:
    """The same order of as many other effects, where none of its own can be simulated."""
    known = UNLISTED if order.kind == "stranger" else known_effects(sites)
    ids = _spare(known, (*order.ids, order.without), rng)[: len(order.ids)]
    return replace(order, ids=tuple(ids), without=ids[0] if order.kind == "withheld" else order.without)


def family(name: str) -> list[str]:
    """An effect's id, and those of effects that become it at some of their values, or it them."""
    library, special = builtin(), builtin()[name].special_cases
    return [name, *(other for other, kind in library.items() if name in kind.special_cases or other in special)]


def _deck(names: Sequence[str] | Mapping[str, object], rng: np.random.Generator) -> Iterator[str]:
    """Names in random order, over and over."""
    return cycle([str(name) for name in rng.permutation(list(names))])


def _shared_out(cases: int, mix: Mapping[str, float]) -> dict[str, int]:
    """Whole numbers in given shares, the largest remainders rounded up."""
    exact = {kind: cases * share / sum(mix.values()) for kind, share in mix.items()}
    counts = {kind: int(share) for kind, share in exact.items()}
    by_remainder = sorted(exact, key=lambda kind: counts[kind] - exact[kind])
    for kind in by_remainder[: cases - sum(counts.values())]:
        counts[kind] += 1
    return counts


def draw_all(
    order: Order,
    rng: np.random.Generator,
    visibility: Callable[[Sequence[Effect]], float],
    sites: Sequence[Site] = BOOM_SITES,
    visible: float = VISIBLE,
) -> list[tuple[Effect, dict[str, float]]]:
    """The effects of an order; what these experiments show at no place and size gives way to another effect.

    Raises:
        InputError: the machine stands none.
    """
    found, spare = [draw(name, rng, visibility, sites, visible) for name in order.ids], None
    for k, (effect, _) in enumerate(found):
        while visibility([effect]) < visible:
            if spare is None:  # no draw before is another for it
                alike = UNLISTED if order.kind == "stranger" else known_effects(sites)
                spare = _spare(alike, (*order.ids, order.without), rng)
            if not spare:
                break
            found[k] = effect, _ = draw(spare.pop(), rng, visibility, sites, visible)
    return found


def draw_clutter(
    count: int, order: Order, effects: Sequence[Effect], rng: np.random.Generator, sites: Sequence[Site]
) -> list[Effect]:
    """Small effects of other kinds than a case has, each at a place of its own: two frictions of a joint are one."""
    taken, found = {effect.site.key for effect in effects}, list[Effect]()
    names = [name for name in known_effects(sites) if name not in (*order.ids, order.without)]
    for name in rng.permutation(names) if count else ():
        places = [site for site in builtin()[str(name)].allowed(sites) if site.key not in taken]
        if len(found) < count and places:
            site = places[rng.integers(len(places))]
            taken.add(site.key)
            found.append(_sized(builtin()[str(name)], site, rng, lambda: float(rng.uniform(*CLUTTER)))[0])
    return found


def _spare(names: Sequence[str] | Mapping[str, object], taken: Sequence[str], rng: np.random.Generator) -> list[str]:
    return [str(name) for name in rng.permutation([name for name in names if name not in taken])]


def draw(
    name: str,
    rng: np.random.Generator,
    visibility: Callable[[Sequence[Effect]], float],
    sites: Sequence[Site] = BOOM_SITES,
    visible: float = VISIBLE,
) -> tuple[Effect, dict[str, float]]:
    """An effect that shows, at a random place and of random size, and the values that were drawn.

    Where these experiments show none, it is the one of TRIES that comes closest.

    Raises:
        InputError: the machine stands none.
    """
    kind = {**builtin(), **UNLISTED}[name]
    places = kind.allowed(sites)
    best: tuple[float, tuple[Effect, dict[str, float]] | None] = (-1.0, None)
    for _ in range(TRIES):
        site = places[rng.integers(len(places))]
        effect, values = _sized(kind, site, rng, lambda: float(np.exp(rng.uniform(np.log(SMALL), np.log(LARGE)))))
        try:
            shows = visibility([effect])
        except (EquilibriumError, SimulationError):
            continue
        if shows >= visible:
            return effect, values
        best = max(best, (shows, (effect, values)), key=lambda found: found[0])
    if best[1] is None:
        raise InputError(f"the machine stands no effect {name}")
    return best[1]


def _sized(
    kind: type[Effect], site: Site, rng: np.random.Generator, times: Callable[[], float]
) -> tuple[Effect, dict[str, float]]:
    """An effect at a site, each size so many times one worth finding, and the values that were drawn."""
    declared = kind.parameters(site)
    names = [name for name in declared if name in kind.free(site) or (kind.id, name) in RANGES]
    values = {name: _size(kind.id, name, declared[name], rng, times) for name in names}
    return kind(site, **values), values


def _size(effect: str, name: str, bound: Parameter, rng: np.random.Generator, times: Callable[[], float]) -> float:
    if (effect, name) in RANGES:
        return float(rng.uniform(*RANGES[effect, name]))
    coordinate = times() * SIZES.get((effect, name), 1.0)
    both = not bound.inverse and bound.low < bound.neutral < bound.high
    return bound.value(-coordinate if both and rng.random() < 0.5 else coordinate)
