"""Cases of a machine that a channel map and an MJCF file describe."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Self

import mujoco
import numpy as np

from boom_mj.blind.bench import Bench
from boom_mj.blind.mjcf_plant import MjcfPlant
from boom_mj.blind.plant_file import PlantFile, parse_plant
from boom_mj.blind.sampling import family, known_effects
from boom_mj.blind.task import mjcf_readme
from boom_mj.effects import Effect, Site, builtin, parse_effect
from boom_mj.effects.base import Cause
from boom_mj.errors import EffectError, InputError, SimulationError
from boom_mj.files import inside, read_text, write_text
from boom_mj.logs.columns import write_columns
from boom_mj.systems.mjcf import MjcfSystem, load_mjcf
from boom_mj.systems.mjcf.channel_map import ChannelMap, parse_channel_map
from boom_mj.systems.predictor import Predictor
from boom_mj.systems.recorded import RecordedMachine

Array = np.ndarray
PARTS = "train", "holdout"
MAP, MODEL = "map.toml", "model.xml"
VISIBLE = 2.0  # of the declared noise: what every plant has and its model lacks, noise that remembers too, hides less
STRONG = 100.0  # times a size worth finding, that what imitates an effect may have: of any strength


@dataclass(frozen=True)
class MjcfBench(Bench):
    """A machine by the texts of its channel map, its model, and its plant (`plant_file`)."""

    channels: str
    model: str
    plant: str

    @classmethod
    def beside(cls, path: Path) -> Self:
        """Of a map NAME.toml, with NAME.plant.toml beside it.

        Raises:
            InputError: there is no such plant, or something is wrong in one of the files.
        """
        text, plant = read_text(path, InputError), path.with_suffix(".plant.toml")
        channels = parse_channel_map(text, str(path))
        if not plant.is_file():
            raise InputError(f"{path} has no plant beside it: {plant} says how its machine is recorded")
        if not channels.model:
            raise InputError(f"{path} names no model")
        model = read_text(inside(path.parent, channels.model, InputError, path), InputError)
        made = cls(text, model, read_text(plant, InputError))
        parse_plant(made.plant, plant, channels)
        return made

    @property
    def files(self) -> Mapping[str, str]:
        return {MAP: self.channels, MODEL: self.model}

    @property
    def sites(self) -> Sequence[Site]:
        return _recorded(self, ()).system.sites()

    @property
    def unlisted(self) -> Mapping[str, type[Effect]]:
        return {}

    @property
    def visible(self) -> float:
        return VISIBLE

    @property
    def readme(self) -> str:
        return mjcf_readme(self.sites)

    def visibility(self, effects: Sequence[Effect]) -> float:
        """Of one effect alone beyond what any other of the library makes of it, too: see `_imitations`."""
        change, others = _seen(self, tuple(effects)), [_nuisances(self)]
        if len(effects) == 1:
            own, library = effects[0], builtin()
            others += [
                columns
                for cause, columns in _imitations(self)
                if cause != own.cause and own.id not in library[cause[0]].special_cases
            ]
        least = min((_beyond(columns, change) for columns in others), key=_size)
        return min(_size(least[rows]) for rows in (_healthy(self).data.train, _healthy(self).data.held_out))

    def alike(self, effect: Effect) -> list[Cause]:
        change, (_, *forms) = _seen(self, (effect,)), family(effect.id)
        found = [(form, effect.cause[1]) for form in forms if effect.site in builtin()[form].allowed(self.sites)]
        if _size(change) >= self.visible:
            found += [cause for cause, columns in _imitations(self) if _size(_beyond(columns, change)) < self.visible]
        return [cause for cause in dict.fromkeys(found) if cause != effect.cause]

    def individual(self, rng: np.random.Generator, as_built: bool) -> tuple[Effect, ...]:
        return tuple(parse_effect(text, self.sites) for text in self._parsed[1].effects)

    def record(self, effects: Sequence[Effect], rng: np.random.Generator, folder: Path) -> None:
        channels, plant, spec = *self._parsed, mujoco.MjSpec.from_string(self.model)
        machine = MjcfPlant(spec, channels, plant, effects)
        logs = [(motion, machine.record(motion, rng)) for motion in plant.motion]
        for motion, table in logs:
            (folder / motion.part).mkdir(parents=True, exist_ok=True)
            write_columns(folder / motion.part / f"{motion.name}.csv", table)

    @property
    def _parsed(self) -> tuple[ChannelMap, PlantFile]:
        channels = parse_channel_map(self.channels)
        return channels, parse_plant(self.plant, "plant", channels)


def _healthy(bench: MjcfBench) -> Predictor:
    """With logs of a machine that has no effect but what every plant has: for sizes, and what shows."""
    return _recorded(bench, bench.individual(np.random.default_rng(0), False))


@cache
def _recorded(bench: MjcfBench, effects: tuple[Effect, ...]) -> Predictor:
    """The nominal machine with logs of one that has effects."""
    with TemporaryDirectory() as folder:
        case = Path(folder)
        bench.record(effects, np.random.default_rng(0), case)
        for name, text in bench.files.items():
            write_text(case / name, text)
        given = case_of_mjcf(case, case)
        return Predictor(given.system, given.data, threads=1)


def _seen(bench: MjcfBench, effects: tuple[Effect, ...]) -> Array:
    """What effects change, over the noise, (N,).

    Raises:
        SimulationError: the model does not stand them.
    """
    healthy = _healthy(bench)
    nominal, seen = healthy.predict([(), effects], healthy.system.facts.fidelity.rough)
    change = (seen - nominal) / healthy.data.noise
    if not np.isfinite(change[healthy.data.used]).all():
        raise SimulationError(f"the model does not stand {', '.join(map(str, effects))}")
    return np.nan_to_num(change)


@cache
def _nuisances(bench: MjcfBench) -> Array:
    """What nuisances change per prior deviation, over the noise, (N, m)."""
    own = [_seen(bench, n.hypothesis) * n.deviation for n in _healthy(bench).system.nuisances()]
    return np.stack(own, axis=1) if own else np.zeros((len(_healthy(bench).data.measured), 0))


@cache
def _imitations(bench: MjcfBench) -> tuple[tuple[Cause, Array], ...]:
    """Causes of the library, and what each changes at the points that screening looks at, beside nuisances, (N, k + m).

    A recording tells an effect by what none of these, of any strength, makes as well: mass and inertia of a lone
    carriage are one and the same.
    """
    found, nuisances = [], _nuisances(bench)
    for name in known_effects(bench.sites):
        kind = builtin()[name]
        for site in kind.allowed(bench.sites):
            for points in kind.screening(site):
                with suppress(SimulationError, EffectError):
                    columns = np.stack([_seen(bench, (kind(site, **point),)) for point in points], axis=1)
                    found.append((kind(site).cause, np.hstack([STRONG * columns, nuisances])))
    return tuple(found)


def _beyond(columns: Array, change: Array) -> Array:
    """A change less what columns with a weight of one deviation each explain of it, (N,)."""
    root = np.eye(columns.shape[1]) + columns.T @ columns
    return np.asarray(change - columns @ np.linalg.solve(root, columns.T @ change))


def _size(change: Array) -> float:
    return float(np.sqrt(np.mean(np.square(change))))


def case_of_mjcf(case: Path, nominal: Path) -> RecordedMachine[MjcfSystem]:
    """The nominal machine of a folder, and the recordings of a case.

    Raises:
        InputError: files that cannot be read.
    """
    train, held_out = (sorted((case / part).glob("*.csv")) for part in PARTS)
    return load_mjcf(train, held_out, nominal / MAP, nominal / MODEL)
