"""IMPACT with an onset, so that it can be solved for exponents below 1 as well."""

from typing import ClassVar

import jax.numpy as jnp

from ..._types import Scalar, Values
from ...contact.laws import AdamsImpact, ContactLaw


class BluntImpact(AdamsImpact):
    """IMPACT (M51) whose spring is k δ (δ² + ε²)^{(e-1)/2}: k δ^e from some onset depths ε on.

    With e < 1 the slope of k δ^e is infinite at touchdown, which no step can follow; here it is k ε^{e-1}.

    - ``stiffness``: k [N/m^e].
    - ``exponent``: e > 0 [-].
    - ``damping``: c [N s/m].
    - ``ramp_depth``: d [m].
    - ``onset_depth``: ε [m].
    """

    validity: ClassVar[str] = "fitted case by case; exponents below 1 are no elastic contact's"
    onset_depth: Scalar

    def elastic(self, penetration: Values) -> Values:
        depth = jnp.maximum(penetration, 0.0)
        squared = depth * depth + self.onset_depth * self.onset_depth
        return self.stiffness * depth * squared ** (0.5 * (self.exponent - 1.0))

    def energy(self, penetration: Values) -> Values:
        depth, power = jnp.maximum(penetration, 0.0), self.exponent + 1.0
        squared = depth * depth + self.onset_depth * self.onset_depth
        return self.stiffness / power * (squared ** (0.5 * power) - self.onset_depth**power)

    def depth(self, force: Scalar) -> Scalar:
        # With an onset the force has no inverse in closed form, as a power has: it is found by bisection.
        return ContactLaw.depth(self, force)

    def time_scale(self, mass: Scalar, speed: Scalar) -> Scalar:
        n = self.exponent
        free = (mass * speed ** (1.0 - n) / self.stiffness) ** (2.0 / (n + 1.0))
        onset = jnp.where(
            n < 1.0, mass * self.onset_depth ** (1.0 - n) / self.stiffness, 0.0
        )  # softer than k δ^e there
        return 1.0 / (1.0 / jnp.sqrt(free + onset) + self.damping / mass)
