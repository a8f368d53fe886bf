"""How far a capture is from failing: the way left beyond the capture plane, and the stroke left."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..._types import Scalar
from ...hybrid import Log
from .system import CaptureMechanism

SAME = 1e-6  # relative difference within which two values of a maximum are the same


def throat(mechanism: CaptureMechanism, log: Log, duration: Scalar) -> tuple[Array, Array]:
    """How far the tip centre is before the capture plane at the end of the run [m], and how far beyond that plane it
    would be at ``duration``, going on from the end as fast as it goes there [m]: positive exactly if it crosses the
    plane until then.

    Its value and slope are continuous where capture, or escape, happens just at ``duration``; grazing the plane without
    crossing it is a jump.
    """
    last = jnp.maximum(log.count - 1, 0)
    before, receding = mechanism.throat_of(log.rows[last, 0])
    return before, -(before + receding * (duration - log.time[last]))


def rising(
    mechanism: CaptureMechanism, log: Log, stroke: Float[Array, ""], hinge_angle: Float[Array, ""]
) -> tuple[Array, Array]:
    """Rates at the end of the run of the stroke [m/s] and of the hinge angle's size [rad/s], each 0 unless it rises and
    its value at the end is the run's largest, which is ``stroke`` [m] or ``hinge_angle`` [rad]."""
    at = mechanism.posture(log.rows[jnp.maximum(log.count - 1, 0), 0])
    angle, rate = at.kin.q[5] - at.kin.q[2], at.kin.v[5] - at.kin.v[2]
    return (
        _rising(jnp.asarray(at.stroke), jnp.asarray(at.stroke_rate), stroke),
        _rising(jnp.abs(angle), jnp.sign(angle) * rate, hinge_angle),
    )


def _rising(last: Float[Array, ""], rate: Float[Array, ""], largest: Float[Array, ""]) -> Float[Array, ""]:
    """The rate at the end of a value that is largest there, else 0."""
    return jnp.where(last >= (1.0 - SAME) * largest, jnp.maximum(rate, 0.0), 0.0)


def stroke_margin(
    mechanism: CaptureMechanism, log: Log, stroke: Float[Array, ""], bottomed: Bool[Array, ""]
) -> Float[Array, ""]:
    """How much stroke is left before the buffer's end [m]; less than zero for a bottomed run.

    There it is -½ m ṡ²/F, the way on which the buffer's force at its end would stop the mass m that its ends meet
    through the joints. So the margin is continuous, and zero, where a run just reaches the end, and its slope leads out
    of it. It is no measure of the stroke that is missing: m is hardly more than the probe, and the vehicles behind it
    push on in later impacts. Runs with a longer stroke need 1 to 1000 times as much.
    """
    last = jnp.maximum(log.count - 1, 0)
    at = mechanism.posture(log.rows[last, 0])
    axial, buffer = mechanism.axial.springs(at.kin)[0], mechanism.design.buffer
    mass = mechanism.system.effective_mass(at.kin, mechanism.system.direction(axial.blocks))
    speed = jnp.maximum(at.stroke_rate, 0.0)
    force = buffer.k_A * buffer.longest_stroke + buffer.c_A * speed + mechanism.stop_force(at, log.active[last])
    return jnp.where(bottomed, -0.5 * mass * speed**2 / force, buffer.longest_stroke - stroke)
