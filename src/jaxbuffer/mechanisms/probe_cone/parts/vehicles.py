"""The vehicles, and the cone on the passive one."""

import math
from typing import Any, ClassVar

from ...._types import Scalar
from ....fields import NON_NEGATIVE, POSITIVE, Number, Part, number
from ....suggestions import same_word
from ...view import Synonym

SAME = 1e-9  # relative: a ball of the throat's own radius passes
ACTIVE = Synonym("active", "the active vehicle S, which carries the probe")
PASSIVE = Synonym("passive", "the passive vehicle T, which carries the cone")
OTHER_NAMES = {"chaser": ACTIVE, "servicer": ACTIVE, "target": PASSIVE, "client": PASSIVE}
same_word("active", "chaser", "servicer")
same_word("passive", "target", "client")


class Active(Part):
    """The active vehicle S, which carries the probe."""

    section: ClassVar[str] = "active"
    mass: Number = number(21.9706, "kg", **POSITIVE, doc="mass m_S of the active vehicle")
    inertia: Number = number(0.445, "kg m²", **POSITIVE, doc="inertia I_S about its centre of mass")
    hinge_offset: Number = number(0.1365, "m", **NON_NEGATIVE, doc="a, from its centre of mass forward to the hinge")


class Passive(Part):
    """The passive vehicle T, which carries the cone."""

    section: ClassVar[str] = "passive"
    mass: Number = number(23.5731, "kg", **POSITIVE, doc="mass m_T of the passive vehicle")
    inertia: Number = number(0.5206, "kg m²", **POSITIVE, doc="inertia I_T about its centre of mass")


class Cone(Part):
    """The cone on the passive vehicle (M30)."""

    section: ClassVar[str] = "cone"
    half_angle: Number = number(
        math.pi / 4, "rad", low=0.0, high=math.pi / 2, low_open=True, high_open=True, doc="half angle β of the cone"
    )
    offset: Number = number(
        0.096, "m", **NON_NEGATIVE, doc="L_T, from the throat plane to the passive vehicle's centre of mass"
    )
    throat_radius: Number = number(0.015, "m", **POSITIVE, doc="radius R_c of the throat")
    length: Number = number(0.0735, "m", **POSITIVE, doc="slant length L_c of the cone")
    young_modulus: Number = number(
        None, "Pa", **POSITIVE, doc="Young's modulus of the cone; not set: contact.young_modulus"
    )
    poisson_ratio: Number = number(
        None,
        "-",
        low=-1.0,
        high=0.5,
        low_open=True,
        doc="Poisson's ratio of the cone; not set: contact.poisson_ratio",
    )

    def reach(self, radius: Scalar) -> float:
        """Return how far behind the capture plane the centre of a ball of a ``radius`` [m] comes at most [m] (M65): of
        one that wedges in the cone before it less than zero, of one that passes the throat infinity."""
        ball, throat, angle = float(radius), float(self.throat_radius), float(self.half_angle)
        if ball <= throat * (1.0 + SAME):
            return math.inf
        # On the axis the ball touches both flanks at the slant distance b of M64, which is b cos β before the capture
        # plane.
        short = (ball * math.cos(angle) - throat) / math.tan(angle)
        if short > 0.0:
            return -short
        # On the throat's edges its centre is √(R² - R_c²) before the throat plane, and the capture plane R sin β before
        # it.
        return ball * math.sin(angle) - math.sqrt(ball**2 - throat**2)


def reduced_mass(design: Any) -> Scalar:
    """Return the reduced mass of the two sides of a docking [kg]."""
    active = design.active.mass + design.buffer.cylinder_mass + design.probe.rod_mass + design.probe.tip_mass
    return active * design.passive.mass / (active + design.passive.mass)
