"""Where a run stands from one trip of its loop to the next."""

import enum
from typing import NamedTuple, TypeVar

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..mechanisms.hybrid import HybridSystem
from .controller import Pace
from .events import Guards
from .landing import Landing
from .lanes import Rows
from .log import Kind, Log, Steps
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


class Place(NamedTuple):
    """A point of the motion: time, state and sensitivities, their rate, guards."""

    time: Float[Array, ""]
    rows: Rows
    rate: Rows
    guards: Guards


class Progress(NamedTuple):
    """What the loop carries: the place ``at`` which the next step starts; the end ``ahead`` of a step that stands while
    a maximum within it is looked at; closed contacts; each observable's ``best`` so far; when a contact closed last;
    ``onset``, how long a step next to its touchdown or its release may be [s]; how far steps go, and went before that
    contact; a landing under way; whether the next step is taken ``whole``, with sensitivities, whatever is foreseen;
    whether the rate has to be found anew; status, count of attempts and records.
    """

    at: Place
    ahead: Place
    active: Float[Array, " contacts"]
    best: Float[Array, " observables"]
    touched: Float[Array, ""]
    onset: Float[Array, ""]
    pace: Pace
    before_contact: Pace
    landing: Landing
    whole: Bool[Array, ""]
    renew: Bool[Array, ""]
    status: Int[Array, ""]
    attempts: Int[Array, ""]
    log: Log
    steps: Steps


def begin(task: Task[P], allowed: Bool[Array, ""] | None = None) -> Progress:
    """The loop's first state; over at once unless ``allowed``. A run may start in contact: that is its first touchdown.

    Derivatives and guards are still unknown: the loop's first step has length zero and finds them, which spares
    compiling the right-hand side twice. So does the step after a touchdown at which the rate jumps, and, with
    sensitivities, after a release: there the force's derivative goes with the root of a gap of mere rounding.
    """
    system, options, contacts = task.system, task.options, task.contacts
    start, active = task.lanes.start(lambda p: task.build(p).start()[0]), system.start()[1]
    zero, one = jnp.zeros(()), jnp.ones(())
    none, terminal, value = (jnp.zeros(n) for n in (contacts, task.terminals, task.observables))
    guards = Guards(none, none, none, terminal, terminal, value, value, zero, zero)
    log = Log.empty(options.max_events, start, contacts, task.observables)
    highest = after_touchdown(system, zero, start[0], active) if system.jumps else value
    first_step = options.tolerance.first_step(task.lanes.count) * system.impact_step(start[0])
    pace = Pace.of(jnp.minimum(first_step, task.duration), len(options.solver.methods))
    place = Place(zero, start, jnp.zeros_like(start), guards)
    status = jnp.where(jnp.all(jnp.isfinite(start)), Status.RUNNING, Status.NOT_FINITE)
    for contact in range(contacts):
        closed, kind = active[contact] > 0.5, jnp.asarray(Kind.TOUCHDOWN)
        log = log.append(closed, kind, jnp.asarray(contact), zero, highest, one, active, start, place.rate, closed)
    return Progress(
        at=place,
        ahead=place,
        active=active,
        best=guards.value,
        touched=zero,
        onset=first_step,
        pace=pace,
        before_contact=pace,
        landing=Landing.none(),
        whole=jnp.asarray(False),
        renew=jnp.asarray(True),
        status=status if allowed is None else jnp.where(allowed, status, Status.INPUT),
        attempts=jnp.asarray(0),
        log=log,
        steps=Steps.empty(options.keep, start, contacts),
    )


def after_touchdown(system: HybridSystem, time: Array, state: Array, active: Array) -> Float[Array, " observables"]:
    """All observables of a state whose rate is not yet known."""
    return system.observables(state, system.derivative(time, state, active), active)
