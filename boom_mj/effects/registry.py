"""Which effects there are: those of `library/`, of other installed packages, and of files at hand.

Presence is registration: a module of `library/`, an entry point of the group `boom_mj.effects` that names a module or
a class, a file given to `load_effects`. What cannot be loaded is a warning; two effects of one id are an error.
"""

import pickle
import sys
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from hashlib import sha256
from importlib import import_module, util
from importlib.metadata import entry_points
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType
from typing import Any, Generic, TypeVar

from boom_mj.effects.base import Effect
from boom_mj.effects.site import BOOM_SITES, Site, place
from boom_mj.errors import EffectError, EffectWarning
from boom_mj.machine import Machine

Item = TypeVar("Item")
Result = TypeVar("Result")
GROUP = "boom_mj.effects"
_files: dict[Path, ModuleType] = {}


@cache
def builtin() -> Mapping[str, type[Effect]]:
    """Every effect of `library/`, by id, sorted."""
    library = import_module("boom_mj.effects.library")
    return _by_id((name, import_module(f"{library.__name__}.{name}")) for _, name, _ in iter_modules(library.__path__))


@cache
def effect_library() -> Mapping[str, type[Effect]]:
    """Every effect, by id, sorted: ours, those of other packages, those of files at hand.

    Raises:
        EffectError: two of them have one id.
    """
    found: list[tuple[str, Any]] = [(kind.__module__, kind) for kind in builtin().values()]
    for point in sorted(entry_points(group=GROUP), key=lambda point: point.name):
        try:
            found.append((f"entry point {point.name}", point.load()))
        except Exception as error:  # whatever another package does
            warnings.warn(f"effects of entry point {point.name} cannot be loaded: {error}", EffectWarning, stacklevel=2)
    return _by_id([*found, *((str(path), module) for path, module in _files.items())])


def load_effects(path: Path) -> Mapping[str, type[Effect]]:
    """Let the effects of a Python file compete like ours; what it defines, by id.

    Raises:
        EffectError: the file cannot be run, holds no effect, or one whose id is taken.
    """
    path = path.resolve()
    if path in _files:
        return _by_id([(str(path), _files[path])])
    name = f"boom_mj_effects_{path.stem}_{sha256(bytes(path)).hexdigest()[:8]}"
    spec = util.spec_from_file_location(name, path)
    if path.suffix != ".py" or spec is None or spec.loader is None or not path.is_file():
        raise EffectError(f"{path} is no Python file with effects")
    module = util.module_from_spec(spec)
    sys.modules[name] = module  # so that its effects can be pickled
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # whatever the file does
        raise EffectError(f"{path} cannot be run: {type(error).__name__}: {error}") from error
    found = _by_id([(str(path), module)])
    if not found:
        raise EffectError(f"{path} defines no effect: there is no class of ModelEffect, ForceEffect, InputEffect, ...")
    _files[path] = module
    effect_library.cache_clear()
    try:
        effect_library()
    except EffectError:
        del _files[path]
        raise
    return found


class Equipped(Generic[Item, Result]):
    """Work that can be pickled for other processes, which load the files at hand before they begin."""

    def __init__(self, work: Callable[[Item], Result]):
        self.files, self.packed = tuple(_files), pickle.dumps(work)

    def __call__(self, item: Item) -> Result:
        for path in self.files:
            load_effects(path)
        work: Callable[[Item], Result] = pickle.loads(self.packed)
        return work(item)


def _by_id(sources: Iterable[tuple[str, Any]]) -> dict[str, type[Effect]]:
    """Effects of modules and classes, each with the name of where it comes from."""
    found: dict[str, tuple[str, type[Effect]]] = {}
    for source, item in sources:
        for kind in vars(item).values() if isinstance(item, ModuleType) else (item,):
            if not (isinstance(kind, type) and issubclass(kind, Effect)) or kind.__abstractmethods__:
                continue
            if isinstance(item, ModuleType) and kind.__module__ != item.__name__:
                continue
            if getattr(kind, "id", None) is None:
                raise EffectError(f"{source}: {kind.__name__} has no id")
            if kind.id in found:
                raise EffectError(f"two effects are called {kind.id}: of {found[kind.id][0]} and of {source}")
            found[kind.id] = source, kind
    return {name: found[name][1] for name in sorted(found)}


def make_effect(name: str, entries: Mapping[str, Any], sites: Sequence[Site] = BOOM_SITES) -> Effect:
    """An effect from its id and its location and parameters in one mapping, as machine files hold them.

    Args:
        sites: of the machine.

    Raises:
        EffectError: unknown effect, place or parameter, or a value that is no number or out of bounds.
    """
    known = effect_library()
    if name not in known:
        raise EffectError(f"no effect {name!r}; the library holds: {', '.join(known)}")
    kind = known[name]
    allowed = kind.allowed(sites)
    if not allowed:
        can = ", ".join(other for other, one in known.items() if one.allowed(sites))
        raise EffectError(f"this machine cannot have the effect {name}; it can have: {can}")
    keys = tuple(dict.fromkeys(key for site in allowed for key in site.keys))
    location = {key: entries[key] for key in keys if key in entries}
    site = place(location, allowed)
    if site is None:
        for key in keys:
            choices = tuple(dict.fromkeys(str(s.location[key]) for s in allowed if key in s.location))
            if str(location.get(key)) not in choices:
                given = location.get(key)
                raise EffectError(f"effect {name} needs {key} = one of {', '.join(choices)}; got {given}")
        raise EffectError(f"effect {name} cannot be at {location or 'this machine'}")
    values, declared = {}, kind.parameters(site)
    for key, value in entries.items():
        if key in location:
            continue
        if key not in declared:
            raise EffectError(f"effect {name} has no parameter {key!r}; it has: {', '.join((*keys, *declared))}")
        try:
            values[key] = float(value)
        except (TypeError, ValueError) as error:
            raise EffectError(f"effect {name}: {key} = {value!r} should be a number") from error
    return kind(site, **values)


def parse_effect(text: str, sites: Sequence[Site] = BOOM_SITES) -> Effect:
    """An effect from `ID:key=value,...`; see `make_effect`."""
    name, _, rest = text.partition(":")
    pairs = [pair.partition("=") for pair in filter(None, rest.split(","))]
    for key, equals, _ in pairs:
        if not equals:
            raise EffectError(f"effect {name}: {key!r} should read key=value")
    return make_effect(name, {key.strip(): value.strip() for key, _, value in pairs}, sites)


def effects_of(machine: Machine) -> tuple[Effect, ...]:
    """The effects that a machine file holds."""
    return tuple(make_effect(entry.id, entry.model_extra or {}) for entry in machine.effect)
