"""One step of a Runge-Kutta method on columns: every stage runs through one loop, so that the right-hand side, the dear
part, is compiled once."""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from ..mechanisms.hybrid import Linearisation, State
from ..multibody import inverse
from .lanes import Columns, Rows
from .methods import Method
from .stride import Stride

Field = Callable[[Float[Array, ""], Columns], Columns]
T = TypeVar("T")
put = lax.dynamic_update_index_in_dim
SOLVED = 0.02  # of the allowed error: the last change of a stage's iteration that is small enough
MOST_IMPROVEMENTS = 8  # to improve a stage; then the step is refused


class Watch(NamedTuple):
    """When the second derivative is wanted, at the end of a step: where ``near`` says so of the state and its
    derivative there. It comes from two derivatives ``apart`` [s] after and before, along the tangent: two stages more,
    where a push-forward of the field would be compiled anew, a fifth of a capture's compilation."""

    near: Callable[[State, State], Bool[Array, ""]]
    apart: Float[Array, ""]


class Step(NamedTuple):
    """A trial step: state and derivative at its end, the estimate of its local error and that estimate's order; in
    columns as a method returns it, in rows for the loop. ``second``: the second derivative there, zeros where it is not
    watched."""

    end: Rows | Columns
    rate: Rows | Columns
    error: Rows | Columns
    order: Float[Array, ""]
    second: Rows | Columns

    def filled_up(self, count: int) -> "Step":
        """With ``count`` rows of zeros more."""
        rows = lambda x: jnp.pad(x, [(0, count), (0, 0)])  # noqa: E731
        return Step(rows(self.end), rows(self.rate), rows(self.error), self.order, rows(self.second))


class _Stages(NamedTuple):
    """Stages on their way: which one is being solved for, how often it was improved, what the earlier ones add up to
    and the guess of what this one adds; all slopes so far times the pace (the last one as it is, and after it those
    beside the end); the norm of the error of a stage given up; how many slopes are wanted."""

    i: Int[Array, ""]
    tries: Int[Array, ""]
    known: Columns
    guess: Columns
    slopes: Float[Array, "stages state lanes"]
    left: Float[Array, ""]
    wanted: Int[Array, ""]


def take(
    method: Method,
    field: Field,
    stiff: Linearisation | None,
    time: Float[Array, ""],
    columns: Columns,
    rate: Columns,
    stride: Stride,
    allowance: Columns,
    watch: Watch | None,
) -> Step:
    """Advance columns from ``time`` by a stride; ``rate`` is the field there. ``stiff``: its stiff part there, None
    for explicit methods alone; ``allowance``: the error allowed in each number; ``watch``: None for no second
    derivative.

    An implicit stage y = known + shift f(y) is iterated by Newton's method until what changes is far below the
    allowance. Its Jacobian holds the stiff forces at the step's start only: of low rank, so that the linear solve is a
    small dense one (Woodbury) and never a library call. Sensitivities are iterated with the state, by the same matrix.
    """
    pace, times = stride.pace(method.nodes), time + stride.passed(method.nodes)
    none = jnp.zeros_like(columns)
    shift = method.gamma * stride.length
    solve = None
    if stiff is not None:
        solve = _only_if(jnp.asarray(method.gamma) > 0.0, lambda: Shifted.of(stiff, shift))

    def known_of(i: Int[Array, ""] | int, slopes: Array) -> Columns:
        return columns + _weighted(method.weights, method.first + i, slopes)

    last, stages = method.stages - 1, jnp.asarray(method.stages)

    def when(i: Int[Array, ""]) -> Float[Array, ""]:
        if watch is None:
            return times[i]
        return times[jnp.minimum(i, last)] + jnp.where(i > last, watch.apart * (1 + 2 * (stages - i)), 0.0)

    def improved(s: _Stages) -> _Stages:
        slope = field(when(s.i), s.known + s.guess)
        change, size = none, jnp.zeros(())
        gain = jnp.where(s.i < last, pace[s.i], 1.0) * slope
        if solve is not None:
            implicit = (jnp.asarray(method.gamma) > 0.0) & (s.i < last)

            def newton() -> tuple[Columns, Array]:
                change = solve(shift * slope - s.guess)
                return change, jnp.sqrt(jnp.max(jnp.mean((change / allowance) ** 2, axis=0)))

            change, size = lax.cond(implicit, newton, lambda: (change, size))
            gain = jnp.where(implicit, (s.guess + change) * (1.0 / method.gamma), gain)
        solved = ~(size > SOLVED)
        done = solved | (s.tries >= MOST_IMPROVEMENTS)
        hopeless = done & ~solved
        slopes = put(s.slopes, gain, s.i, 0)
        guess, wanted = jnp.where(s.i < last - 1, method.gamma, 0.0) * gain, s.wanted
        if watch is not None:
            guess = jnp.where(s.i < last, guess, jnp.where(s.i == last, watch.apart * slope, -s.guess))
            near = (s.i == last) & watch.near(s.known[:, 0], slope[:, 0])
            wanted = jnp.where(near, stages + 2, wanted)
        return _Stages(
            i=jnp.where(hopeless, stages, s.i + done),
            tries=jnp.where(done, 0, s.tries + 1),
            known=jnp.where(done & (s.i < last), known_of(s.i + 1, slopes), s.known),
            guess=jnp.where(done, guess, s.guess + change),
            slopes=slopes,
            left=jnp.where(hopeless, size / SOLVED, s.left),
            wanted=wanted,
        )

    room = len(method.nodes) + 2 * (watch is not None)
    slopes = jnp.zeros((room, *columns.shape)).at[0].set(pace[0] * rate)
    # a step of length zero is asked for the derivative alone, which is the last stage's
    begin = jnp.where(stride.length > 0.0, 1, last)
    s = _Stages(begin, 0 * begin, known_of(1, slopes), method.gamma * slopes[0], slopes, jnp.zeros(()), stages)
    s = lax.while_loop(lambda s: s.i < s.wanted, improved, s)
    # all slopes but the last are kept times the pace
    errors = method.errors * jnp.where(jnp.arange(len(method.nodes)) == last, pace[last], 1.0)[None]
    error, coarser = (_weighted(errors, k, s.slopes) for k in range(2))
    error = error**2 / jnp.sqrt(error**2 + 0.01 * coarser**2 + 1e-300)
    slope, second = lax.dynamic_index_in_dim(s.slopes, last, keepdims=False), none
    if watch is not None:
        after, before = (lax.dynamic_index_in_dim(s.slopes, stages + k, keepdims=False) for k in range(2))
        second = jnp.where(s.wanted > stages, (after - before) / (2.0 * watch.apart), 0.0)
    return Step(s.known, slope, error + s.left * allowance, jnp.asarray(method.order, float), second)


class Shifted(NamedTuple):
    """(I - shift J) of the stiff part J and q̇ = w, ready to be solved with."""

    part: Linearisation
    shift: Float[Array, ""]
    answer: Float[Array, "rank rank"]
    mobility: Float[Array, "rank rank"]
    inner: Float[Array, "rank rank"]

    @staticmethod
    def of(part: Linearisation, shift: Float[Array, ""]) -> "Shifted":
        """With the one small inverse that it takes."""
        mobility = _product(part.directions.T, part.response)
        answer = part.damping + shift * part.stiffness
        inner = inverse(jnp.eye(len(mobility)) + shift * _product(mobility, answer))
        return Shifted(part, shift, answer, mobility, inner)

    def __call__(self, r: Columns) -> Columns:
        """The solution u of (I - shift J) u = r."""
        part, shift, n = self.part, self.shift, self.part.coordinates
        velocities = len(part.directions)
        r_q, r_w, rest = r[:n], r[n : n + velocities], r[n + velocities :]
        spring = _product(part.stiffness, _product(part.directions[:n].T, r_q))
        z = _product(self.inner, _product(part.directions.T, r_w) - shift * _product(self.mobility, spring))
        w = r_w - shift * _product(part.response, spring + _product(self.answer, z))
        return jnp.concatenate([r_q + shift * w[:n], w, rest])


def _product(a: Array, b: Array) -> Array:
    """A matrix product that stays out of libraries (see `runtime`)."""
    return jnp.sum(a[:, :, None] * b[None], axis=1)


def _weighted(weights: Array | np.ndarray, i: Int[Array, ""] | int, slopes: Array) -> Columns:
    """The sum of all stages' slopes by one row of weights."""
    row = lax.dynamic_index_in_dim(jnp.asarray(weights), i, keepdims=False)
    # written out: one pass over all numbers, in vector instructions (a sum over an axis costs a gradient 12 %)
    total = row[0] * slopes[0]
    for k in range(1, len(row)):
        total = total + row[k] * slopes[k]
    return total


def _only_if(condition: Array, make: Callable[[], T]) -> T:
    """What ``make`` returns, or zeros without the work."""
    shapes = jax.eval_shape(make)
    return lax.cond(condition, make, lambda: jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), shapes))
