"""When contacts will close and open, predicted from their gaps at one instant, so that steps keep away from there."""

import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from .guards import Guards

PAST_TOUCHDOWN = 1.5  # times the predicted time to a touchdown: the longest step that looks for it


def next_touchdown(guards: Guards, active: Float[Array, " contacts"]) -> Float[Array, ""]:
    """Return the time until an open contact closes if all gaps keep their acceleration [s]; infinite if none closes."""
    time = _time_to_zero(guards.gap, guards.gap_rate, guards.gap_acceleration)
    return jnp.min(jnp.where(active < 0.5, time, jnp.inf), initial=jnp.inf)


def longest_step(guards: Guards, active: Float[Array, " contacts"], depths: Float[Array, "..."]) -> Float[Array, ""]:
    """Return how long a step that looks for the next touchdown may be [s]; infinite if none is predicted.

    It goes `PAST_TOUCHDOWN` times as far as the touchdown, since from a step that ends far beyond it the touchdown can
    only be guessed poorly, but to first order no gap falls farther than ``depths`` below zero
    (`HybridSystem.gap_depths`).
    """
    time = _time_to_zero(guards.gap, guards.gap_rate, guards.gap_acceleration)
    closing = jnp.sqrt(jnp.maximum(guards.gap_rate**2 - 2.0 * guards.gap_acceleration * guards.gap, 0.0))
    further = jnp.minimum((PAST_TOUCHDOWN - 1.0) * time, depths / jnp.maximum(closing, 1e-300))
    return jnp.min(jnp.where(active < 0.5, time + further, jnp.inf), initial=jnp.inf)


def next_release(guards: Guards, active: Float[Array, " contacts"]) -> tuple[Int[Array, ""], Float[Array, ""]]:
    """Return which closed contact opens first (-1: none does), and the time until then [s], infinite if none does.

    Its gap is taken to grow as fast as it does now, or more slowly where it is decelerated. An acceleration is not
    counted on: it is the contact force's, which fades as the contact opens.
    """
    time = _time_to_zero(-guards.gap, -guards.gap_rate, jnp.maximum(-guards.gap_acceleration, 0.0))
    time = jnp.where(active > 0.5, time, jnp.inf)
    contact = jnp.argmin(time) if time.shape[0] else jnp.asarray(-1)
    # `initial` gives an answer for a system without contacts.
    return contact, jnp.min(time, initial=jnp.inf)


def _time_to_zero(distance: Array, rate: Array, acceleration: Array) -> Float[Array, " contacts"]:
    """Return the time until the parabola through a distance reaches zero from above [s]; infinite if it does not. A
    distance that grows from a little below zero, as the gap does from a release, reaches it when it comes back."""
    discriminant = rate * rate - 2.0 * acceleration * distance
    root = jnp.sqrt(jnp.maximum(discriminant, 0.0))
    # The quadratic's root with the square root in the denominator does not cancel where the acceleration hardly
    # matters.
    approaching = 2.0 * distance / jnp.maximum(root - rate, 1e-300)
    turning_back = (rate + root) / jnp.where(acceleration < 0.0, -acceleration, 1.0)
    time = jnp.where(rate < 0.0, approaching, jnp.where(acceleration < 0.0, turning_back, jnp.inf))
    return jnp.where((discriminant > 0.0) & ((distance > 0.0) | (rate > 0.0)), time, jnp.inf)
