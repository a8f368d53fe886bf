"""One step of a Runge-Kutta method on rows, with the coefficients that diffrax ships.

Every stage runs through one loop, so that the right-hand side is compiled once, and the last stage is the derivative
at the step's end, which the event search and the next step need anyway.
"""

from collections.abc import Callable
from typing import NamedTuple

import diffrax
import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Float

from ..mechanisms.hybrid import Linearisation
from .lanes import Rows

Field = Callable[[Float[Array, ""], Rows], Rows]


class Step(NamedTuple):
    """A trial step: state and derivative at its end, and the estimate of its local error."""

    rows: Rows
    rate: Rows
    error: Rows


class Solver(eqx.Module):
    """Base of the steppers."""

    @property
    def order(self) -> int:
        """Order of the local error estimate, which steers the step size."""
        raise NotImplementedError

    def step(
        self,
        field: Field,
        linearise: Callable[[], Linearisation],
        time: Float[Array, ""],
        rows: Rows,
        rate: Rows,
        step: Float[Array, ""],
    ) -> Step:
        """Advance ``rows`` from ``time`` by ``step`` [s]; ``rate`` is the field there."""
        raise NotImplementedError


def _square(tableau: diffrax.ButcherTableau) -> np.ndarray:
    stages = len(tableau.b_sol)
    a = np.zeros((stages, stages))
    for i, row in enumerate(tableau.a_lower):
        a[i + 1, : i + 1] = row
    if tableau.a_diagonal is not None:
        a += np.diag(tableau.a_diagonal)
    return a


class ExplicitRungeKutta(Solver):
    """Any explicit method of diffrax, stepped without its general machinery.

    **Arguments:** ``method``: an instance such as ``diffrax.Tsit5()``.
    """

    method: diffrax.AbstractERK = eqx.field(static=True, default_factory=diffrax.Tsit5)

    @property
    def order(self) -> int:
        return int(self.method.order(None))  # type: ignore[arg-type]

    def step(self, field, linearise, time, rows, rate, step):
        tableau = self.method.tableau
        a, b, error = _square(tableau), np.asarray(tableau.b_sol), np.asarray(tableau.b_error)
        if not np.allclose(a[-1], b):  # not first-same-as-last: the end is one more stage
            a = np.block([[a, np.zeros((len(b), 1))], [b[None], np.zeros((1, 1))]])
            error = np.append(error, 0.0)
        stages = len(a)
        weights, times = jnp.asarray(a), jnp.asarray(a.sum(axis=1))
        slopes = jnp.zeros((stages, *rows.shape)).at[0].set(rate)

        def stage(i, slopes_and_rows):
            slopes, _ = slopes_and_rows
            weight = lax.dynamic_index_in_dim(weights, i, keepdims=False)
            here = rows + step * jnp.sum(weight[:, None, None] * slopes, axis=0)
            slope = field(time + times[i] * step, here)
            return lax.dynamic_update_index_in_dim(slopes, slope, i, 0), here

        slopes, end = lax.fori_loop(1, stages, stage, (slopes, rows))
        return Step(end, slopes[-1], step * jnp.sum(jnp.asarray(error)[:, None, None] * slopes, axis=0))
