"""The loop's next state, part by part: from the trial step, the decision about it and the event at its end."""

from typing import NamedTuple, TypeVar

import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Int

from ..events.bracketing import MAX_TRIES_MAXIMUM, Bracket
from ..events.guards import Extremes, Guards
from ..events.prediction import next_release
from ..rungekutta.controller import StepSizes
from ..trees import where
from .decision import Decision
from .event import Event
from .phase import Phase, StepOutcome, following
from .state import LoopState, Point, Status
from .task import Task
from .trial import Trial

P = TypeVar("P")
SHORTEST = 1e-14  # s: a step that would have to be shorter ends the run
HARDLY = 1e-3  # of a step as accuracy allows: a shorter one, onto a maximum, is no progress


class Advance(NamedTuple):
    """The parts of `LoopState` that say where the run is and what has been seen of its maxima."""

    point: Point
    step_end: Point
    extremes: Extremes
    located: Bool[Array, " observables"]
    given_up: Bool[Array, " observables"]


def advance(task: Task[P], state: LoopState, trial: Trial, decision: Decision, event: Event) -> Advance:
    """Move to the step's end if it is accepted; to the end of the longer step that stands if a maximum has been looked
    back at.

    A maximum located here, or one of the state's rate that was given up as noise, must not be found again: it is marked
    as ``located``. Those whose search led hardly further, or was in vain, are not looked for at all in the next step:
    what rounding makes of a force that is zero has maxima everywhere, and the run would never get away from them. The
    largest force of a contact is that of its present impact, so that every impact's peak is located.
    """
    accepted, mine = decision.accepted, task.observable_of(state.bracket.guard)
    reached = Point(
        event.time, event.rows, trial.step.rate, _after(task, trial, event), state.point.change + trial.change
    )
    returns = event.maximum & state.looking_back
    extremes = state.extremes.including(trial.guards.value)
    begins = event.touchdown & (task.each_observable == event.guard)
    # The guards of contacts without a force among the observables have the numbers of other observables.
    if (forces := task.system.contact_observables) is not None and forces < task.contacts:
        begins = begins & (event.guard < forces)
    extremes = Extremes(*(jnp.where(begins, 0.0, value) for value in extremes))
    extremes = where(returns, extremes.including(state.step_end.guards.value), extremes)
    sought = state.locating & mine & ~returns
    located = sought & (decision.refinement.occurred | task.of_rate)
    hardly = trial.length <= HARDLY * jnp.min(state.step_sizes.steps)
    in_vain = sought & (state.bracket.tries >= MAX_TRIES_MAXIMUM) & ~decision.refinement.converged
    given_up = ((sought | state.given_up) & hardly | in_vain) & ~returns
    return Advance(
        point=where(returns, state.step_end, where(accepted, reached, state.point)),
        step_end=where(decision.outcome == StepOutcome.LOOK_BACK, reached, state.step_end),
        extremes=where(accepted, extremes, state.extremes),
        located=jnp.where(accepted, located, state.located),
        given_up=jnp.where(accepted, given_up, state.given_up),
    )


def _after(task: Task[P], trial: Trial, event: Event) -> Guards:
    """Return the guards at the step's end, with the invariant as it is once a contact has closed or opened there.

    The step ends a little beside the event, so that the energy stored in the contact appears or vanishes at once. That
    is no error of the next step, which would be refused for it however short it is.
    """
    changed = lambda: task.system.invariant(event.rows[0], event.active)[0]  # noqa: E731
    invariant = lax.cond(event.of_contact, changed, lambda: trial.guards.invariant)
    return trial.guards._replace(invariant=invariant)


def next_step_sizes(task: Task[P], state: LoopState, trial: Trial, decision: Decision, event: Event) -> StepSizes:
    """Return the controller's next state.

    It learns from steps whose length it chose itself: those that are accepted, refused or look back, not from those
    that end on an event. A location given up is a step refused, and since the longer step in which the event was found
    may be another method's, both methods' steps are cut; so they are where an event may begin and end within a step. An
    impact begins with steps of its own; out of contact again, steps go on as they went before.
    """
    outcome = decision.outcome
    # Nor from the one that ends because the time is up, which may be far shorter than accuracy asks for.
    chosen = ~state.locating & ~state.reevaluating & ~event.timed_out
    looks_back, abandoned = outcome == StepOutcome.LOOK_BACK, outcome == StepOutcome.ABANDON
    learns = (outcome == StepOutcome.REJECT) | looks_back | abandoned | decision.accepted & chosen
    # The controller cuts a step with an infinite norm to a tenth.
    norm = jnp.where(trial.finite, trial.norm, jnp.inf)
    stands = decision.accepted | looks_back
    adapted = task.options.controller.adapt(
        state.step_sizes, trial.method, trial.length, norm, trial.step.order, stands
    )
    sizes = where(learns, adapted, state.step_sizes)
    shorter = jnp.minimum(sizes.steps, sizes.steps[trial.method])
    sizes = sizes._replace(steps=jnp.where(abandoned, shorter, sizes.steps))
    cut = jnp.minimum(sizes.steps, decision.shorter)
    sizes = sizes._replace(steps=jnp.where(outcome == StepOutcome.SHORTEN, cut, sizes.steps))
    # Last, since touchdowns and releases replace whatever the step has taught.
    sizes = where(event.touchdown, StepSizes.of(event.contact_step, len(task.options.solver.methods)), sizes)
    return where(event.release, state.step_sizes_before_contact, sizes)


def next_phase(
    task: Task[P], state: LoopState, decision: Decision, event: Event, point: Point, step_sizes: StepSizes
) -> tuple[Int[Array, ""], Bracket]:
    """Return what the next trial step is for, and the bracket of the event to locate.

    The table of transitions says it, with two exceptions after an accepted step. The derivative is evaluated again
    after an event that changes observables at once, after a touchdown whose gap could not be brought to zero, and with
    tangents after a release: there dF/dp ∝ √gap, so a rounding-level gap makes it inaccurate. And a release so near
    that no other step can be accurate is located at once, without a longer step that finds it first.
    """
    deep = event.touchdown & ~decision.refinement.converged
    reevaluate = task.sudden(event.kind) | deep | event.release & bool(task.tangents.count)
    contact, release = next_release(point.guards, event.active)
    near = release <= jnp.minimum(event.contact_step, step_sizes.steps[0])
    near = decision.accepted & ~event.of_contact & near
    phase = following(state.phase, decision.outcome)
    phase = jnp.where(near, int(Phase.LOCATE), jnp.where(reevaluate, int(Phase.REEVALUATE), phase))
    return phase, where(near, Bracket.around_release(contact, release, point.guards.gap), decision.bracket)


def next_status(
    task: Task[P], state: LoopState, trial: Trial, decision: Decision, event: Event, step_sizes: StepSizes
) -> Int[Array, ""]:
    """Return whether and how the run ends here."""
    refused = (decision.outcome == StepOutcome.REJECT) | (decision.outcome == StepOutcome.ABANDON)
    # A step of length zero cannot be shortened. That another method's step is short, as it is where that method last
    # went from one event to the next, says nothing of this one's.
    stuck = refused & (state.reevaluating | (step_sizes.steps[trial.method] < SHORTEST))
    timeout = jnp.where(event.timed_out, Status.TIMEOUT, Status.RUNNING)
    status = jnp.where(event.terminal, event.guard - task.contacts, timeout)
    # A step that ends the run ends it, whatever else is wrong with it: failures are looked at only while it goes on.
    for failed, code in (
        (state.attempts + 1 >= task.options.max_steps, Status.TOO_MANY_STEPS),
        (stuck & trial.finite, Status.STEP_TOO_SMALL),
        (stuck & ~trial.finite, Status.NOT_FINITE),
    ):
        status = jnp.where((status == Status.RUNNING) & failed, code, status)
    return status
