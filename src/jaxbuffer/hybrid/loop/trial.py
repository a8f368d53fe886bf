"""A trial step: which method takes it, how long it is, whether with tangents, and how large its error is."""

from typing import NamedTuple, TypeVar

import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from ..._types import Scalar
from ..events.guards import Guards, near_largest, observe
from ..events.prediction import longest_step, next_release, next_touchdown
from ..rungekutta.stages import SecondDerivative, Step
from ..rungekutta.time_transform import TimeTransform
from ..sensitivity.augmented_state import Rows, Tangents, columns
from ..system import Linearisation
from ..trees import where
from .state import LoopState
from .task import Task

P = TypeVar("P")
BEFORE_RELEASE = 0.6  # of the predicted time to a release: near it only a step that ends on it is accurate
ADDED, LEAST_SHARE = 0.3, 1e-4  # see `_allowed_change`
LINEAR, LEAST_SHORTFALL = 3.0, 1e-6  # see `_linear_time`
EVEN = 0.01  # of a step as accuracy allows: how far beside its end a state in free flight is taken to change evenly
SPACING = 1e-3  # of a step as accuracy allows: how far beside its end the second derivative is taken from


class Trial(NamedTuple):
    """A trial step and what is seen of it.

    ``method`` that took it; its ``length`` [s]; whether ``with_tangents`` or with the state alone; the ``step`` itself;
    ``guards`` at its end; ``change`` of the invariant; ``state_norm``, ``norm``: its error over what is allowed, of the
    state alone and with the tangents; ``finite``: whether all numbers are; ``linear_time`` [s]: for how long the state
    at its end changes evenly, at its rate there.
    """

    method: Int[Array, ""]
    length: Float[Array, ""]
    with_tangents: Bool[Array, ""]
    step: Step
    guards: Guards
    change: Float[Array, ""]
    state_norm: Float[Array, ""]
    norm: Float[Array, ""]
    finite: Bool[Array, ""]
    linear_time: Float[Array, ""]

    @property
    def accurate(self) -> Bool[Array, ""]:
        """Return whether the error is allowed."""
        return self.norm <= 1.0


def take_trial(task: Task[P], state: LoopState) -> Trial:
    """Take the trial step that the phase asks for.

    Tangents cost several times as much as the state alone. They take part only where the step is likely to succeed: not
    while an event is being located, nor where a touchdown or a release is predicted within the step. A step of the
    state alone that succeeds is taken again with tangents (`Phase.RETAKE_STEP` and the like).
    """
    system, tangents, tolerance, point = task.system, task.tangents, task.options.tolerance, state.point
    stiff = system.linearisation(point.time, point.rows[0], state.active)
    touchdown = next_touchdown(point.guards, state.active)
    _, release = next_release(point.guards, state.active)
    longest = longest_step(point.guards, state.active, system.gap_depths())
    method, length = _method_and_length(task, state, stiff, longest, release)

    def step_of(tangents: Tangents[P], rows: Rows, rate: Rows) -> Step:
        return _step(task, state, stiff, method, length, tangents, rows, rate)

    def with_all() -> Step:
        return step_of(tangents, point.rows, point.rate)

    def state_alone() -> Step:
        # Both branches of `cond` must have the same shape: zeros stand for the tangents.
        return step_of(Tangents(tangents.primal), point.rows[:1], point.rate[:1]).padded(tangents.count)

    with_tangents = state.retaking | ~state.locating & (length < jnp.minimum(touchdown, release))
    # Without tangents there is one branch, and the right-hand side is compiled once.
    step = lax.cond(with_tangents, with_all, state_alone) if tangents.count else state_alone()
    norms = tolerance.norms(step.error, point.rows, step.end, system)
    guards = observe(system, step.end[0], step.rate[0], step.second[0], state.active)
    # An estimate from a few stages may miss what is not smooth between them, a tip that begins to roll say; the
    # invariant shows it. Where it is evaluated anew it may have jumped.
    change = jnp.where(state.reevaluating, 0.0, guards.invariant - point.guards.invariant)
    allowed = _allowed_change(point.change, system.invariant_change, tolerance.rtol) + guards.invariant_rounding
    state_norm = jnp.maximum(norms[0], jnp.abs(change) / allowed)
    # Beside a touchdown or a release tangents change with a root of the gap, of which less and less is more than
    # rounding: in a step shorter than events are located, their error is not known, and the state decides alone.
    norm = jnp.where(length > task.event_time, jnp.maximum(state_norm, jnp.max(norms)), state_norm)
    # The last norm too, since the invariant is in it and not in the others.
    finite = jnp.all(jnp.isfinite(norms)) & jnp.isfinite(norm) & jnp.all(jnp.isfinite(step.rate))
    linear = _linear_time(stiff, task.shortfall, jnp.min(state.step_sizes.steps))
    return Trial(method, length, with_tangents, step, guards, change, state_norm, norm, finite, linear)


def _linear_time(stiff: Linearisation, shortfall: Scalar, step: Scalar) -> Float[Array, ""]:
    """Return for how long a state changes evenly, at its rate, to some ``shortfall`` of a force that swings [s].

    With ω the fastest rate of the stiff forces, a force at its top is moved over a time t too high by (ωt)²/2 of it. A
    step that falls short of its own maximum by just the shortfall, (ωt)²/2 of that too, is well within this time.
    Tighter tolerances make it no shorter: the times of a struck beam's maxima are then less exact, not more. Where no
    stiff force acts, a small part of a ``step`` as accuracy allows is all that the state is known to be even over.
    """
    fastest, allowed = stiff.fastest(), jnp.maximum(shortfall, LEAST_SHORTFALL)
    acts = fastest > 0.0
    return jnp.where(acts, LINEAR * jnp.sqrt(allowed) / jnp.where(acts, fastest, 1.0), EVEN * step)


def _allowed_change(change: Scalar, share: Scalar, rtol: Scalar) -> Float[Array, ""]:
    """Return by how much a step may change the invariant, which all steps before it have changed by ``change``.

    It is a ``share`` of the tolerance, and less the more they have changed it. What vibrates loses a little in each of
    thousands of steps, always with one sign: with a fixed share, the sum would grow with their number.
    """
    return share * rtol * _share_left(change, rtol)


def _share_left(change: Scalar, rtol: Scalar) -> Float[Array, ""]:
    """Return which share of what a step may change the invariant by is left after a ``change`` by all steps before."""
    return jnp.maximum(jnp.exp(-((change / (ADDED * rtol)) ** 2)), LEAST_SHARE)


def _method_and_length(
    task: Task[P],
    state: LoopState,
    stiff: Linearisation,
    longest: Float[Array, ""],
    release: Float[Array, ""],
) -> tuple[Int[Array, ""], Float[Array, ""]]:
    """Choose the method that takes the step, and its length [s].

    A step that looks for the next touchdown is no longer than ``longest`` [s]; and it stays well before the next
    predicted ``release`` [s], unless that is so near that a step onto it is accurate. To locate an event, the bracket
    says the length.
    """
    solver, bracket, locating = task.options.solver, state.bracket, state.locating
    before_release = jnp.where(release > state.contact_step, BEFORE_RELEASE * release, jnp.inf)
    method, length = solver.choose(stiff, jnp.minimum(state.step_sizes.steps, before_release))
    method = jnp.where(locating, solver.method_for(stiff, bracket.step), method)
    length = jnp.minimum(length, longest)
    length = jnp.where(locating, bracket.step, jnp.minimum(length, task.duration - state.point.time))
    return method, jnp.where(state.reevaluating, 0.0, length)


def _time_transform(task: Task[P], state: LoopState, method: Array, length: Array) -> TimeTransform:
    """Return how time passes in the step. Explicit steps are even in the root of the time from the last touchdown, or
    to the release they are to end on; implicit ones are even in time, since one matrix serves all their stages."""
    closed = jnp.any((task.each_contact == state.bracket.guard) & (state.active > 0.5))
    # The step onto a touchdown may end a little before it.
    elapsed = jnp.maximum(state.point.time - state.last_touchdown, 0.0)
    onto_release, after = TimeTransform.onto_release(length), TimeTransform.after_touchdown(elapsed, length)
    transform = where(state.locating & closed, onto_release, after)
    return where(task.options.solver.is_implicit(method), TimeTransform.uniform(length), transform)


def _step(
    task: Task[P],
    state: LoopState,
    stiff: Linearisation,
    method: Int[Array, ""],
    length: Float[Array, ""],
    tangents: Tangents[P],
    rows: Rows,
    rate: Rows,
) -> Step:
    """Step the given ``rows``, with their ``rate``, from the present point."""
    system, point, active = task.system, state.point, state.active
    second = None
    # The rate of an observable that depends on the state's rate takes the state's second derivative.
    if system.observes_rate:
        before, extremes = point.guards.value, state.extremes
        near = lambda y, rate: near_largest(system, y, rate, active, before, extremes)  # noqa: E731
        second = SecondDerivative(near, SPACING * jnp.min(state.step_sizes.steps))
    field = lambda time, at: tangents.field(lambda p, y: task.build(p).derivative(time, y, active))(at)  # noqa: E731
    tolerance = task.options.tolerance
    # What Newton's method leaves open changes the invariant too, and no estimate of the error shows it.
    allowed = _share_left(point.change, tolerance.rtol) * tolerance.allowance(rows, system)
    # columns that are padding are zeros: any allowance does
    allowance = jnp.maximum(columns(allowed), 1e-300)
    step = task.options.solver.step(
        method,
        field,
        stiff,
        point.time,
        columns(rows),
        columns(rate),
        _time_transform(task, state, method, length),
        allowance,
        second,
    )
    # Steps work on columns, since the compiler has vector instructions for the tangents of one number; the loop keeps
    # rows.
    back = lambda columns: columns.T[: rows.shape[0]]  # noqa: E731
    return Step(back(step.end), back(step.rate), back(step.error), step.order, back(step.second))
