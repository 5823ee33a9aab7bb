"""What the making of cases asks of a kind of machine."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

import numpy as np

from boom_mj.effects import Effect, Site
from boom_mj.effects.base import Cause


class Bench(Protocol):
    """Where machines of one kind are recorded; plain data, so that processes can have it."""

    @property
    def files(self) -> Mapping[str, str]:
        """Texts of what is nominal, by name of the file: what a diagnosis is given beside the logs."""

    @property
    def sites(self) -> Sequence[Site]:
        """Where effects may be."""

    @property
    def unlisted(self) -> Mapping[str, type[Effect]]:
        """Effects that the library does not hold, by id."""

    @property
    def visible(self) -> float:
        """Least visibility of an effect; what shows less is drawn again."""

    @property
    def readme(self) -> str:
        """The task, for those who answer."""

    def visibility(self, effects: Sequence[Effect]) -> float:
        """What they change beyond nuisances, root mean square in deviations of the noise; see `Detectability`.

        Of training and of what is held out, whichever shows less.
        """

    def alike(self, effect: Effect) -> list[Cause]:
        """What no recording tells from an effect that shows, of any strength: other causes that make the same of it."""

    def individual(self, rng: np.random.Generator, as_built: bool) -> tuple[Effect, ...]:
        """What no two machines share.

        Args:
            as_built: as far as before anyone has calibrated the machine's file.
        """

    def record(self, effects: Sequence[Effect], rng: np.random.Generator, folder: Path) -> None:
        """Simulate a machine on the plant and write its logs into `train` and `holdout` of a folder.

        Raises:
            EquilibriumError, SimulationError: it does not stand these effects; nothing is written.
        """
