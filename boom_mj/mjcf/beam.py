"""A clamped link as an MJCF model: a chain of rigid segments joined by the equivalent hinges that booms are made of."""

import mujoco
import numpy as np

from boom_mj.machine import Beam
from boom_mj.mjcf import scene
from boom_mj.mjcf.builder import set_inertia, stable_step
from boom_mj.mjcf.hinges import link_chains, seams
from boom_mj.mjcf.inertia import segment_inertias
from boom_mj.mjcf.rayleigh import in_tune


def build_beam(beam: Beam, hinges: int = 1) -> mujoco.MjSpec:
    """MuJoCo specification of a beam with `hinges` equivalent hinges.

    Hinges LINK/1, LINK/2, .. root outward; sites and position sensors of the markers, site `tip`. Bodies carry the
    link-tip frame, as those of a boom do.
    """
    spec, link, clamp = mujoco.MjSpec(), beam.links[0], beam.clamp
    spec.modelname = beam.name
    spec.compiler.degree = False
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    along, up = np.array(clamp.along), np.array(clamp.up)
    spec.option.gravity = -beam.gravity * up
    turn = np.empty(4)
    mujoco.mju_mat2Quat(turn, np.stack([along, up, np.cross(along, up)], axis=1).ravel())

    chains = link_chains(beam, 0, hinges, ("v", "w"))
    if hinges == 1:
        (chains,) = in_tune(beam, (chains,))
    cuts = [seam.place for seam in seams(link, chains)]
    edges, carried = [-link.length, *cuts, 0.0], np.searchsorted(cuts, [marker.position[0] for marker in beam.marker])
    body = spec.worldbody
    for k, inertia in enumerate(segment_inertias(beam, 0, chains)):
        if k == 0:
            body = body.add_body(name=link.name, pos=np.array(clamp.position) + link.length * along, quat=turn)
        else:
            body, hinge = body.add_body(name=f"{link.name}_{k + 1}"), chains["v"].hinges[k - 1]
            joint = body.add_joint(name=f"{link.name}/{k}", pos=[hinge.position, 0, 0], axis=[0, 0, 1])
            joint.stiffness[0], joint.damping[0] = hinge.stiffness, hinge.damping
        set_inertia(body, inertia)
        scene.draw_segment(spec, body, beam, 0, k, edges[k], edges[k + 1])
        for marker in (marker for marker, segment in zip(beam.marker, carried) if segment == k):
            body.add_site(name=marker.name, pos=marker.position, size=[0.02 * link.length, 0, 0], rgba=[1, 0.85, 0, 1])
    body.add_site(name="tip", size=[0.02 * link.length, 0, 0], rgba=[0.9, 0.2, 0.1, 1])
    for marker in beam.marker:
        site, position = mujoco.mjtObj.mjOBJ_SITE, mujoco.mjtSensor.mjSENS_FRAMEPOS
        spec.add_sensor(name=marker.name, type=position, objtype=site, objname=marker.name)
    spec.option.timestep = stable_step(spec, beam)
    return spec
