"""The boom of a machine file in Exudyn: geometrically exact beams, joints on a prescribed path.

Every link is a chain of ObjectBeamGeometricallyExact with the sections of the elements' middles; lateral offsets sit at
the joints, as rigid levers. Link 2 is pinned at its root and held by the cylinder at its support.
"""

from collections.abc import Callable
from itertools import pairwise

import exudyn
import numpy as np
from exudyn.itemInterface import (
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyRigid,
    MarkerNodeRigid,
    NodeRigidBodyEP,
    ObjectBeamGeometricallyExact,
    ObjectGround,
    ObjectJointGeneric,
    ObjectRigidBody,
    SensorBody,
)
from exudyn.utilities import RotationMatrix2EulerParameters
from scipy.spatial.transform import Rotation

from boom_mj.machine import Link, Machine, sections

Array = np.ndarray
JointPath = Callable[[float], Array]
"""Time, s, to q1..q5, (5,), rad."""
ELEMENTS = 6  # per link
SHEAR = 0.4  # share of a box section that carries shear
YOUNGS_MODULUS = 210e9  # Pa, along and across the steel; the machine file's moduli are those of bending and torsion
SHEAR_MODULUS = 80e9
LOCKED, PINNED, GUIDED = [1, 1, 1, 1, 1, 1], [1, 1, 1, 1, 1, 0], [0, 1, 0, 0, 0, 0]
UPRIGHT = Rotation.from_euler("x", 90, degrees=True)  # world from link axes: y up, z to the right


class ExudynBoom:
    """The boom at rest at the start of its path; `run` moves it on."""

    def __init__(self, machine: Machine, path: JointPath) -> None:
        self.machine, self.path = machine, path
        self.container = exudyn.SystemContainer()
        self.system = self.container.AddSystem()
        add, start = self.system, path(0.0)
        place, turned = (
            np.array([0.0, 0.0, machine.slewing.pivot_height]),
            UPRIGHT * Rotation.from_euler("YZ", start[:2]),
        )
        ground = add.AddObject(ObjectGround(referencePosition=list(place), referenceRotation=UPRIGHT.as_matrix()))
        hub = self._body(self._node(place, turned), 1.0)
        self._join(self._on_body(ground), self._on_body(hub), LOCKED, lambda q: [0.0, q[0], q[1]])
        before, lever = hub, np.zeros(3)
        for k, link in enumerate(machine.links):
            if k:
                turned = turned * Rotation.from_euler("z", start[k + 1])
            edges = _edges(link)
            nodes = [self._node(place + turned.apply([x + link.length, 0, 0]), turned) for x in edges]
            self._beams(link, edges, nodes)
            root, base = add.AddMarker(MarkerNodeRigid(nodeNumber=nodes[0])), self._on_body(before, lever)
            if link.support is None:
                self._join(base, root, LOCKED, lambda q, k=k: [0.0, 0.0, q[k + 1]])
            else:
                pin = add.AddMarker(MarkerNodeRigid(nodeNumber=nodes[int(np.argmin(np.abs(edges - link.support)))]))
                self._join(base, root, PINNED, lambda q: [0.0, 0.0, 0.0])
                self._join(self._on_body(hub, [link.length + link.support, 0, 0]), pin, GUIDED, lambda q: [0.0] * 3)
            for x, mass in machine.masses_on_link[k]:
                before = self._body(nodes[int(np.argmin(np.abs(edges - x)))], mass)
            before = self._body(nodes[-1], 1e-3)
            lever = np.array([0.0, 0.0, link.offset])
            place = place + turned.apply([link.length, 0, link.offset])
        self.tip = add.AddSensor(
            SensorBody(
                bodyNumber=before,
                localPosition=list(lever),
                storeInternal=True,
                outputVariableType=exudyn.OutputVariableType.Position,
            )
        )
        add.Assemble()
        self.settings = exudyn.SimulationSettings()
        self.settings.linearSolverType = exudyn.LinearSolverType.EigenSparse
        self.settings.solutionSettings.writeSolutionToFile = False
        self.settings.staticSolver.loadStepDuration = 1e-9  # s: the joints stay where they start
        self.settings.staticSolver.verboseMode = 0
        add.SolveStatic(self.settings, updateInitialValues=True)

    def run(self, duration: float, step: float) -> Array:
        """Move from rest by generalised-alpha integration; both in s. Tip at the steps, (n, 4): t, x, y, z."""
        integration = self.settings.timeIntegration
        integration.endTime, integration.numberOfSteps = duration, round(duration / step)
        integration.generalizedAlpha.spectralRadius = 0.8
        self.settings.solutionSettings.sensorsWritePeriod = step
        self.system.SolveDynamic(self.settings)
        return self.system.GetSensorStoredData(self.tip)

    def _node(self, place: Array, turned: Rotation) -> int:
        return self.system.AddNode(
            NodeRigidBodyEP(referenceCoordinates=[*place, *RotationMatrix2EulerParameters(turned.as_matrix())])
        )

    def _body(self, node: int, mass: float) -> int:
        """A small body on a node, with its weight."""
        body = self.system.AddObject(ObjectRigidBody(nodeNumber=node, mass=mass, inertia=[mass * 1e-3] * 3 + [0.0] * 3))
        return self._weigh(body)

    def _weigh(self, body: int) -> int:
        marker = self.system.AddMarker(MarkerBodyMass(bodyNumber=body))
        self.system.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=[0, 0, -self.machine.gravity]))
        return body

    def _on_body(self, body: int, place: Array = (0.0, 0.0, 0.0)) -> int:
        return self.system.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=list(place)))

    def _beams(self, link: Link, edges: Array, nodes: list[int]) -> None:
        for x, length, pair in zip((edges[1:] + edges[:-1]) / 2, np.diff(edges), pairwise(nodes)):
            height, width, wall = (sections.linear(sides, link, x) for sides in (link.height, link.width, link.wall))
            area = 2 * wall * (height + width - 2 * wall)
            moments = sections.second_moment_y(link, x), sections.second_moment_z(link, x)
            inertia = sections.line_rotary_inertia(link, x) * np.array([1, *(moments[::-1] / np.sum(moments))])
            section = exudyn.BeamSection()
            section.massPerLength, section.inertia = float(sections.line_mass(link, x)), np.diag(inertia)
            shear = SHEAR * SHEAR_MODULUS * area
            bending = sections.bending_stiffness_w(link, x), sections.bending_stiffness_v(link, x)  # about y, about z
            stiffness = [YOUNGS_MODULUS * area, shear, shear, sections.torsional_stiffness(link, x), *bending]
            section.stiffnessMatrix = np.diag(stiffness)
            section.dampingMatrix = self.machine.damping.relaxation_time * np.diag(stiffness)
            beam = ObjectBeamGeometricallyExact(nodeNumbers=list(pair), length=length, sectionData=section)
            self._weigh(self.system.AddObject(beam))

    def _join(self, a: int, b: int, axes: list[int], turn: Callable[[Array], list[float]]) -> None:
        def offset(system: object, time: float, item: int, parameters: list[float]) -> list[float]:
            return [0.0, 0.0, 0.0, *turn(self.path(time))]

        self.system.AddObject(ObjectJointGeneric(markerNumbers=[a, b], constrainedAxes=axes, offsetUserFunction=offset))


def _edges(link: Link) -> Array:
    """Where elements meet, x, m; the support is such a place."""
    if link.support is None:
        return np.linspace(-link.length, 0, ELEMENTS + 1)
    return np.concatenate([[-link.length], np.linspace(link.support, 0, ELEMENTS)])
