"""The bodies of the docking in space: active vehicle S, cylinder B, probe P with its tip, passive vehicle T."""

from ..._types import Scalar
from ...multibody import Body, Prismatic, System, Universal
from ...space import SPACE
from ..probe_cone.bodies import B, Masses, P, S
from .design import Design3D

SHARE = 0.5  # of the probe's roll inertia


def assemble_system(design: Design3D, probe: Masses, stabilisation: Scalar) -> System:
    """Return bodies and joints: a universal joint between S and B, first about y of S and then about z of B; P slides
    along B without turning.

    **Arguments:** ``design``; ``probe``: masses and lengths of the probe; ``stabilisation``: Baumgarte's gain [1/s].
    """
    length, mass = design.buffer.cylinder_length, design.buffer.cylinder_mass
    across = mass * length**2 / 12
    # A slender rod has no inertia about its axis, and M must be regular. B and P never turn against each other, so
    # that only the sum of their roll inertias matters: B has a share of P's, and the motion is the same.
    roll = 0.5 * design.probe.rod_mass * design.probe.rod_radius**2
    roll = roll if design.probe.free_tip else roll + design.probe.tip_inertia
    hinge = Universal(S, B, first_point=(design.active.hinge_offset, 0.0), second_point=(length / 2, 0.0))
    return System(
        bodies=(
            Body(design.active.mass, (design.active.roll_inertia, design.active.inertia, design.active.inertia)),
            Body(mass, (SHARE * roll, across, across)),
            Body(probe.mass, ((1.0 - SHARE) * roll, probe.inertia, probe.inertia)),
            Body(design.passive.mass, (design.passive.roll_inertia, design.passive.inertia, design.passive.inertia)),
        ),
        joints=(hinge, Prismatic(B, P)),
        stabilisation=stabilisation,
        basis=SPACE,
    )
