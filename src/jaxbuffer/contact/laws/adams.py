"""The IMPACT function of MSC Adams and its STEP."""

from typing import ClassVar

import jax.numpy as jnp

from ..._types import Scalar, Values
from .base import ContactLaw, power, root


def step(x: Values, start: Scalar, start_value: Scalar, end: Scalar, end_value: Scalar) -> Values:
    """Return the function STEP, a cubic between two constants, in the shape of ``x`` (M52).

    **Arguments:** ``x``; ``start``, ``end``: where the cubic begins and ends, in the unit of ``x``; ``start_value``,
    ``end_value``: the constants before and after.
    """
    part = jnp.clip((x - start) / (end - start), 0.0, 1.0)
    return start_value + (end_value - start_value) * part * part * (3.0 - 2.0 * part)


class AdamsImpact(ContactLaw):
    """The function IMPACT: the damper comes in over the first ``ramp_depth`` of penetration (M51).

    - ``stiffness``: K [N/mⁿ].
    - ``exponent``: n ≥ 1 [-].
    - ``damping``: c [N s/m].
    - ``ramp_depth``: d [m].
    """

    source: ClassVar[str] = "MSC Adams, IMPACT and STEP"
    validity: ClassVar[str] = "fitted case by case; e depends on mass and speed"
    unit: ClassVar[str] = "N/m^exponent"
    stiffness: Scalar
    exponent: Scalar
    damping: Scalar
    ramp_depth: Scalar

    def elastic(self, penetration: Values) -> Values:
        return self.stiffness * power(penetration, self.exponent)

    def energy(self, penetration: Values) -> Values:
        return self.elastic(penetration) * penetration / (self.exponent + 1.0)

    def depth(self, force: Scalar) -> Scalar:
        return root(force / self.stiffness, self.exponent)

    def force(self, penetration: Values, approach_speed: Values, touchdown_speed: Values) -> Values:
        damper = self.damping * approach_speed * step(penetration, 0.0, 0.0, self.ramp_depth, 1.0)
        return jnp.maximum(0.0, self.elastic(penetration) + damper)

    def time_scale(self, mass: Scalar, speed: Scalar) -> Scalar:
        n = self.exponent
        elastic = (mass * speed ** (1.0 - n) / self.stiffness) ** (1.0 / (n + 1.0))
        return 1.0 / (1.0 / elastic + self.damping / mass)
