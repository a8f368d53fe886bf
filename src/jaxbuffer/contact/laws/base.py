"""What every normal contact law offers: force from penetration, its rate and the speed at touchdown."""

from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp

from ..._types import Scalar, Values

METHODS = ("elastic", "energy", "force", "time_scale")  # that each law has of its own


class ContactLaw(eqx.Module):
    """Base of the laws. None of them pulls: a negative sum of spring and damper counts as zero.

    ``source``: where the law was published; ``validity``: what it is good for; ``unit``: of its stiffness; ``jumps``:
    whether the force starts from zero at touchdown or with a jump.
    """

    source: ClassVar[str] = "not given"
    validity: ClassVar[str] = "not given"
    unit: ClassVar[str] = "N/m^1.5"
    jumps: ClassVar[bool] = False

    def elastic(self, penetration: Values) -> Values:
        """What the spring in the contact exerts [N], zero for δ ≤ 0, with finite derivatives there."""
        raise NotImplementedError

    def energy(self, penetration: Values) -> Values:
        """What the spring in the contact stores [J]."""
        raise NotImplementedError

    def depth(self, force: Scalar) -> Scalar:
        """The penetration [m] at which the spring alone exerts a force [N]; differentiable.

        No law's penetration exceeds that of its peak force: where it is deepest the damper exerts nothing. Found by
        bisection, up to 10 m, unless a law says it in closed form.
        """
        wanted = jnp.asarray(force, float)

        def halved(_: int, bracket: tuple[Values, Values]) -> tuple[Values, Values]:
            low, high = bracket
            middle = jnp.sqrt(low * high)
            soft = self.elastic(middle) < wanted
            return jnp.where(soft, middle, low), jnp.where(soft, high, middle)

        ends = (jnp.full_like(wanted, 1e-15), jnp.full_like(wanted, 10.0))
        found = jax.lax.stop_gradient(jax.lax.fori_loop(0, 60, halved, ends)[1])
        exerted, slope = jax.jvp(self.elastic, (found,), (jnp.ones_like(found),))
        stiff = jnp.where(slope > 0.0, jax.lax.stop_gradient(slope), 1.0)
        return jnp.where(wanted > 0.0, found - (exerted - wanted) / stiff, 0.0)  # one step of Newton's: its derivative

    def force(self, penetration: Values, approach_speed: Values, touchdown_speed: Values) -> Values:
        """F_n [N] of a closed contact from δ [m], δ̇ [m/s] and δ̇⁻ [m/s]."""
        raise NotImplementedError

    def time_scale(self, mass: Scalar, speed: Scalar) -> Scalar:
        """About a third of the duration of an impact of an effective mass [kg] at a speed [m/s], in seconds."""
        raise NotImplementedError

    def delivered_restitution(self, mass: Scalar, speed: Scalar) -> Scalar:
        """Separation over approach speed [-] that two free bodies of an effective mass [kg] get at a speed [m/s]."""
        from .impact import free_impact

        return free_impact(self, float(mass), float(speed)).restitution

    def max_penetration(self, mass: Scalar, speed: Scalar) -> Scalar:
        """Deepest penetration [m] of two free bodies of an effective mass [kg] meeting at a speed [m/s]."""
        from .impact import free_impact

        return free_impact(self, float(mass), float(speed)).max_penetration


def power(penetration: Values, exponent: Scalar) -> Values:
    """δⁿ, zero for δ ≤ 0; 3/2, the ball's exponent, by a square root."""
    inside = penetration > 0.0
    # A guarded argument: the untaken branch of a `where` still sends NaN into tangents.
    depth = jnp.where(inside, penetration, 1.0)
    raised = depth * jnp.sqrt(depth) if isinstance(exponent, float) and exponent == 1.5 else depth**exponent
    return jnp.where(inside, raised, 0.0)


def root(value: Scalar, exponent: Scalar) -> Scalar:
    """The n-th root, the inverse of `power`; zero, with no derivative, for values ≤ 0."""
    positive = jnp.asarray(value) > 0.0
    return jnp.where(positive, jnp.where(positive, value, 1.0) ** (1.0 / exponent), 0.0)
