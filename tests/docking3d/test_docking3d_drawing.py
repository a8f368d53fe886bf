"""Where the contact force of a docking in space is drawn, without a run."""

from types import SimpleNamespace

import numpy as np
from scipy.spatial.transform import Rotation

from jaxbuffer import docking3d
from jaxbuffer.mechanisms.docking3d.drawing import TIP_FORCE, arrows
from jaxbuffer.mechanisms.probe_cone.bodies import P, T, probe_masses


def test_the_force_acts_on_the_flank_and_is_seen_from_both_sides():
    """The ball touches the flank at a slant of 40 mm, anywhere about the axis; SciPy turns the cone."""
    design, slant, around = docking3d(), 0.04, np.array([np.cos(0.7), np.sin(0.7)])
    cone, front = design.cone, float(probe_masses(design).front)
    cos, sin = np.cos(cone.half_angle), np.sin(cone.half_angle)
    rho = cone.throat_radius + slant * sin
    foot = np.array([-cone.offset - slant * cos, *(rho * around)])
    centre = foot + design.probe.tip_radius * np.array([-sin, *(-cos * around)])
    carrier, probe, origin = (
        Rotation.from_rotvec([0.5, -0.1, 0.2]),
        Rotation.from_rotvec([0.1, 0.2, 0.0]),
        [0.3, 0.1, 2],
    )
    position, force = np.zeros((1, 4, 6)), np.array([3.0, -4.0, 5.0])
    position[0, T] = [*origin, *carrier.as_rotvec()]
    position[0, P] = [*(origin + carrier.apply(centre) - probe.apply([front, 0.0, 0.0])), *probe.as_rotvec()]
    others = {name: force[k : k + 1] for k, name in enumerate(TIP_FORCE)}
    from_side, along = arrows(design, SimpleNamespace(position=position, others=others), front)[0, :, 0]
    np.testing.assert_allclose(from_side, [*(origin + carrier.apply(foot))[:2], 3.0, -4.0], atol=1e-12)
    _, y, z = carrier.inv().apply(force)
    np.testing.assert_allclose(along, [foot[2], foot[1], z, y], atol=1e-12)
