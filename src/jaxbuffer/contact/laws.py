"""Normal contact laws: force from penetration, its rate and the speed at touchdown."""

import equinox as eqx
import jax.numpy as jnp

from .._types import Scalar, Values


class ContactLaw(eqx.Module):
    """Base of the laws K δⁿ max(0, 1 + χ̂ δ̇/δ̇⁻): a Hertzian spring with hysteresis.

    Subclasses hold ``stiffness`` [N/mⁿ] and give ``hysteresis`` χ̂ [-]. The clamp keeps the surfaces from pulling.
    """

    stiffness: eqx.AbstractVar[Scalar]

    @property
    def hysteresis(self) -> Scalar:
        """χ̂ [-], the damping factor relative to the elastic force at touchdown speed."""
        raise NotImplementedError

    def elastic(self, penetration: Values) -> Values:
        """K δ^{3/2} [N], zero for δ ≤ 0, with finite derivatives there."""
        inside = penetration > 0.0
        # A guarded argument: the untaken branch of a `where` still sends NaN into tangents.
        depth = jnp.where(inside, penetration, 1.0)
        return jnp.where(inside, self.stiffness * depth * jnp.sqrt(depth), 0.0)

    def energy(self, penetration: Values) -> Values:
        """Elastic energy 2/5 K δ^{5/2} [J]."""
        return 0.4 * self.elastic(penetration) * penetration

    def force(self, penetration: Values, approach_speed: Values, touchdown_speed: Values) -> Values:
        """F_n [N] from δ [m], δ̇ [m/s] and δ̇⁻ [m/s]."""
        return self.elastic(penetration) * jnp.maximum(0.0, 1.0 + self.hysteresis * approach_speed / touchdown_speed)


class LankaraniNikravesh(ContactLaw):
    """χ̂ = 3 (1 - e²)/4 (Lankarani & Nikravesh 1990; Efficient buffering mechanism, eq. 1-2).

    **Arguments:** ``stiffness`` K [N/m^1.5]; ``restitution`` e in (0, 1].
    """

    stiffness: Scalar
    restitution: Scalar

    @property
    def hysteresis(self) -> Scalar:
        return 0.75 * (1.0 - self.restitution * self.restitution)


def hertz_stiffness(
    radius: Scalar,
    young_1: Scalar = 71.7e9,
    poisson_1: Scalar = 0.3,
    young_2: Scalar = 71.7e9,
    poisson_2: Scalar = 0.3,
) -> Scalar:
    """K = 4 √R / (3 (σ_1 + σ_2)), σ = (1 - ν²)/E, of a ball on a plane [N/m^1.5] (eq. 3-4; aluminium by default)."""
    compliance = (1.0 - poisson_1**2) / young_1 + (1.0 - poisson_2**2) / young_2
    return 4.0 * radius**0.5 / (3.0 * compliance)
