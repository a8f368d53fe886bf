"""The run of a dropped bar: the rebound of its first impact beside what every run has."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...hybrid import Kind
from ..assembled import Assembled
from ..run import Run, Solved


class BarDropRun(Run):
    """A simulated drop.

    ``rebound_height`` [m]: how high the ball end would rise after its first release, 0 without one; ``restitution``
    [-]: its speed there over that of the touchdown, both where the gap is zero; 0 without a release, NaN without a
    touchdown.
    """

    rebound_height: Float[Array, ""]
    restitution: Float[Array, ""]


def dropped(mechanism: Assembled, solved: Solved) -> BarDropRun:
    """Return what was solved, with the rebound.

    In free flight v² = 3 g (h - z) for the ball end at the height z that rises to h, so that h, taken anywhere in it,
    moves with the parameters as it does at the release itself.
    """
    log, scenario = solved.log, solved.parameters[1]
    released = (log.kind == Kind.RELEASE) & (jnp.arange(log.kind.shape[0]) < log.room)
    at = mechanism.evaluate(log.rows[jnp.argmax(released), 0])
    gap, closing = mechanism.gaps_at(at)
    height = gap[0] + closing[0] ** 2 / (3.0 * scenario.gravity)
    rises = jnp.any(released) & (height > 0.0)
    # The root below would make derivatives NaN at zero, also where it is not taken.
    height = jnp.where(rises, height, 1.0)
    speed = jnp.sqrt(3.0 * scenario.gravity * height)
    approach = solved.common["impacts"].approach_speed[0]
    # Without a touchdown there is no speed to divide by, and the answer is NaN below.
    restitution = speed / jnp.where(approach > 0.0, approach, 1.0)
    return BarDropRun(
        **solved.common,
        rebound_height=jnp.where(rises, height, 0.0) * solved.known,
        restitution=jnp.where(solved.common["impact_count"] > 0, jnp.where(rises, restitution, 0.0), jnp.nan)
        * solved.known,
    )
