"""What becomes of a trial step: one `StepOutcome`, and what is known of the event that is being located."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ...duplication import evaluated_once
from ..events.bracketing import MAX_TRIES, MAX_TRIES_MAXIMUM, Bracket, Refinement, refine
from ..events.crossing import NEARLY, Crossing, first_crossing
from ..events.excursion import excursion_in_step
from ..events.guards import Guards, signed
from ..events.reversal import reversal_in_step
from ..trees import where
from .phase import StepOutcome
from .state import LoopState
from .task import Task
from .trial import Trial

ROUNDING = 1e-15  # of the largest coordinate: by so much rounding may change a gap
OVERSHOT = 5.0  # times the allowed error: a step beyond an event may miss by that and still say where the event is


class Decision(NamedTuple):
    """``outcome`` of the trial step; ``bracket`` to go on with; ``refinement``: what the step showed of the event that
    was being located, if any; ``shorter`` [s]: the step to take instead where the outcome is to shorten it."""

    outcome: Int[Array, ""]
    bracket: Bracket
    refinement: Refinement
    shorter: Float[Array, ""]

    @property
    def accepted(self) -> Bool[Array, ""]:
        """Return whether the run goes on from the step's end at once."""
        return self.outcome == StepOutcome.ACCEPT


def decide(task: Task, state: LoopState, trial: Trial) -> Decision:
    """Decide what becomes of a trial step.

    A step that holds an event is taken again, shortened until it ends on the event, and the run goes on from there.
    Only where the event is a maximum and nothing else, the step itself stands: the run looks back at the maximum and
    then goes on from the step's end. A step whose error is too large may show a touchdown (the error of an explicit
    step that overshoots an event is mostly what is not smooth there), but no maximum.

    On arrival at an event another one may turn out to lie a little before. Then that one is located first, unless too
    many tries have been spent, or the two are one: both guards jump within the time tolerance. And a step that would
    stand is shortened where a guard may have risen above zero and fallen again within it.
    """
    bracket = state.bracket
    before = state.point.guards.falling(state.located)
    guards = signed(trial.guards, state.active)
    # A maximum matters only if it may exceed the largest value so far; the cubic that shows it may miss by `NEARLY`.
    least = jnp.maximum(state.extremes.below_largest(NEARLY), task.system.roundoff())
    maxima = trial.accurate & (bracket.tries < MAX_TRIES_MAXIMUM) & ~state.given_up
    crossing = first_crossing(before, trial.guards, trial.length, state.active, least, bracket.guard, maxima)
    # How far below its maximum an observable may be where a step onto that maximum ends.
    mine, extent = task.observable_of(bracket.guard), state.extremes.including(trial.guards.value).extent
    shortfall = task.shortfall * jnp.sum(jnp.where(mine, extent, 0.0))
    rounding = ROUNDING * jnp.max(jnp.abs(trial.step.end[0, : task.system.coordinates]), initial=0.0)
    refinement = refine(
        bracket, trial.length, guards, task.rated, task.event_time, shortfall, trial.linear_time, rounding
    )
    # In most parts of the loop the outcome decides.
    outcome = evaluated_once(_outcome(task, state, trial, crossing, refinement).astype(float)).astype(int)
    shorter = _shorter(task, state, trial, outcome, before)
    outcome = jnp.where(shorter < trial.length, int(StepOutcome.SHORTEN), outcome)
    return Decision(outcome, _next_bracket(state, outcome, crossing, refinement, before), refinement, shorter)


def _shorter(task: Task, state: LoopState, trial: Trial, outcome: Int[Array, ""], before: Guards) -> Float[Array, ""]:
    """Return the length of the step [s], or of a shorter one to take instead where an event may begin and end within
    it, or where a force reverses."""
    stands = (outcome == StepOutcome.ACCEPT) | (outcome == StepOutcome.LOOK_BACK) | (outcome == StepOutcome.RETAKE)
    # Shorter steps than events are located to resolve nothing more.
    stands = stands & (trial.length > task.event_time)
    point, step = state.point, trial.step
    fraction = excursion_in_step(
        task.system,
        start=(point.rows[0], point.rate[0]),
        end=(step.end[0], step.rate[0]),
        before=before,
        after=trial.guards,
        step=trial.length,
        active=state.active,
        located=state.bracket.guard,
        when=stands,
    )
    reversal = jnp.where(stands, reversal_in_step(before, trial.guards), 1.0)
    return jnp.minimum(fraction, reversal) * trial.length


def _outcome(task: Task, state: LoopState, trial: Trial, crossing: Crossing, refinement: Refinement) -> Int[Array, ""]:
    """Return the first outcome in the list whose condition holds."""
    locating, accurate, finite = state.locating, trial.accurate, trial.finite
    overshot = jnp.where(task.options.solver.is_implicit(trial.method), 1.0, OVERSHOT)
    from_step = ~locating & ~state.reevaluating & (trial.state_norm <= overshot)
    at_once = refinement.bracket.clear & refinement.bracket.is_closed(task.event_time)
    on_arrival = locating & refinement.finished & (state.bracket.tries < MAX_TRIES) & ~at_once
    holds_event = (from_step | on_arrival) & finite & crossing.exists
    only_maximum = holds_event & ~locating & accurate & crossing.alone & (crossing.guard >= task.rated)
    succeeds = accurate & finite & (~locating | refinement.finished) & (~holds_event | only_maximum)
    lacks_tangents = ~trial.with_tangents & bool(task.tangents.count)
    return _first(
        (succeeds & lacks_tangents, StepOutcome.RETAKE),
        (only_maximum, StepOutcome.LOOK_BACK),
        (holds_event, StepOutcome.LOCATE),
        (succeeds, StepOutcome.ACCEPT),
        (~locating, StepOutcome.REJECT),
        (_narrows_bracket(task, trial) & ~refinement.finished, StepOutcome.REFINE),
        otherwise=StepOutcome.ABANDON,
    )


def _narrows_bracket(task: Task, trial: Trial) -> Bool[Array, ""]:
    """Return whether the end of a step says where the event lies that is being located.

    Newton's method solves some long implicit steps wrongly, which their error shows: their ends say nothing of the
    event, and would leave a bracket that does not hold it. A shorter step is solved again.
    """
    implicit = task.options.solver.is_implicit(trial.method)
    return trial.finite & (~implicit | (trial.state_norm <= OVERSHOT))


def _first(*cases: tuple[Bool[Array, ""], StepOutcome], otherwise: StepOutcome) -> Int[Array, ""]:
    """Return the outcome of the first condition that holds."""
    chosen = jnp.asarray(int(otherwise))
    # From last to first, so that the first condition that holds has the last word.
    for condition, outcome in reversed(cases):
        chosen = jnp.where(condition, int(outcome), chosen)
    return chosen


def _next_bracket(
    state: LoopState,
    outcome: Int[Array, ""],
    crossing: Crossing,
    refinement: Refinement,
    before: Guards,
) -> Bracket:
    """Return the bracket to go on with: that of a new event, that of the one being located, or none."""
    # Counted over all events from one start: events that take each other's place must come to an end too.
    tries = jnp.where(state.locating, state.bracket.tries + 1, 0)
    around = Bracket.around(crossing, signed(before, state.active).value, tries)
    located = where(outcome == StepOutcome.REFINE, refinement.bracket, Bracket.none())
    located = where((outcome == StepOutcome.LOCATE) | (outcome == StepOutcome.LOOK_BACK), around, located)
    # Taken again with tangents, the step may end a little beside its event; that it has converged is remembered.
    again = state.bracket._replace(converged=refinement.converged)
    return where(outcome == StepOutcome.RETAKE, again, located)
