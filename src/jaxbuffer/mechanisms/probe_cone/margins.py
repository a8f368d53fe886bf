"""How far a capture is from failing: the way left beyond the capture plane, and the stroke left."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..._types import Scalar
from ...hybrid import Log
from .buffer_force import BufferForce
from .docked import Crossing
from .system import CaptureMechanism


def throat(mechanism: CaptureMechanism, log: Log, cross: Crossing, duration: Scalar) -> tuple[Array, Array]:
    """How far the tip centre is before the capture plane at the end of the run [m], and how far beyond that plane it
    would be at ``duration``, going on from the end, or from its crossing of the plane, as fast as it goes there [m]:
    positive exactly if it crosses the plane until then.

    Its value and slope are continuous where capture, or escape, happens just at ``duration``; grazing the plane without
    crossing it is a jump.
    """
    last = jnp.maximum(log.count - 1, 0)
    before, receding = mechanism.throat_of(log.rows[last, 0])
    if mechanism.latch is None:
        return before, _through(mechanism, log, -(before + receding * (duration - log.time[last])))
    there, away = mechanism.throat(cross.at.kin, cross.at.tip)
    return before, _through(mechanism, log, -(there + away * (duration - cross.time)))


def _through(mechanism: CaptureMechanism, log: Log, beyond: Array) -> Array:
    """How far the tip is beyond the capture plane; where a free start leads it past the cone, minus how far it is off
    the rim [m]."""
    if mechanism.scenario.start != "free":
        return beyond
    end = mechanism.posture(log.rows[jnp.maximum(log.count - 1, 0), 0])
    off = mechanism.off_rim(end)
    return jnp.where(off > 0.0, jnp.minimum(beyond, -off), beyond)


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
    if isinstance(mechanism.axial, BufferForce):
        axial_force = -mechanism.axial.tension(at.kin)
    else:
        axial_force = buffer.k_A * buffer.longest_stroke + buffer.c_A * speed
    force = axial_force + mechanism.stop_force(at, log.active[last])
    return jnp.where(bottomed, -0.5 * mass * speed**2 / force, buffer.longest_stroke - stroke)
