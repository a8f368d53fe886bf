"""How far a capture is from failing: the way left beyond the capture plane, and the stroke left."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..._types import Scalar
from ...hybrid import Log
from ..assembled import Assembled
from .docking import PlaneCrossing
from .reading import CaptureReading, holder_in


def throat(
    mechanism: Assembled, log: Log, at_end: CaptureReading, cross: PlaneCrossing, duration: Scalar
) -> tuple[Array, Array]:
    """Return how far the tip centre is before the capture plane at the end of the run [m], and how far beyond that
    plane it would be at ``duration``, going on from the end, or from its crossing of the plane, as fast as it goes
    there [m]: positive exactly if it crosses the plane until then.

    Its value and slope are continuous where capture, or escape, happens just at ``duration``; grazing the plane without
    crossing it is a jump.
    """
    end = at_end.throat
    # Where the tip is held a run goes on beyond the plane: how the tip crossed it counts, not where it is held.
    there, time = end, log.time[jnp.maximum(log.count - 1, 0)]
    if holder_in(mechanism) is not None:
        there, time = cross.at.throat, cross.time
    before, beyond = jnp.asarray(end.before), -(there.before + there.receding * (duration - time))
    # A free start may lead the tip past the cone: then minus how far it is off the rim.
    if mechanism.parts.scenario.start == "free":
        beyond = jnp.where(end.off_rim > 0.0, jnp.minimum(beyond, -end.off_rim), beyond)
    return before, beyond


def stroke_margin(
    mechanism: Assembled, end: CaptureReading, stroke: Float[Array, ""], bottomed: Bool[Array, ""]
) -> Float[Array, ""]:
    """Return how much stroke is left before the buffer's end [m]; less than zero for a bottomed run. ``end``: of
    the run.

    There it is -½ m ṡ²/F, the way on which the buffer's force at its end would stop the mass m that its ends meet
    through the joints. So the margin is continuous, and zero, where a run just reaches the end, and its slope leads out
    of it. It is no measure of the stroke that is missing: m is hardly more than the probe, and the vehicles behind it
    push on in later impacts. Runs with a longer stroke need 1 to 1000 times as much.
    """
    speed, longest = jnp.maximum(end.stroke_rate, 0.0), mechanism.parts.design.buffer.longest_stroke
    return jnp.where(bottomed, -0.5 * end.axial_mass * speed**2 / end.push, longest - stroke)
