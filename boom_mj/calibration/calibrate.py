"""From recordings to a calibrated machine: steps, what the data tell apart, refinement."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from threadpoolctl import threadpool_limits

from boom_mj.calibration.evidence import model_error, predictor_of
from boom_mj.calibration.features import Features, features_of
from boom_mj.calibration.identify import Identifiability, identify, simplify
from boom_mj.calibration.parameters import JOINTS, USUAL, Parameterisation, Variant, make_parameterisation
from boom_mj.calibration.refine import ROUGH, Refined, refine, sensitivities
from boom_mj.calibration.steps import initial_estimate
from boom_mj.errors import LogError
from boom_mj.machine import Machine
from boom_mj.recording import Recording
from boom_mj.systems.predictor import Predictor

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Calibration:
    """What was found.

    Attributes:
        machine: as the file had it.
        predictor: of its recordings.
        whole: the parameterisation of all parameters that were asked for.
        identified: what the data tell of them.
        fixed: sentences about parameters that are fixed or tied.
        features: at rest and in decays.
        begin: scaled parameters after the three steps, in `whole`.
        refined: of the scaled parameters that are left.
        duration: wall time, s.
    """

    machine: Machine
    predictor: Predictor
    whole: Parameterisation
    identified: Identifiability
    fixed: tuple[str, ...]
    features: Features
    begin: Array
    refined: Refined
    duration: float

    @property
    def variant(self) -> Variant:
        """The calibrated machine and the zero offsets."""
        return self.refined.variant

    @property
    def nominal(self) -> Variant:
        """The machine as its file has it, with the zero offsets that were found."""
        return Variant(self.machine, self.variant.offsets)

    @property
    def scaled(self) -> Array:
        """In the whole parameterisation, (whole.size,)."""
        return self.refined.free.gathering(self.whole) @ self.refined.scaled

    @property
    def deviation(self) -> Array:
        """Of every scaled parameter of the whole parameterisation; NaN where one is held, (whole.size,)."""
        gathering = self.refined.free.gathering(self.whole)
        return np.where(gathering.any(axis=1), gathering @ self.refined.deviation, np.nan)


def calibrate(
    machine: Machine,
    recordings: Sequence[Recording],
    kinds: Sequence[str] = USUAL,
    threads: int | None = None,
    tell: Callable[[str], None] = lambda line: None,
) -> Calibration:
    """Calibrate a machine on recordings.

    Args:
        kinds: parameters that may move.
        threads: simulations at a time.
        tell: hears one line per stage.

    Raises:
        LogError: the recordings tell nothing of these parameters.
    """
    with threadpool_limits(1):  # simulations have the cores
        began = perf_counter()
        whole = make_parameterisation(machine, kinds)
        predictor = predictor_of(machine, recordings, threads)
        tables = [predictor.data.table(index) for index in range(len(recordings))]
        features = features_of(tables, Variant(machine))
        tell(f"{len(features.rests)} rests and {len(features.releases)} releases in {len(recordings)} recordings")
        begin = initial_estimate(features, whole, tell)
        tell(f"sensitivities of {len(whole.tied)} parameters and {JOINTS} zero offsets")
        error = model_error(predictor, whole.at(begin))
        jacobian = sensitivities(predictor, whole, begin, error[1])
        identified = identify(jacobian, whole)
        free, fixed = simplify(jacobian, whole)
        for sentence in fixed:
            tell(sentence)
        if not free.tied:
            raise LogError(f"these recordings tell nothing of {', '.join(kinds)}")
        gathering = free.gathering(whole)
        share = gathering / gathering.sum(axis=0)
        refined = refine(predictor, free, share.T @ begin, error, jacobian @ gathering, ROUGH, tell)
        tell("again, with the model's own error taken where that has led")
        error = model_error(predictor, refined.variant)
        refined = refine(predictor, free, refined.scaled, error, refined.weighted(error[1].weight), tell=tell)
        found = Calibration(
            machine, predictor, whole, identified, fixed, features, begin, refined, perf_counter() - began
        )
        tell(f"done in {found.duration:.0f} s, {predictor.simulated_s:.0f} s simulated: {refined.status}")
        return found
