"""What every normal contact law offers: force from penetration, its rate and the speed at touchdown."""

from collections.abc import Callable
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp

from ..._types import Scalar, Values
from .impact import free_impact

METHODS = ("elastic", "energy", "force", "time_scale")  # that each law has of its own


BEYOND_LAW = "outside the contact law's validity: "  # with which what is said of a run beyond it begins


class ContactLaw(eqx.Module):
    """Base of the laws. None of them pulls: a negative sum of spring and damper counts as zero.

    - ``source``: where the law was published.
    - ``validity``: what it is good for.
    - ``unit``: of its stiffness.
    - ``jumps``: whether the force starts with a jump at touchdown instead of from zero.

    Results have the shape of the arguments.
    """

    source: ClassVar[str] = "not given"
    validity: ClassVar[str] = "not given"
    unit: ClassVar[str] = "N/m^1.5"
    jumps: ClassVar[bool] = False

    def elastic(self, penetration: Values) -> Values:
        """Return the force of the spring in the contact [N], zero for δ ≤ 0, with finite derivatives there.
        ``penetration``: δ [m]."""
        raise NotImplementedError

    def energy(self, penetration: Values) -> Values:
        """Return the energy stored in the spring in the contact [J] (M37). ``penetration``: δ [m]."""
        raise NotImplementedError

    def depth(self, force: Scalar) -> Scalar:
        """Return the penetration at which the spring alone exerts a ``force`` [N], in metres; differentiable (M72).

        No penetration of a run exceeds that of its peak force: at the deepest point δ̇ = 0, and the spring alone acts.
        It is found by bisection, up to 10 m, unless a law gives it in closed form.
        """
        return depth_at(self.elastic, force)

    def force(self, penetration: Values, approach_speed: Values, touchdown_speed: Values) -> Values:
        """Return F_n of a closed contact [N].

        **Arguments:**

        - ``penetration``: δ [m].
        - ``approach_speed``: δ̇ [m/s].
        - ``touchdown_speed``: δ̇⁻ [m/s] (M36).
        """
        raise NotImplementedError

    def time_scale(self, mass: Scalar, speed: Scalar) -> Scalar:
        """Time scale of an impact [s], about a third of its duration (M58).

        **Arguments:** ``mass``: effective mass [kg]; ``speed``: of approach [m/s].
        """
        raise NotImplementedError

    def delivered_restitution(self, mass: Scalar, speed: Scalar) -> Scalar:
        """Return the speed of separation over speed of approach of two free bodies [-], integrated or in a law's closed
        form.

        **Arguments:** ``mass``: effective mass [kg]; ``speed``: of approach [m/s].
        """
        return free_impact(self, float(mass), float(speed)).restitution

    def max_penetration(self, mass: Scalar, speed: Scalar) -> Scalar:
        """Return the deepest penetration of two free bodies [m], integrated or in a law's closed form.

        **Arguments:** ``mass``: effective mass [kg]; ``speed``: of approach [m/s].
        """
        return free_impact(self, float(mass), float(speed)).max_penetration


def depth_at(function: Callable[[Values], Values], value: Scalar) -> Scalar:
    """Return the penetration [m], up to 10 m, at which an increasing function of it takes a ``value``; zero for values
    ≤ 0.

    Found by bisection, differentiable by the step of Newton's method at its end.
    """
    target = jnp.asarray(value, float)

    def halved(_: int, bracket: tuple[Values, Values]) -> tuple[Values, Values]:
        low, high = bracket
        # The geometric mean, since depths may differ by many orders of magnitude.
        middle = jnp.sqrt(low * high)
        shallow = function(middle) < target
        return jnp.where(shallow, middle, low), jnp.where(shallow, high, middle)

    ends = (jnp.full_like(target, 1e-15), jnp.full_like(target, 10.0))
    # Bisection has no derivative. One step of Newton's method from its result, with the slope held fixed, has that of
    # the implicit function.
    depth = jax.lax.stop_gradient(jax.lax.fori_loop(0, 60, halved, ends)[1])
    reached, slope = jax.jvp(function, (depth,), (jnp.ones_like(depth),))
    steep = jnp.where(slope > 0.0, jax.lax.stop_gradient(slope), 1.0)
    return jnp.where(target > 0.0, depth - (reached - target) / steep, 0.0)


def power(penetration: Values, exponent: Scalar) -> Values:
    """Return δⁿ, zero for δ ≤ 0. ``penetration``: δ [m]; ``exponent``: n [-]; δ^{3/2} is taken by a square root."""
    inside = penetration > 0.0
    # A guarded argument: the untaken branch of a `where` still sends NaN into tangents.
    depth = jnp.where(inside, penetration, 1.0)
    raised = depth * jnp.sqrt(depth) if isinstance(exponent, float) and exponent == 1.5 else depth**exponent
    return jnp.where(inside, raised, 0.0)


def root(value: Scalar, exponent: Scalar) -> Scalar:
    """Return the n-th root of a ``value``, the inverse of `power`; zero, with no derivative, for values ≤ 0."""
    positive = jnp.asarray(value) > 0.0
    # Guarded as in `power`.
    return jnp.where(positive, jnp.where(positive, value, 1.0) ** (1.0 / exponent), 0.0)
