"""One step of a Runge-Kutta method on columns (the state and its tangents).

All stages run through one loop, explicit and implicit ones alike, so that the right-hand side, by far the largest part
of the program, is compiled once.
"""

import dataclasses
from collections.abc import Callable
from typing import NamedTuple, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from ..sensitivity.augmented_state import Columns, Rows
from ..system import Linearisation, State
from .newton import NewtonMatrix, summed
from .tableaus import Method
from .time_transform import TimeTransform

Field = Callable[[Float[Array, ""], Columns], Columns]
T = TypeVar("T")
put = lax.dynamic_update_index_in_dim
CONVERGED = 0.02  # of the allowed error: the last change of an implicit stage that is small enough
MAX_ITERATIONS = 8  # of Newton's method beyond the first; then the step is refused


class SecondDerivative(NamedTuple):
    """A wish for the second derivative at the step's end.

    It comes from two more evaluations of the field, ``spacing`` after and before the end along the tangent: two stages
    more, where a push-forward of the field would be compiled anew (a fifth of a capture's compilation).

    ``needed``: (state, its derivative) at the step's end → whether; ``spacing`` [s].
    """

    needed: Callable[[State, State], Bool[Array, ""]]
    spacing: Float[Array, ""]


class Step(NamedTuple):
    """The result of a step, in columns as a method returns it, in rows in the loop.

    ``end``: the state; ``rate``: its derivative there; ``error``: the estimate of the local error; ``order`` of that
    estimate; ``second``: the second derivative at the end, zeros where it is not wanted.
    """

    end: Rows | Columns
    rate: Rows | Columns
    error: Rows | Columns
    order: Float[Array, ""]
    second: Rows | Columns

    def padded(self, count: int) -> "Step":
        """Append ``count`` rows of zeros."""
        rows = lambda x: jnp.pad(x, [(0, count), (0, 0)])  # noqa: E731
        return Step(rows(self.end), rows(self.rate), rows(self.error), self.order, rows(self.second))


class _StageState(NamedTuple):
    """What the loop over stages carries.

    ``stage`` that is being solved for; ``iterations`` of Newton's method in it so far; ``known``: the start plus the
    weighted sum of the earlier slopes; ``increment``: the guess of what this stage adds to that; ``slopes`` so far,
    each times dt/dx but the last stage's (and, after it, those on either side of the step's end); ``unconverged``: the
    change over what is allowed where an implicit stage was given up; ``needed``: number of stages to evaluate.
    """

    stage: Int[Array, ""]
    iterations: Int[Array, ""]
    known: Columns
    increment: Columns
    slopes: Float[Array, "stages state columns"]
    unconverged: Float[Array, ""]
    needed: Int[Array, ""]


def take_step(
    method: Method,
    field: Field,
    stiff: Linearisation | None,
    time: Float[Array, ""],
    columns: Columns,
    rate: Columns,
    transform: TimeTransform,
    allowance: Columns,
    second: SecondDerivative | None,
) -> Step:
    """Advance columns by one step.

    An implicit stage y = known + shift f(y) is solved by Newton's method until what changes is far below the allowed
    error. Its matrix holds the stiff forces at the step's start only (see `NewtonMatrix`). Tangents are iterated with
    the state, by the same matrix.

    In a step of length zero nothing moves: it evaluates the derivative alone, which is the last stage.

    **Arguments:** ``method``; the ``field`` (time [s], columns) → derivative; ``stiff``: its stiff part at the start,
    None if no method is implicit; ``time`` [s], ``columns`` and their ``rate`` at the start; ``transform``: the step's
    length and how time passes in it; ``allowance``: the error allowed in each number; ``second``: when the second
    derivative at the end is wanted, None for never.
    """
    stages = _Stages.of(method, field, stiff, time, columns, transform, allowance, second)
    last = stages.last
    room = len(method.nodes) + 2 * (second is not None)
    # The first stage needs no evaluation: its slope is that of the last stage of the step before.
    slopes = jnp.zeros((room, *columns.shape)).at[0].set(stages.time_rates[0] * rate)
    first = jnp.where(transform.length > 0.0, 1, last)
    s = _StageState(
        stage=first,
        iterations=0 * first,
        known=stages.known(1, slopes),
        increment=method.gamma * slopes[0],
        slopes=slopes,
        unconverged=jnp.zeros(()),
        needed=stages.count,
    )
    s = lax.while_loop(lambda s: s.stage < s.needed, stages.iterate, s)
    return Step(
        # The weights of the last stage are those of the solution.
        end=s.known,
        error=stages.error(s),
        rate=lax.dynamic_index_in_dim(s.slopes, last, keepdims=False),
        order=jnp.asarray(method.order, float),
        second=stages.second_derivative(s),
    )


@dataclasses.dataclass(frozen=True)
class _Stages:
    """What all stages of one step share.

    ``strictness``: one over the allowance; ``times`` [s] of the stages and ``time_rates``, dt/dx there [s]; ``shift``
    [s]: γ times the step; ``newton``: None if no method is implicit. The rest: see `take_step`.
    """

    method: Method
    field: Field
    columns: Columns
    allowance: Columns
    strictness: Columns
    second: SecondDerivative | None
    times: Float[Array, " stages"]
    time_rates: Float[Array, " stages"]
    shift: Float[Array, ""]
    newton: NewtonMatrix | None

    @staticmethod
    def of(
        method: Method,
        field: Field,
        stiff: Linearisation | None,
        time: Array,
        columns: Columns,
        transform: TimeTransform,
        allowance: Columns,
        second: SecondDerivative | None,
    ) -> "_Stages":
        """Compute the times of the stages and, for an implicit method, Newton's matrix."""
        time_rates, times = transform.derivative(method.nodes), time + transform.elapsed(method.nodes)
        shift = method.gamma * transform.length
        # The method is chosen at run time: `_only_if` spares an explicit step the inverse.
        newton = None
        if stiff is not None:
            newton = _only_if(jnp.asarray(method.gamma) > 0.0, lambda: NewtonMatrix.of(stiff, shift))
        return _Stages(method, field, columns, allowance, 1.0 / allowance, second, times, time_rates, shift, newton)

    @property
    def count(self) -> Int[Array, ""]:
        """Return the number of stages of the method in use."""
        return jnp.asarray(self.method.stages)

    @property
    def last(self) -> Int[Array, ""] | int:
        """Return the stage at the step's end."""
        return self.method.stages - 1

    def time_of(self, stage: Int[Array, ""]) -> Float[Array, ""]:
        """Return the time of a stage [s]; beyond the last one those of the second derivative follow."""
        if self.second is None:
            return self.times[stage]
        beside = self.second.spacing * (1 + 2 * (self.count - stage))
        return self.times[jnp.minimum(stage, self.last)] + jnp.where(stage > self.last, beside, 0.0)

    def known(self, stage: Int[Array, ""] | int, slopes: Array) -> Columns:
        """Return the start plus the weighted sum of the slopes before a stage."""
        return self.columns + _weighted(self.method.weights, self.method.first + stage, slopes)

    def _next_known(self, s: _StageState, done: Bool[Array, ""], slopes: Array) -> Columns:
        """Return `known` of the next stage once this one is done.

        With tangents the slopes do not fit the fastest cache: in the first half of the stages only these are read.
        """
        if self.columns.shape[1] == 1:
            return jnp.where(done, self.known(s.stage + 1, slopes), s.known)
        half = len(slopes) // 2
        which = jnp.where(done, jnp.where(s.stage < half, 1, 2), 0)
        early = lambda: self.known(s.stage + 1, slopes[:half])  # noqa: E731
        return lax.switch(which, [lambda: s.known, early, lambda: self.known(s.stage + 1, slopes)])

    def error(self, s: _StageState) -> Columns:
        """Return the estimate of the local error: E₅² / √(E₅² + E₃²/100) where a coarser estimate steadies it (Hairer's
        DOP853), plus what an implicit stage that did not converge leaves open."""
        # the last stage's slope, unlike the others, is not yet times dt/dx
        last = jnp.arange(len(self.method.nodes)) == self.last
        weights = self.method.errors * jnp.where(last, self.time_rates[self.last], 1.0)[None]
        # Two estimates of orders 5 and 3 together are of order 8; a method with one has zeros as the other.
        fine, coarse = (_weighted(weights, k, s.slopes) for k in range(2))
        return fine**2 / jnp.sqrt(fine**2 + 0.01 * coarse**2 + 1e-300) + s.unconverged * self.allowance

    def second_derivative(self, s: _StageState) -> Columns:
        """Return the second derivative at the step's end, from the two slopes beside it; zeros where it is not
        wanted."""
        if self.second is None:
            return jnp.zeros_like(self.columns)
        after, before = (lax.dynamic_index_in_dim(s.slopes, self.count + k, keepdims=False) for k in range(2))
        return jnp.where(s.needed > self.count, (after - before) / (2.0 * self.second.spacing), 0.0)

    def iterate(self, s: _StageState) -> _StageState:
        """Evaluate the field once: all of an explicit stage, one iteration of Newton's method in an implicit one."""
        slope = self.field(self.time_of(s.stage), s.known + s.increment)
        change, gain, size = self._newton_iteration(s, slope)
        # Written so that NaN counts as converged: no iteration mends it, and the step is refused for it.
        converged = ~(size > CONVERGED)
        done = converged | (s.iterations >= MAX_ITERATIONS)
        # The step is over at once: what is left open enters the error, which is then too large.
        failed = done & ~converged
        slopes = put(s.slopes, gain, s.stage, 0)
        increment, needed = self._next_increment(s, slope, gain)
        return _StageState(
            stage=jnp.where(failed, self.count, s.stage + done),
            iterations=jnp.where(done, 0, s.iterations + 1),
            known=self._next_known(s, done & (s.stage < self.last), slopes),
            increment=jnp.where(done, increment, s.increment + change),
            slopes=slopes,
            unconverged=jnp.where(failed, size / CONVERGED, s.unconverged),
            needed=needed,
        )

    def _newton_iteration(self, s: _StageState, slope: Columns) -> tuple[Columns, Columns, Float[Array, ""]]:
        """Return the change of an implicit stage's increment (zero in an explicit one), the slope times dt/dx that
        follows from it, and the change's size over the allowed error."""
        change, size = jnp.zeros_like(self.columns), jnp.zeros(())
        gain = jnp.where(s.stage < self.last, self.time_rates[s.stage], 1.0) * slope
        if self.newton is None:
            return change, gain, size
        gamma, matrix = self.method.gamma, self.newton
        implicit = (jnp.asarray(gamma) > 0.0) & (s.stage < self.last)

        def solved() -> tuple[Columns, Array]:
            change = matrix.solve(self.shift * slope - s.increment)
            squares = summed((change * self.strictness) ** 2) / len(change)
            return change, jnp.sqrt(jnp.max(squares))

        change, size = lax.cond(implicit, solved, lambda: (change, size))
        # The slope from the increment, not from the field: stiff forces would amplify in it what the iteration leaves
        # open.
        return change, jnp.where(implicit, (s.increment + change) * (1.0 / gamma), gain), size

    def _next_increment(self, s: _StageState, slope: Columns, gain: Columns) -> tuple[Columns, Int[Array, ""]]:
        """Return the first guess of the next stage's increment, and the number of stages wanted, which the last one
        knows."""
        increment = jnp.where(s.stage < self.last - 1, self.method.gamma, 0.0) * gain
        if self.second is None:
            return increment, s.needed
        # Beyond the end: first a little after it along the slope, then as far before it.
        beside = jnp.where(s.stage == self.last, self.second.spacing * slope, -s.increment)
        needed = (s.stage == self.last) & self.second.needed(s.known[:, 0], slope[:, 0])
        return jnp.where(s.stage < self.last, increment, beside), jnp.where(needed, self.count + 2, s.needed)


def _weighted(weights: Array | np.ndarray, i: Int[Array, ""] | int, slopes: Array) -> Columns:
    """Sum all stages' slopes by row ``i`` of the weights."""
    row = lax.dynamic_index_in_dim(jnp.asarray(weights), i, keepdims=False)
    # written out: one pass over all numbers, in vector instructions (a sum over an axis costs a gradient 12 %)
    total = row[0] * slopes[0]
    for k in range(1, min(len(row), len(slopes))):
        total = total + row[k] * slopes[k]
    return total


def _only_if(condition: Array, make: Callable[[], T]) -> T:
    """Return what ``make`` returns, or zeros without the work."""
    shapes = jax.eval_shape(make)
    return lax.cond(condition, make, lambda: jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), shapes))
