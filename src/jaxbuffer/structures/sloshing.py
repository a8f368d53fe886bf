"""Linear sloshing in upright tanks, in closed form (M150, M151)."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar

GRAVITY = 9.80665  # m/s²
FIRST_ZERO = 1.8411837813406593  # of J1'


class Sloshing(NamedTuple):
    """One mode, and the pendulum that pushes on the tank as the liquid does.

    - ``frequency``: ω [rad/s].
    - ``mass``: of the pendulum over the liquid's [-].
    - ``length``: of the pendulum [m].
    - ``depth``: of its mass below the surface [m].
    """

    frequency: Float[Array, ""]
    mass: Float[Array, ""]
    length: Float[Array, ""]
    depth: Float[Array, ""]


def in_rectangle(length: Scalar, height: Scalar, mode: int = 1, gravity: Scalar = GRAVITY) -> Sloshing:
    """Return an antisymmetric mode of a rectangular tank.

    **Arguments:** ``length`` of the tank [m]; ``height`` of the liquid [m]; ``mode``: counted from 1; ``gravity``
    [m/s²].

    **Example:** filled to half its length, 47 % of the liquid swings in the first mode.

    >>> first = in_rectangle(1.0, 0.5)
    >>> f"{float(first.mass):.6f}"
    '0.473273'
    """
    number = (2 * mode - 1) * jnp.pi
    k = number / length
    tanh = jnp.tanh(k * height)
    return Sloshing(
        jnp.sqrt(gravity * k * tanh),
        8.0 * tanh * length / (number**3 * height),
        1.0 / (k * tanh),
        2.0 / k * jnp.tanh(0.5 * k * height),
    )


def in_cylinder(radius: Scalar, height: Scalar, gravity: Scalar = GRAVITY) -> Sloshing:
    """Return the first mode of an upright cylinder. ``radius``, ``height`` of the liquid [m]; ``gravity`` [m/s²].

    **Example:** as deep as it is wide by half.

    >>> first = in_cylinder(0.5, 0.5)
    >>> f"{float(first.mass):.6f}"
    '0.432197'
    """
    k = FIRST_ZERO / radius
    tanh = jnp.tanh(k * height)
    mass = 2.0 * tanh / (k * height * (FIRST_ZERO**2 - 1.0))
    return Sloshing(jnp.sqrt(gravity * k * tanh), mass, 1.0 / (k * tanh), 2.0 / k * jnp.tanh(0.5 * k * height))
