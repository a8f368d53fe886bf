"""The run of a dropped bar: the rebound of its first impact beside what every run has."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ...hybrid import Kind, Log
from ..assembled import Assembled
from ..layout import EvaluatedState
from ..reading import Reader
from ..run import Run, Solved


class BarDropRun(Run):
    """A simulated drop.

    ``rebound_height`` [m]: how high the ball end would rise after its first release, 0 without one; ``restitution``
    [-]: its speed there over that of the touchdown, both where the gap is zero; 0 without a release, NaN without a
    touchdown.
    """

    rebound_height: Float[Array, ""]
    restitution: Float[Array, ""]


class Flight(NamedTuple):
    """The ball end at one instant: its ``gap`` to the plate [m], and how fast that closes [m/s]."""

    gap: Float[Array, ""]
    closing: Float[Array, ""]


def _flight(mechanism: Assembled, at: EvaluatedState, active: Array, masses: None) -> Flight:
    gap, closing = mechanism.gaps_at(at)
    return Flight(gap[0], closing[0])


def _released(log: Log) -> Bool[Array, " slots"]:
    return (log.kind == Kind.RELEASE) & (jnp.arange(log.kind.shape[0]) < log.room)


READER = Reader(_flight, lambda mechanism, log: jnp.argmax(_released(log)))


def dropped(mechanism: Assembled, solved: Solved) -> BarDropRun:
    """Return what was solved, with the rebound.

    In free flight v² = 3 g (h - z) for the ball end at the height z that rises to h, so that h, taken anywhere in it,
    moves with the parameters as it does at the release itself.
    """
    scenario, release = solved.parameters[1], solved.event.own
    height = release.gap + release.closing**2 / (3.0 * scenario.gravity)
    rises = jnp.any(_released(solved.log)) & (height > 0.0)
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
