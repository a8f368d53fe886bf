"""Assembled mechanisms stepped by jaxbuffer's own integrator."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from jaxbuffer.contact import BallPair, RegularisedCoulomb, Segment
from jaxbuffer.hybrid import ExplicitRungeKutta, Kind, Options, StepTolerance, solve
from jaxbuffer.mechanisms.assembled import Assembled, BallContact
from jaxbuffer.multibody import GROUND


def options(rtol=1e-10, events=4096):
    return Options(
        solver=ExplicitRungeKutta(), tolerance=StepTolerance(rtol, rtol), event_time=1e-3 * rtol, max_events=events
    )


class Ride:
    """A finished run: events by kind, and the last state."""

    def __init__(self, mechanism: Assembled, result):
        log, count = result.log, int(result.log.count)
        self.status = int(result.status)
        self.kind, self.which = np.asarray(log.kind[:count]), np.asarray(log.which[:count])
        self.time, self.force = np.asarray(log.time[:count]), np.asarray(log.values[:count])
        self.states = np.asarray(log.rows[:count, 0])
        n = mechanism.system.coordinates
        self.q, self.v = self.states[-1, :n], self.states[-1, n : 2 * n]

    def times(self, kind: Kind):
        return self.time[self.kind == kind]


def ride(mechanism: Assembled, duration: float, rtol=1e-10) -> Ride:
    """Run a mechanism for ``duration`` [s]."""
    # Arrays in place of floats: mechanisms of one kind then share one compiled program.
    arrays = jax.tree.map(lambda x: jnp.asarray(x, float), (mechanism, duration, rtol))
    return Ride(arrays[0], _run(*arrays))


@eqx.filter_jit
def _run(mechanism, duration, rtol):
    return solve(_itself, (mechanism,), duration, options(rtol))


def _itself(mechanism):
    return mechanism


def floor(radius, law, friction=0.0, slip_speed=1e-3) -> BallPair:
    """A ball on the x axis, the ground above it being free."""
    plane = Segment(-1e3, 0.0, 1.0, 0.0, 2e3)
    return BallPair(radius, plane, -1.0, law, RegularisedCoulomb(friction, slip_speed))


def on_floor(radius, law, body=0, carrier=GROUND, **friction) -> BallContact:
    return BallContact(body, carrier, floor(radius, law, **friction))
