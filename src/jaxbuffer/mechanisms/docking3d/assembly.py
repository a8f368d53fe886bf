"""The docking in space assembled from bodies, joints, elements and a ball in a cone."""

import jax.numpy as jnp

from ..._types import Scalar, stacked
from ...contact import Revolved
from ...multibody import CrossSpringDamper
from ..assembled import Assembled
from ..probe_cone.assembly import (
    GAIN_WHERE_HELD,
    LISTED,
    UPPER_SIDE,
    Parts,
    elements_of,
    flank,
    tip_against,
    tip_in_cone,
)
from ..probe_cone.bodies import B, S, probe_masses
from ..probe_cone.parts import holder_of
from .bodies import assemble_system
from .design import Design3D, Scenario3D
from .observables import recorded_of, shown_of
from .start import start_motion

CONTACTS = ("cone",)
LISTED_IN_SPACE = (LISTED[0], ("stop_damper",))  # a hinge with play and a probe that bends are of the plane
BODIES = 4


def assemble(design: Design3D, scenario: Scenario3D, stabilisation: Scalar = 20.0) -> Assembled:
    """Return a design in a scenario as a mechanism that is ready to be stepped through time.

    **Arguments:** ``design``; ``scenario``; ``stabilisation``: Baumgarte's gain [1/s].
    """
    probe, speed, mass = probe_masses(design), scenario.approach_speed, design.active.mass
    holder = holder_of(design)
    q, v = start_motion(design, scenario, probe)
    # The cone is the upper flank, turned about its axis.
    cone = tip_against(design, Revolved(flank(design, UPPER_SIDE)), UPPER_SIDE)
    tip = tip_in_cone(design, scenario, probe, cone, CONTACTS)
    hinge = CrossSpringDamper(S, B, design.buffer.k_T, design.buffer.c_T)
    # As in the plane; a quaternion's numbers are half an angle.
    length, turn = 1e-3, 0.5e-3 / 0.1
    return Assembled(
        system=assemble_system(design, probe, stabilisation if holder is None else GAIN_WHERE_HELD * stabilisation),
        q=q,
        v=v,
        elements=(tip, *elements_of(design, scenario, probe, tip, hinge)),
        rest_threshold=None if holder is None else holder.rest_threshold(design),
        size=(
            jnp.asarray([*[length] * 3, *[turn] * 4] * BODIES),
            stacked([*[speed] * 3, *[speed / 0.1] * 3] * BODIES),
        ),
        speed=speed,
        energy_size=0.5 * mass * speed**2,
        momentum_size=mass * speed,
        shown=shown_of(design, scenario),
        recorded=recorded_of(design),
        parts=Parts(design, scenario, probe),
        stored_in="spring",
        lost_in=None,
        listed=LISTED_IN_SPACE,
        impulsive_reactions=False,
    )
