"""Features of recordings and of a model: forces and places at rest, falls of the markers, frequencies, damping ratios.

They need no simulation over time, so that a machine far from its file is soon brought near. Deviations hold what the
sensors scatter and what a model without finest hinges lacks.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from boom_mj.calibration.evidence import COARSE, MIDDLE
from boom_mj.calibration.parameters import Variant
from boom_mj.calibration.release import Release, Rest, excited_modes, first_rest, release_of
from boom_mj.estimation.channels import Table
from boom_mj.machine import cylinder_forces
from boom_mj.simulation import make_plant

Array = np.ndarray
FORCE, PLACE, FALL = 0.003, 0.01, 5e-4  # least deviations: share of a force, m, m
FREQUENCY, SECOND, RATIO = 0.001, 0.01, 0.03  # of logarithms: first mode, second, damping ratio

Values = Mapping[str, Array]


@dataclass(frozen=True)
class Features:
    """What some recordings say at rest and in their decays.

    Attributes:
        rests: those at the begin of a recording and those after a load.
        releases: ends of a load.
        measured, deviation: by kind: "forces", "places", "falls", "frequencies", "damping".
    """

    rests: tuple[Rest, ...]
    releases: tuple[Release, ...]
    measured: Values
    deviation: Values

    def of(self, variant: Variant, hinges: int) -> Values:
        """The same features of a model."""
        plant = make_plant(variant.machine, hinges)
        offsets, machine = np.array(variant.offsets), variant.machine

        @cache
        def at_rest(joints: tuple[float, ...], load: tuple[float, ...]) -> Array:
            return plant.static_equilibrium(np.array(joints) - offsets, np.array(load))

        def pose(rest: Rest) -> Array:
            return at_rest(tuple(rest.joints), tuple(rest.load))

        torques = [plant.static_torques(pose(rest), rest.load) for rest in self.rests]
        forces = [cylinder_forces(machine, rest.joints - offsets, torque) for rest, torque in zip(self.rests, torques)]
        loaded = np.array([plant.markers(pose(release.before)).ravel() for release in self.releases])
        free = np.array([plant.markers(pose(release.after)).ravel() for release in self.releases])
        frequencies, ratios = [], []
        for release in self.releases:
            numbers, modes = excited_modes(plant, pose(release.after), pose(release.before))
            frequencies += list(np.log(modes.frequency[np.sort(numbers)]))
            ratios += list(np.log(modes.damping_ratio[np.sort(numbers)]))
        return {
            "forces": np.array(forces).ravel(),
            "places": free.ravel(),
            "falls": (free - loaded).ravel(),
            "frequencies": np.array(frequencies),
            "damping": np.array(ratios),
        }

    def correction(self, variant: Variant) -> Values:
        """What finer hinges add to the features of a coarse model."""
        fine, coarse = self.of(variant, MIDDLE.hinges), self.of(variant, COARSE.hinges)
        return {kind: fine[kind] - coarse[kind] for kind in fine}


def features_of(tables: Sequence[Table], nominal: Variant) -> Features:
    """Features of all recordings.

    Args:
        nominal: says near which frequencies to look.
    """
    plant = make_plant(nominal.machine, COARSE.hinges)
    found = [release_of(table, k, plant) for k, table in enumerate(tables)]
    releases = tuple(release for release in found if release is not None)
    begins = [first_rest(table) for table in tables]
    rests = (*(rest for rest in begins if rest is not None), *(release.after for release in releases))
    forces = np.array([rest.cylinders for rest in rests]).ravel()
    ratio = [np.hypot(r.decay.damping_deviation, [RATIO, 3 * RATIO]) for r in releases]
    frequency = [np.hypot(r.decay.frequency_deviation, [FREQUENCY, SECOND]) for r in releases]
    return Features(
        rests=rests,
        releases=releases,
        measured={
            "forces": forces,
            "places": np.array([r.place for r in releases]).ravel(),
            "falls": np.array([r.fall for r in releases]).ravel(),
            "frequencies": np.log([r.decay.frequency for r in releases]).ravel(),
            "damping": np.log([r.decay.damping_ratio for r in releases]).ravel(),
        },
        deviation={
            "forces": np.hypot(np.array([rest.deviation for rest in rests]).ravel(), FORCE * np.abs(forces)),
            "places": np.hypot(np.array([r.place_deviation for r in releases]).ravel(), PLACE),
            "falls": np.hypot(np.array([r.fall_deviation for r in releases]).ravel(), FALL),
            "frequencies": np.array(frequency).ravel(),
            "damping": np.array(ratio).ravel(),
        },
    )
