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
from ..multibody import inverse
from .lanes import Rows

Field = Callable[[Float[Array, ""], Rows], Rows]


class Stiff(NamedTuple):
    """What a solver may ask about stiffness at a step's start: see `HybridSystem`."""

    linearisation: Callable[[], Linearisation]
    rate: Callable[[], Float[Array, ""]]


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
        stiff: Stiff,
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

    def step(self, field, stiff, time, rows, rate, step):
        tableau = self.method.tableau
        assert isinstance(tableau, diffrax.ButcherTableau)
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


class LinearlyImplicit(Solver):
    """An IMEX Runge-Kutta method of diffrax turned into a W-method: one matrix a step, no iteration.

    With J frozen over the step, f = J (y - y_n) + (f - J (y - y_n)); the method's implicit half takes the first term
    and its explicit half the second, so every stage is one linear solve and one right-hand side. The order is the IMEX
    method's for *any* J (Kennedy & Carpenter 2003), hence J needs only the stiff forces, and the sensitivity rows share
    it. With those forces of low rank the solve is a small dense one (Woodbury), and never a library call.

    **Arguments:** ``method``: ``diffrax.KenCarp3()``, ``KenCarp4()`` or ``KenCarp5()``.
    """

    method: diffrax.AbstractSolver = eqx.field(static=True, default_factory=diffrax.KenCarp5)

    @property
    def order(self) -> int:
        return int(self.method.order(None))  # type: ignore[arg-type]

    def step(self, field, stiff, time, rows, rate, step):
        explicit, implicit = self.method.tableau.tableaus  # type: ignore[attr-defined]
        a_explicit, a_implicit = _square(explicit), _square(implicit)
        b, error = np.asarray(implicit.b_sol), np.asarray(implicit.b_error)
        gamma, stages = a_implicit[1, 1], len(b)
        times = np.append(a_implicit.sum(axis=1), 1.0)
        lower = a_implicit - np.diag(np.diag(a_implicit))
        # One stage more, with the weights of the solution, finds the derivative at the step's end.
        pad = lambda matrix: np.block([[matrix, np.zeros((stages, 1))], [b[None], np.zeros((1, 1))]])  # noqa: E731
        weights = jnp.asarray(np.stack([pad(a_explicit), pad(lower)], axis=1))
        solve = _shifted_solve(stiff.linearisation(), step * gamma)
        # parts[0]: f - J (y - y_n), parts[1]: J (y - y_n), at each stage
        parts = jnp.zeros((2, stages + 1, *rows.shape)).at[0, 0].set(rate)

        def stage(i, carry):
            parts, _, _ = carry
            weight = lax.dynamic_index_in_dim(weights, i, keepdims=False)
            known = step * jnp.sum(weight[:, :, None, None] * parts, axis=(0, 1))
            moved = jnp.where(i == stages, known, solve(known))
            stiff = (moved - known) / jnp.where(step == 0.0, 1.0, step * gamma)
            here = rows + moved
            slope = field(time + jnp.asarray(times)[i] * step, here)
            new = jnp.stack([slope - stiff, stiff])[:, None]
            return lax.dynamic_update_slice_in_dim(parts, new, i, 1), here, slope

        parts, end, slope = lax.fori_loop(1, stages + 1, stage, (parts, rows, rate))
        slopes = jnp.sum(parts, axis=0)[:stages]
        return Step(end, slope, step * jnp.sum(jnp.asarray(error)[:, None, None] * slopes, axis=0))


class Automatic(Solver):
    """Explicit where the step is short against the stiffest motion, linearly implicit where it is not.

    **Arguments:** ``explicit``, ``implicit``: two solvers of one order; ``bound``: the largest product of step and
    fastest rate that is stepped explicitly.
    """

    explicit: ExplicitRungeKutta = ExplicitRungeKutta()
    implicit: LinearlyImplicit = LinearlyImplicit()
    bound: float = 4.0

    @property
    def order(self) -> int:
        return self.explicit.order

    def step(self, field, stiff, time, rows, rate, step):
        take = lambda solver: lambda: solver.step(field, stiff, time, rows, rate, step)  # noqa: E731
        return lax.cond(step * stiff.rate() <= self.bound, take(self.explicit), take(self.implicit))


def _shifted_solve(part: Linearisation, shift: Float[Array, ""]) -> Callable[[Rows], Rows]:
    """Solve (I - shift J) u = r for rows, J being the low-rank linearisation and q̇ = w."""
    n, velocities = part.coordinates, part.directions.shape[0]
    directions, response = part.directions, part.response
    rank = directions.shape[1]
    mobility = jnp.sum(directions[:, :, None] * response[:, None, :], axis=0)
    answer = part.damping + shift * part.stiffness

    def product(a: Array, b: Array) -> Array:
        return jnp.sum(a[:, :, None] * b[None], axis=1)

    inner = inverse(jnp.eye(rank) + shift * product(mobility, answer))

    def solve(r: Rows) -> Rows:
        r_q, r_w, rest = r[:, :n], r[:, n : n + velocities], r[:, n + velocities :]
        spring = product(product(r_q, directions[:n]), part.stiffness.T)
        z = product(product(r_w, directions) - shift * product(spring, mobility), inner.T)
        w = r_w - shift * product(spring + product(z, answer.T), response.T)
        return jnp.concatenate([r_q + shift * w[:, :n], w, rest], axis=1)

    return solve
