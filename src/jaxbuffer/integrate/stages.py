"""One step of a Runge-Kutta method on columns: every stage runs through one loop, so that the right-hand side, the dear
part, is compiled once."""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Float, Int

from ..mechanisms.hybrid import Linearisation
from ..multibody import inverse
from .lanes import Columns, Rows
from .methods import Method
from .stride import Stride

Field = Callable[[Float[Array, ""], Columns], Columns]
T = TypeVar("T")
put = lax.dynamic_update_index_in_dim


class Step(NamedTuple):
    """A trial step: state and derivative at its end, the estimate of its local error and that estimate's order; in
    columns as a method returns it, in rows for the loop."""

    end: Rows | Columns
    rate: Rows | Columns
    error: Rows | Columns
    order: Float[Array, ""]


def take(
    method: Method,
    field: Field,
    linearisation: Callable[[], Linearisation] | None,
    time: Float[Array, ""],
    columns: Columns,
    rate: Columns,
    stride: Stride,
) -> Step:
    """Advance columns from ``time`` by a stride; ``rate`` is the field there. ``linearisation``: the stiff part's, None
    for explicit methods alone.

    With J frozen over the step, f = J (y - y_n) + (f - J (y - y_n)); the method's implicit half takes the first term
    and its explicit half the second, so every stage is one linear solve and one right-hand side. The order is the
    method's for *any* J (Kennedy & Carpenter 2003), hence J needs only the stiff forces, and sensitivities share it.
    With those forces of low rank the solve is a small dense one (Woodbury), and never a library call.
    """
    pace, times = stride.pace(method.nodes), time + stride.passed(method.nodes)
    implicit = jnp.asarray(method.gamma) > 0.0
    # rest: f - J (y - y_n), linear: J (y - y_n), at each stage, times the step
    rest = jnp.zeros((len(method.nodes), *columns.shape)).at[0].set(pace[0] * rate)
    linear = solve = None
    if linearisation is not None:
        linear = jnp.zeros_like(rest)
        solve = _only_if(implicit, lambda: Shifted.of(linearisation(), method.gamma * stride.length))

    def stage(i: Int[Array, ""], carry: tuple) -> tuple:
        rest, linear, _, _ = carry
        row = method.first + i
        moved, stiff = _weighted(method.explicit, row, rest), jnp.zeros(())
        if solve is not None:

            def solved() -> tuple[Columns, Columns]:
                known = moved + _weighted(method.implicit, row, linear)
                solution = jnp.where(i == method.stages - 1, known, solve(known))
                return solution, (solution - known) / method.gamma

            moved, stiff = lax.cond(implicit, solved, lambda: (moved, jnp.zeros_like(moved)))
            linear = put(linear, stiff, i, 0)
        here = columns + moved
        slope = field(times[i], here)
        return put(rest, pace[i] * slope - stiff, i, 0), linear, here, slope

    rest, linear, end, slope = lax.fori_loop(1, method.stages, stage, (rest, linear, columns, rate))
    slopes = rest if linear is None else rest + linear
    error, coarser = (_weighted(method.errors, k, slopes) for k in range(2))
    error = error**2 / jnp.sqrt(error**2 + 0.01 * coarser**2 + 1e-300)
    return Step(end, slope, error, jnp.asarray(method.order, float))


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
    # flat, so that a vector instruction takes several numbers of a state that stands alone
    return jnp.sum(row[:, None] * slopes.reshape(len(slopes), -1), axis=0).reshape(slopes.shape[1:])


def _only_if(condition: Array, make: Callable[[], T]) -> T:
    """What ``make`` returns, or zeros without the work."""
    shapes = jax.eval_shape(make)
    return lax.cond(condition, make, lambda: jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), shapes))
