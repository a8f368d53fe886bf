"""What the loop carries from one iteration to the next."""

import enum
from typing import NamedTuple, TypeVar

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..events.bracketing import Bracket
from ..events.guards import Extremes, Guards
from ..rungekutta.controller import StepSizes
from ..sensitivity.augmented_state import Rows
from .log import Kind, Log, Steps
from .phase import LOCATING, LOOKING_BACK, RETAKING, Phase, is_one_of
from .task import Task

P = TypeVar("P")


class Status(enum.IntEnum):
    """How a run ended. Values from 0 up to ``TIMEOUT`` are the system's terminal guards, in order."""

    RUNNING = -1
    TIMEOUT = 100
    TOO_MANY_STEPS = 101
    STEP_TOO_SMALL = 102
    NOT_FINITE = 103
    INPUT = 104


class Point(NamedTuple):
    """A point of the motion.

    ``time`` [s]; ``rows``: the state and its tangents; ``rate``: their time derivative; ``guards`` of the state;
    ``change``: what all steps up to it have changed the invariant by.
    """

    time: Float[Array, ""]
    rows: Rows
    rate: Rows
    guards: Guards
    change: Float[Array, ""]


class LoopState(NamedTuple):
    """What the loop carries."""

    # Where the run is: the point from which the next trial step starts, and which contacts are closed (1) there.
    point: Point
    active: Float[Array, " contacts"]

    # What the next trial step is for; the event that is being located, if any; and, while the run looks back at a
    # maximum inside a step that stands, the end of that step.
    phase: Int[Array, ""]
    bracket: Bracket
    step_end: Point

    # Of each observable: the largest and smallest values so far, in the present impact if it is a contact's force; the
    # largest value in the log; whether its maximum has just been located at `point`, so that it counts as falling
    # whatever the sign of its rate; and whether the search for it led nowhere from there, so that the next step is not
    # searched for one.
    extremes: Extremes
    logged: Float[Array, " observables"]
    located: Bool[Array, " observables"]
    given_up: Bool[Array, " observables"]

    # The controller's state, also as it was before the last touchdown; the time of that [s]; how long a step may be
    # that starts on it, or ends on the release after it [s].
    step_sizes: StepSizes
    step_sizes_before_contact: StepSizes
    last_touchdown: Float[Array, ""]
    contact_step: Float[Array, ""]

    # All observables at the start, for what the log says of a contact that is closed there: known once the first
    # iteration has evaluated them.
    first_values: Float[Array, " observables"]

    # Results.
    status: Int[Array, ""]
    attempts: Int[Array, ""]
    log: Log
    steps: Steps

    @property
    def locating(self) -> Bool[Array, ""]:
        """Return whether the next trial step is to end on an event."""
        return is_one_of(self.phase, LOCATING)

    @property
    def looking_back(self) -> Bool[Array, ""]:
        """Return whether that event is a maximum inside a step that stands."""
        return is_one_of(self.phase, LOOKING_BACK)

    @property
    def retaking(self) -> Bool[Array, ""]:
        """Return whether the next trial step is the last one again, with tangents."""
        return is_one_of(self.phase, RETAKING)

    @property
    def reevaluating(self) -> Bool[Array, ""]:
        """Return whether only the derivative of the state is evaluated."""
        return self.phase == Phase.REEVALUATE


def initial_state(task: Task[P], allowed: Bool[Array, ""] | None = None) -> LoopState:
    """Return the loop's first state; the run is over at once unless ``allowed``. A run may start in contact: that is
    its first touchdown.

    Derivatives and guards are still unknown. The loop's first iteration finds them (`Phase.REEVALUATE`), which spares
    compiling the right-hand side a second time.
    """
    system, options, contacts = task.system, task.options, task.contacts
    (start, active), zero, one = task.start, jnp.zeros(()), jnp.ones(())
    none, terminal, value = (jnp.zeros(n) for n in (contacts, task.terminals, task.observables))
    reversals = jnp.zeros(system.reversals_shape)
    # Placeholders: the first iteration evaluates them.
    guards = Guards(none, none, none, terminal, terminal, value, value, reversals, zero, zero)
    log = Log.empty(options.max_events, start, contacts, task.observables)
    contact_step = options.tolerance.first_step(task.tangents.count) * system.impact_step(start[0])
    step_sizes = StepSizes.of(jnp.minimum(contact_step, task.duration), len(options.solver.methods))
    point = Point(zero, start, jnp.zeros_like(start), guards, zero)
    status = jnp.where(jnp.all(jnp.isfinite(start)), Status.RUNNING, Status.NOT_FINITE)
    for contact in range(contacts):
        closed, kind = active[contact] > 0.5, jnp.asarray(Kind.TOUCHDOWN)
        log = log.append(closed, kind, jnp.asarray(contact), zero, value, one, active, start, point.rate, closed)
    return LoopState(
        point=point,
        active=active,
        phase=jnp.asarray(int(Phase.REEVALUATE)),
        bracket=Bracket.none(),
        step_end=point,
        extremes=Extremes.none(task.observables),
        logged=jnp.full(task.observables, -jnp.inf),
        located=jnp.zeros(task.observables, bool),
        given_up=jnp.zeros(task.observables, bool),
        step_sizes=step_sizes,
        step_sizes_before_contact=step_sizes,
        last_touchdown=zero,
        contact_step=contact_step,
        first_values=value,
        status=status if allowed is None else jnp.where(allowed, status, Status.INPUT),
        attempts=jnp.asarray(0),
        log=log,
        steps=Steps.empty(options.keep, start, contacts),
    )
