"""One attempt at a step: how far, by which method, with sensitivities or without, and how well it went."""

from typing import NamedTuple, TypeVar

import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from .events import Guards, nearly_best, next_release, next_touchdown, observe
from .lanes import Lanes, Rows, columns
from .progress import Progress
from .stages import Step, Watch
from .stride import Stride
from .task import Task
from .trees import where

P = TypeVar("P")
CONSERVED = 0.03  # of the tolerance: by how much a step may change what the motion does not
BEYOND = 1.5  # of the way to the next touchdown as foreseen: from a step much beyond it, where it is is a poor guess
SHY = 0.6  # of the way to the next release as foreseen: near it no step is accurate that does not end there
LOOK = 1e-3  # of a step as accuracy allows: how far beside its end the second derivative is taken from


class Attempt(NamedTuple):
    """A step as tried: by which method, how long [s], with sensitivities or without (``whole``), its ``trial`` and the
    guards at its end; its error over what is allowed, of the state alone and of all rows; whether all is finite."""

    which: Int[Array, ""]
    step: Float[Array, ""]
    whole: Bool[Array, ""]
    trial: Step
    guards: Guards
    own_norm: Float[Array, ""]
    norm: Float[Array, ""]
    finite: Bool[Array, ""]

    @property
    def fits(self) -> Bool[Array, ""]:
        """Whether the error is allowed."""
        return self.norm <= 1.0


def attempt(task: Task[P], c: Progress) -> Attempt:
    """Try the next step of a run."""
    system, lanes, solver, tolerance = task.system, task.lanes, task.options.solver, task.options.tolerance
    landing, scales = c.landing.under_way, system.scales()
    stiff = system.linearisation(c.at.time, c.at.rows[0], c.active)
    touchdown, (_, release) = next_touchdown(c.at.guards, c.active), next_release(c.at.guards, c.active)
    well_before = jnp.where(release > c.onset, SHY * release, jnp.inf)
    which, step = solver.choose(stiff, jnp.minimum(c.pace.steps, well_before))
    which = jnp.where(landing, solver.suited(stiff, c.landing.aim), which)
    step = jnp.minimum(step, BEYOND * touchdown)
    step = jnp.where(landing, c.landing.aim, jnp.minimum(step, task.duration - c.at.time))
    step = jnp.where(c.renew, 0.0, step)
    releasing = landing & jnp.any((task.each_contact == c.landing.target) & (c.active > 0.5))
    stride = where(releasing, Stride.onto(step), Stride.after(jnp.maximum(c.at.time - c.touched, 0.0), step))
    stride = where(solver.is_implicit(which), Stride.even(step), stride)
    watch = None
    if any(system.rate_observables()):
        near = lambda state, rate: nearly_best(system, state, rate, c.active, c.best)  # noqa: E731
        watch = Watch(near, LOOK * jnp.min(c.pace.steps))

    def take(lanes: Lanes[P], rows: Rows, rate: Rows) -> Step:
        field = lambda time, at: lanes.field(lambda p, y: task.build(p).derivative(time, y, c.active))(at)  # noqa: E731
        # lanes that only fill up a vector register are zeros: any allowance does
        allowed = jnp.maximum(columns(tolerance.allowance(rows, scales)), 1e-300)
        trial = solver.step(which, field, stiff, c.at.time, columns(rows), columns(rate), stride, allowed, watch)
        back = lambda columns: columns.T[: rows.shape[0]]  # noqa: E731
        return Step(back(trial.end), back(trial.rate), back(trial.error), trial.order, back(trial.second))

    def alone() -> Step:
        return take(Lanes(lanes.primal), c.at.rows[:1], c.at.rate[:1]).filled_up(lanes.count)

    # Sensitivities, the dear part, ride along only where the step is likely to stand.
    whole = c.whole | ~landing & (step < jnp.minimum(touchdown, release))
    trial = lax.cond(whole, lambda: take(lanes, c.at.rows, c.at.rate), alone) if lanes.count else alone()
    norms = tolerance.norms(trial.error, c.at.rows, trial.end, scales)
    guards = observe(system, trial.end[0], trial.rate[0], trial.second[0], c.active)
    # An estimate from a few stages may miss what is not smooth between them, a tip that begins to roll say.
    lost = jnp.where(c.renew, 0.0, jnp.abs(guards.invariant - c.at.guards.invariant))
    own_norm = jnp.maximum(norms[0], lost / (CONSERVED * tolerance.rtol + guards.rounding))
    norm = jnp.maximum(own_norm, jnp.max(norms))
    finite = jnp.isfinite(norm) & jnp.all(jnp.isfinite(trial.rate))
    return Attempt(which, step, whole, trial, guards, own_norm, norm, finite)
