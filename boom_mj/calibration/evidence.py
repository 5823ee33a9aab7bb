"""Recordings that a machine is calibrated on, and what it would have said, with the model's own error."""

from collections.abc import Sequence

import numpy as np

from boom_mj.calibration.parameters import Variant
from boom_mj.errors import LogError
from boom_mj.estimation.noise import NoiseModel, noise_model
from boom_mj.machine import Machine
from boom_mj.recording import Recording
from boom_mj.sensors import check_drivable
from boom_mj.systems.boom import BoomSystem
from boom_mj.systems.fidelity import Level
from boom_mj.systems.predictor import Predictor, dataset_of

Array = np.ndarray
COARSE, MIDDLE, FINE = Level(2.0, 2), Level(1.0, 3), Level(1.0, 4)  # of secants, of what is compared, of its correction


def predictor_of(machine: Machine, recordings: Sequence[Recording], threads: int | None = None) -> Predictor:
    """Of recordings whose joint angles drive the model.

    Args:
        machine: for rates and noise.
        threads: simulations at a time.

    Raises:
        LogError: there is no recording, or nothing in one to compare.
    """
    if not recordings:
        raise LogError("a calibration needs at least one recording")
    for log in recordings:
        check_drivable(log)
    system = BoomSystem(machine)
    data = dataset_of(system, recordings, len(recordings))
    for index, log in enumerate(recordings):
        if not any(np.isfinite(channel.measured).any() for channel in data.of(index)):
            raise LogError(f"log {log.name!r} has nothing to compare with a model but its joint angles")
    return Predictor(system, data, threads)


def predict(predictor: Predictor, variants: Sequence[Variant], level: Level) -> list[Array]:
    """The long vector of every variant, (N,) each; NaN where a simulation failed."""
    return predictor.predict([variant.hypothesis for variant in variants], level)


def model_error(predictor: Predictor, variant: Variant) -> tuple[Array, NoiseModel]:
    """What finer hinges add to the prediction, (N,), and the noise with a share of it."""
    usual, fine = (predict(predictor, [variant], level)[0] for level in (MIDDLE, FINE))
    change = fine - usual
    return change, noise_model(predictor.data, np.nan_to_num(change)[None], along_share=0.0)
