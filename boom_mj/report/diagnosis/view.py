"""What every section of the page reads: the diagnosis, its answer, residuals before and after, gaps by group."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from boom_mj.diagnosis import Diagnosis
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.localisation import Cell, locate
from boom_mj.effects import Effect
from boom_mj.estimation.dataset import Dataset
from boom_mj.report.words import SPACE
from boom_mj.systems.system import ChannelPlace, System, SystemFacts

Array = np.ndarray
LOG = re.compile(r"\.(mcap|bag|db3|csv|mat)(\.gz)?\b")


@dataclass(frozen=True)
class Change:
    """Gaps before and after the correction, of a part of the data."""

    name: str
    before: float
    after: float


@dataclass(frozen=True)
class View:
    """A diagnosis as the page shows it.

    Attributes:
        names: of the logs, training first.
        answer: the document of the diagnosis.
    """

    found: Diagnosis
    names: tuple[str, ...]
    answer: Mapping[str, Any]

    @property
    def data(self) -> Dataset:
        return self.found.model.data

    @property
    def system(self) -> System:
        return self.found.model.system

    @property
    def facts(self) -> SystemFacts:
        return self.found.model.facts

    @property
    def corrected(self) -> bool:
        """Whether there is a correction to show beside the machine as built."""
        return self.found.best is not None

    @property
    def effects(self) -> Sequence[Effect]:
        """Of the best explanation."""
        return self.found.best.fit.effects if self.found.best else ()

    @property
    def before(self) -> Array:
        """Whitened residual of the machine as built, (N,)."""
        return self.found.as_built

    @property
    def after(self) -> Array:
        """Whitened residual of the best explanation, (N,); that of the machine as built where there is none."""
        return self.found.best.fit.residual if self.found.best else self.found.as_built

    @cached_property
    def built(self) -> Array:
        """What the machine as built says, with its nuisances, in units of the channels, (N,); NaN where hidden."""
        return self._said(self.found.model, self.before)

    @cached_property
    def explained(self) -> Array:
        """What the best explanation says, in units of the channels, (N,); NaN where hidden."""
        return self._said(self.model, self.after)

    @property
    def model(self) -> Linearisation:
        """About which the best explanation was fitted."""
        return self.found.best.model if self.found.best else self.found.model

    def _said(self, model: Linearisation, white: Array) -> Array:
        weight = model.noise.weight
        return self.data.measured - np.where(weight > 0, white / np.where(weight > 0, weight, 1.0), np.nan)

    @cached_property
    def cells(self) -> tuple[Cell, ...]:
        """Where the gap of the machine as built lies, in all recordings."""
        return locate(self.found.model, self.before)

    @cached_property
    def cells_left(self) -> tuple[Cell, ...]:
        """Where what is left lies, in all recordings."""
        return locate(self.found.model, self.after)

    @cached_property
    def groups(self) -> tuple[str, ...]:
        """Channel groups by sensor, link and direction."""

        def rank(name: str) -> list[int]:
            return [self.order[axis].index(part) for axis, part in zip(self.order, _axes(self.places[name]))]

        return tuple(sorted(self.places, key=rank))

    @cached_property
    def order(self) -> Mapping[str, tuple[str, ...]]:
        """Names along every axis of a cell, in the order in which people read them."""
        sensors, links, directions = (tuple(dict.fromkeys(names)) for names in zip(*map(_axes, self.places.values())))
        bands = tuple(name for name, _ in self.facts.bands_hz)
        return {
            "sensor": sensors,
            "link": links,
            "direction": directions,
            "band": bands,
            "phase": self.facts.wording.phases,
        }

    @cached_property
    def places(self) -> Mapping[str, ChannelPlace]:
        """Where every channel group belongs."""
        found = [self.system.channel(channel.signal, channel.column) for channel in self.data.channels]
        return {place.group: place for place in found}

    def place_name(self, sensor: str, part: str) -> str:
        """A sensor at its part, for people."""
        return next(p.place for p in self.places.values() if (p.sensor, p.part) == (sensor, part))

    def recording_name(self, index: int) -> str:
        """File name without its ending, or the experiment's name where there is no file."""
        named = index < len(self.names)
        return LOG.sub("", Path(self.names[index]).name) if named else self.data.recordings[index].name

    def part(self, index: int) -> str:
        """What a recording was used for."""
        if self.data.split_in_time or index in self.data.extended:
            return f"training: {self.facts.wording.first_part.replace('%', f'{SPACE}%')}; the rest held out"
        return "training" if index < self.data.training else "held out"

    def _titled(self, index: int) -> str:
        name = self.recording_name(index)
        return name if self.data.split_in_time else f"{name}, {self.part(index)}"

    def change(self, name: str, rows: Array) -> Change:
        """Gaps over some entries, (N,) of bool; NaN where there are none."""
        before, after = (
            float(np.sqrt(np.mean(r[rows] ** 2))) if rows.any() else np.nan for r in (self.before, self.after)
        )
        return Change(name, before, after)

    def changes(self, labels: Sequence[str], rows: Array) -> dict[str, Change]:
        """Gaps over some entries, by a label per channel; labels without entries are left out."""
        return self.changes_within(np.repeat(np.asarray(labels), np.diff(self.data.offsets)), rows)

    def changes_within(self, labels: Array, rows: Array) -> dict[str, Change]:
        """Gaps over some entries, by a label per entry, (N,); labels without entries are left out."""
        return {str(name): self.change(str(name), rows & (labels == name)) for name in np.unique(labels[rows])}

    @cached_property
    def phases(self) -> Array:
        """What happens at every entry, (N,) of str."""
        data = self.data
        of = [self.system.timeline(log).phases() for log in data.recordings]
        parts = [
            of[c.recording][np.minimum((c.time / data.block_s).astype(int), len(of[c.recording]) - 1)]
            for c in data.channels
        ]
        return np.concatenate(parts)

    @cached_property
    def by_group(self) -> dict[str, Change]:
        """Held-out gaps of every channel group, in the order of `groups`."""
        found = self.changes([channel.group for channel in self.data.channels], self.data.held_out)
        return {name: found[name] for name in self.groups if name in found}

    @cached_property
    def by_recording(self) -> list[Change]:
        """Gaps of every recording that measured anything, with what it was used for."""
        data = self.data
        changes = [
            self.change(self._titled(k), data.used & (data.recording_of == k)) for k in range(len(data.recordings))
        ]
        return [change for change in changes if np.isfinite(change.before)]


def view_of(found: Diagnosis, answer: Mapping[str, Any]) -> View:
    """A diagnosis and its document."""
    logs = answer["provenance"]["recordings"]
    return View(found, (*logs["train"], *logs["holdout"]), answer)


def _axes(place: ChannelPlace) -> tuple[str, str, str]:
    return place.sensor, place.part, place.direction
