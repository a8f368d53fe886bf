"""The rod of the probe with its ball tip."""

import math

import equinox as eqx

from ...._types import Scalar
from ....fields import POSITIVE, Number, Part, number

ALUMINIUM_DENSITY = 2740.0  # kg/m³, the paper's section 7
ROD_RADIUS = 0.009  # m, r_p of Table 2
TIP_RADIUS = 0.015  # m, R_tip of Table 2
PROBE_LENGTH = 0.2  # m, L_P of Table 2
ROD_WIDTH, CYLINDER_WIDTH = 0.8, 2.6  # of the tip's radius, in drawings; assumed


class RodFields(Part):
    """The rod and its ball tip, welded to the rod or spinning freely about its centre (M6, M8); default masses: M7."""

    length: Number = number(PROBE_LENGTH, "m", **POSITIVE, doc="L_P, from the rod's rear end to the tip's centre")
    rod_mass: Number = number(
        ALUMINIUM_DENSITY * math.pi * ROD_RADIUS**2 * PROBE_LENGTH, "kg", **POSITIVE, doc="mass m_r of the rod"
    )
    tip_radius: Number = number(TIP_RADIUS, "m", **POSITIVE, doc="radius R of the ball tip")
    tip_mass: Number = number(
        ALUMINIUM_DENSITY * 4.0 / 3.0 * math.pi * TIP_RADIUS**3, "kg", **POSITIVE, doc="mass m_t of the ball tip"
    )
    free_tip: bool = eqx.field(
        default=False, static=True, metadata={"doc": "whether the tip spins freely about its centre", "flag": True}
    )

    @property
    def tip_inertia(self) -> Scalar:
        """Return I_t of the tip about its centre [kg m²] (M6)."""
        return 0.4 * self.tip_mass * self.tip_radius**2
