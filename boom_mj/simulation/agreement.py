"""Do both models agree? MuJoCo's hinges against the Lagrangian reference, over random poses.

Relative differences are taken against the reference's own value, or against a tenth of the stretched boom's where
that is larger: a folded boom hardly bends, and a hundredth of nothing says nothing. The paper's elastic kinematics are
linear, the hinges turn by finite angles; the same comparison against the reference with finite rotations shows what is
left when both make the same assumption.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from boom_mj.errors import EquilibriumError, numbers_of
from boom_mj.machine import Machine
from boom_mj.reference import ReferenceModel, Simplifications
from boom_mj.simulation.plant import JOINTS, Plant, make_plant

Array = np.ndarray
LOAD = np.array([0.0, 0.0, -981.0])  # N, 100 kg on a rope
MODES = 4
FLOOR = 0.1
FIGURES = ("sag", "load_change", *(f"mode{k + 1}" for k in range(MODES)))


@dataclass(frozen=True)
class Agreement:
    """Relative differences MuJoCo / reference - 1 of one hinge count, (poses, 6) in the order of `FIGURES`.

    Attributes:
        paper: against the reference with the paper's simplifications.
        finite: against the reference with finite elastic rotations.
        mass_entries: worst entries of the mass matrix in Ritz coordinates: names, and difference over the root of the
            product of the diagonal entries.
    """

    hinges: int
    poses: Array
    paper: Array
    finite: Array
    mass_entries: tuple[tuple[str, str, float], ...]


def random_poses(machine: Machine, count: int, seed: int) -> Array:
    """Joint angles uniform within the limits, (count, 5), rad."""
    low, high = np.array([drive.range for drive in machine.drives]).T
    return np.random.default_rng(seed).uniform(low, high, (count, JOINTS))


def compare_models(
    machine: Machine, hinges: int, poses: Array, progress: Callable[[int], None] = lambda done: None
) -> Agreement:
    """Statics and modes of both models at every pose.

    Raises:
        EquilibriumError: a pose without rest.
    """
    with numbers_of(machine.name, EquilibriumError):
        return _compared(machine, hinges, poses, progress)


def _compared(machine: Machine, hinges: int, poses: Array, progress: Callable[[int], None]) -> Agreement:
    plant = make_plant(machine, hinges)
    references = (ReferenceModel(machine), ReferenceModel(machine, Simplifications(linear_kinematics=False)))
    floors = [FLOOR * _reference_figures(reference, np.zeros(JOINTS))[:2] for reference in references]
    rows: tuple[list[Array], list[Array]] = ([], [])
    for number, joints in enumerate(poses):
        found = _plant_figures(plant, joints)
        for reference, floor, differences in zip(references, floors, rows):
            wanted = _reference_figures(reference, joints)
            scale = np.concatenate([np.maximum(wanted[:2], floor), wanted[2:]])
            differences.append((found - wanted) / scale)
        progress(number + 1)
    entries = _mass_entries(references[0], plant, poses)
    return Agreement(hinges, poses, np.array(rows[0]), np.array(rows[1]), entries)


def _reference_figures(reference: ReferenceModel, joints: Array) -> Array:
    rest = reference.static_equilibrium(joints)
    straight = np.concatenate([joints, np.zeros(rest.size - JOINTS)])
    tip = reference.tip(rest)[0]
    sag = np.linalg.norm(tip - reference.tip(straight)[0])
    change = np.linalg.norm(reference.tip(reference.static_equilibrium(joints, LOAD))[0] - tip)
    return np.array([sag, change, *reference.modes(rest).frequency[:MODES]])


def _plant_figures(plant: Plant, joints: Array) -> Array:
    rest, straight = plant.static_equilibrium(joints), np.zeros(plant.model.nq)
    straight[plant.joints] = joints
    tip = plant.tip(rest)
    change = np.linalg.norm(plant.tip(plant.static_equilibrium(joints, LOAD)) - tip)
    return np.array([np.linalg.norm(tip - plant.tip(straight)), change, *plant.modes(rest).frequency[:MODES]])


def ritz_mass_matrix(plant: Plant, joints: Array) -> Array:
    """MuJoCo's mass matrix at the straight boom, in the coordinates q1..q5, qa2, qv2, .., (17, 17)."""
    straight, columns = np.zeros(plant.model.nq), np.zeros((plant.model.nv, JOINTS))
    straight[plant.joints] = joints
    columns[plant.joints, np.arange(JOINTS)] = 1
    basis = np.hstack([columns, plant.boom.shape_matrix(plant.model)])
    return basis.T @ plant.mass_matrix(straight) @ basis


def _mass_entries(reference: ReferenceModel, plant: Plant, poses: Array) -> tuple[tuple[str, str, float], ...]:
    """The five entries that differ most, at their worst pose."""
    worst = np.zeros((17, 17))
    for joints in poses:
        wanted = reference.mass_matrix(np.concatenate([joints, np.zeros(12)]))
        size = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
        error = (ritz_mass_matrix(plant, joints) - wanted) / size
        worst = np.where(np.abs(error) > np.abs(worst), error, worst)
    return tuple(_largest(worst, reference.coordinates, 5))


def _largest(matrix: Array, names: tuple[str, ...], count: int) -> Iterator[tuple[str, str, float]]:
    upper = np.triu(np.abs(matrix))
    for index in np.argsort(upper, axis=None)[::-1][:count]:
        row, column = np.unravel_index(index, matrix.shape)
        yield names[row], names[column], float(matrix[row, column])
