"""A ball above a floor, with one coordinate: the smallest system that has every kind of event.

Guards are numbered: 0 the contact, 1 the run's end, 2 the force's maximum, 3 the maximum of an observable of the rate.
"""

import jax
import jax.numpy as jnp
import numpy as np

from jaxbuffer.hybrid import Options
from jaxbuffer.hybrid.events.guards import Guards
from jaxbuffer.hybrid.loop.state import initial_state
from jaxbuffer.hybrid.loop.task import Task
from jaxbuffer.hybrid.loop.trial import Trial
from jaxbuffer.hybrid.rungekutta.stages import Step
from jaxbuffer.hybrid.sensitivity.augmented_state import Tangents
from jaxbuffer.hybrid.system import HybridSystem, Linearisation

CONTACT, END, PEAK, RATE_PEAK = range(4)
LENGTH = 1e-3  # s, of a trial step
IMPACT_STEP = 2e-4  # s
DURATION = 1.0  # s
JUMP = 7.0  # what a touchdown sets the last entry of the state to


class Ball(HybridSystem):
    """State: height [m], velocity [m/s], a memory of the last touchdown; the floor pushes back with a linear spring."""

    stiffness: jax.Array
    jumps: bool = False

    @property
    def coordinates(self):
        return 1

    def start(self):
        return jnp.array([1.0, -0.1, 0.0]), jnp.zeros(1)

    def force(self, state, active):
        return active[0] * self.stiffness * jnp.maximum(-state[0], 0.0)

    def derivative(self, time, state, active):
        return jnp.stack([state[1], self.force(state, active) - 10.0, jnp.zeros(())])

    def gaps(self, state):
        return state[:1]

    def touchdown(self, state, approach_acceleration, contact):
        return jnp.concatenate([state[:2], jnp.array([JUMP])])

    def terminals(self, state):
        return state[:1] - 2.0

    def observables(self, state, rate, active):
        return jnp.stack([self.force(state, active), rate[1]])

    def rate_observables(self):
        return (False, True)

    def scales(self):
        return jnp.ones(3)

    def impact_step(self, state):
        return jnp.asarray(IMPACT_STEP)

    def linearisation(self, time, state, active):
        return Linearisation.none(1, 1)


class BallByState(Ball):
    """The same, but none of its observables depends on the state's rate."""

    def rate_observables(self):
        return (False, False)


def task(tangents=0, jumps=False, ball=Ball, **options):
    """A run of the ball, with so many tangents by the floor's stiffness."""
    stiffness = jnp.asarray(1e4)
    directions = jnp.ones(tangents) if tangents else None
    settings = Options(**{"max_events": 8, "keep": 4, **options})
    return Task.of(lambda k: ball(k, jumps), Tangents(stiffness, directions), jnp.asarray(DURATION), settings)


def guards(contact=(1.0, -0.1, 0.0), end=(-1.0, 0.0), force=(0.0, 0.0), other=(0.0, -1.0)):
    """Gap, its rate and acceleration; the end's guard and its rate; both observables and their rates."""
    observed = np.array([force, other])
    parts = [np.array([number]) for number in (*contact, *end)]
    return Guards(*parts, observed[:, 0], observed[:, 1], np.zeros((0, 1)), np.zeros(()), np.zeros(()))


_initial: dict = {}  # by the task's identity, beside the task, so that no other takes its place


def initial(task):
    """The state of a run's start, compiled as a whole: one by one, its operations take a second at collection."""
    if id(task) not in _initial:
        _initial[id(task)] = task, jax.jit(lambda: initial_state(task))()
    return _initial[id(task)][1]


def running(task, phase, at, closed=False, bracket=None, **others):
    """A run under way in some phase, half a second from its start, with these guards."""
    state = initial(task)
    point = state.point._replace(time=jnp.asarray(0.5), guards=at)
    return state._replace(
        phase=jnp.asarray(int(phase)),
        point=point,
        step_end=point,
        active=jnp.array([float(closed)]),
        bracket=state.bracket if bracket is None else bracket,
        **others,
    )


def trial(task, at, norm=0.5, length=LENGTH, with_tangents=True, finite=True, implicit=False):
    """A trial step that moves every row by one, with these guards at its end."""
    rows = np.ones((1 + task.tangents.count, 3))
    step = Step(rows, 2.0 * rows, 0.0 * rows, np.asarray(8.0), 0.0 * rows)
    flags = np.asarray(with_tangents), np.asarray(finite)
    norm = np.asarray(norm)
    return Trial(
        np.asarray(int(implicit)),
        np.asarray(length),
        flags[0],
        step,
        at,
        np.zeros(()),
        norm,
        norm,
        flags[1],
        np.asarray(length),
    )
