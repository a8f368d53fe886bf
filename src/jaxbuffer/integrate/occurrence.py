"""The event that a step has landed on, and what it does."""

from typing import NamedTuple

import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from .attempt import Attempt
from .decision import Decision
from .lanes import Rows
from .log import Kind, Log
from .progress import Progress, after_touchdown
from .stages import Step
from .task import Task


class Occurrence(NamedTuple):
    """An event, or none: what it belongs to (a contact, a guard of the end, an observable), whether a contact closes
    or opens, whether the run's time is up.

    ``time`` of the step's end [s] and ``offset`` from there to the event; ``there``: rows at the event, after what it
    does; ``rows``: those at the step's end after that; ``active``: closed contacts after it; ``onset``: how long a
    step next to a touchdown or its release may be [s].
    """

    target: Int[Array, ""]
    is_contact: Bool[Array, ""]
    is_terminal: Bool[Array, ""]
    is_peak: Bool[Array, ""]
    closing: Bool[Array, ""]
    opening: Bool[Array, ""]
    timed_out: Bool[Array, ""]
    time: Float[Array, ""]
    offset: Float[Array, ""]
    there: Rows
    rows: Rows
    active: Float[Array, " contacts"]
    onset: Float[Array, ""]

    @property
    def kind(self) -> Int[Array, ""]:
        """What the log calls it."""
        kind = jnp.where(self.closing, Kind.TOUCHDOWN, jnp.where(self.opening, Kind.RELEASE, Kind.NONE))
        return jnp.where(self.is_peak, Kind.PEAK, jnp.where(self.is_terminal | self.timed_out, Kind.END, kind))


def occurrence(task: Task, c: Progress, a: Attempt, d: Decision) -> Occurrence:
    """What happens at the end of a step that arrived."""
    system, lanes, landing, contacts = task.system, task.lanes, c.landing.under_way, task.contacts
    target = jnp.where(landing & d.verdict.happened & d.arrived, c.landing.target, -1)
    is_contact = (target >= 0) & (target < contacts)
    is_terminal = (target >= contacts) & (target < task.rated)
    chosen = is_contact & (task.each_contact == target)
    closing = is_contact & jnp.any(chosen & (c.active < 0.5))
    offset = jnp.where(landing, d.verdict.offset, 0.0)
    at_event = _shifted(a.trial, offset, system.coordinates)

    def touch() -> tuple[Rows, Array]:
        quickening = -jnp.sum(jnp.where(chosen, a.guards.gap_bend, 0.0))
        jump = lanes.lift(lambda p, y: task.build(p).touchdown(y, quickening, target) - y)(at_event)
        return jump, task.options.tolerance.first_step(lanes.count) * system.impact_step(a.trial.end[0] + jump[0])

    jump, onset = lax.cond(closing, touch, lambda: (jnp.zeros_like(at_event), c.onset))
    time = c.at.time + a.step
    return Occurrence(
        target=target,
        is_contact=is_contact,
        is_terminal=is_terminal,
        is_peak=target >= task.rated,
        closing=closing,
        opening=is_contact & ~closing,
        timed_out=d.arrived & ~is_terminal & (time >= task.duration * (1.0 - 1e-15)),
        time=time,
        offset=offset,
        there=at_event + jump,
        rows=a.trial.end + jump,
        active=jnp.where(chosen, 1.0 - c.active, c.active),
        onset=onset,
    )


def logged(task: Task, c: Progress, a: Attempt, d: Decision, o: Occurrence) -> Log:
    """The log with the event, if there is one."""
    values = a.guards.value + jnp.where(task.sought(o.target) & o.is_peak, 0.5 * o.offset * a.guards.slope, 0.0)
    if task.system.jumps:  # what is largest right after a touchdown has no slope to be found by
        after = lambda: after_touchdown(task.system, o.time, o.rows[0], o.active)  # noqa: E731
        values = lax.cond(o.closing, after, lambda: values)
    first = jnp.where(o.is_contact, 0, jnp.where(o.is_terminal, task.contacts, task.rated))
    return c.log.append(
        when=d.arrived & (o.kind != Kind.NONE),
        kind=o.kind,
        which=o.target - first,
        time=o.time + o.offset,
        values=values,
        guard_rate=d.verdict.rate,
        active=o.active,
        rows=o.there,
        # where the second derivative matters, near a maximum of what depends on the rate, it is watched
        rates=a.trial.rate + o.offset * a.trial.second,
        touching=task.system.touching(c.active),
    )


def _shifted(step: Step, offset: Float[Array, ""], n: int) -> Rows:
    """Where a step ends, moved by a small time [s] to second order in its n coordinates, whose accelerations are known,
    to first order in all else."""
    bend = jnp.pad(step.rate[:, n : 2 * n], [(0, 0), (0, step.rate.shape[1] - n)])
    return step.end + offset * (step.rate + 0.5 * offset * bend)
