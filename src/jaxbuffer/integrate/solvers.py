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

from ..mechanisms.hybrid import Linearisation, Rates
from ..multibody import inverse
from .dop853 import DOP853
from .lanes import Rows

Field = Callable[[Float[Array, ""], Rows], Rows]


class Stiff(NamedTuple):
    """What a solver may ask about stiffness at a step's start: see `HybridSystem`."""

    linearisation: Callable[[], Linearisation]
    rates: Callable[[], Rates]


class Stride(NamedTuple):
    """A step's length [s] and how time passes in it: start·x + growth·x²/2 at the fraction x of the way.

    Just after a touchdown and just before a release the force goes with the 3/2 power of time, and its sensitivity with
    the square root: in the square root of the time from the event both are smooth, and a method keeps its order.
    """

    start: Float[Array, ""]
    growth: Float[Array, ""]

    @staticmethod
    def after(elapsed: Float[Array, ""], length: Float[Array, ""]) -> "Stride":
        """A step that starts ``elapsed`` [s] after a touchdown: even in the root of the time from there."""
        before, after = jnp.sqrt(elapsed), jnp.sqrt(elapsed + length)
        root = length / jnp.maximum(before + after, 1e-150)
        return Stride(2.0 * before * root, 2.0 * root * root)

    @staticmethod
    def onto(length: Float[Array, ""]) -> "Stride":
        """A step that ends on a release."""
        return Stride(2.0 * length, -2.0 * length)

    @property
    def length(self) -> Float[Array, ""]:
        """The whole step [s]."""
        return self.start + 0.5 * self.growth

    def pace(self, x: np.ndarray) -> Float[Array, " nodes"]:
        """Time per fraction of the way [s]."""
        return self.start + self.growth * x

    def passed(self, x: np.ndarray) -> Float[Array, " nodes"]:
        """Time since the step's start [s]."""
        return (self.start + 0.5 * self.growth * x) * x


class Step(NamedTuple):
    """A trial step: state and derivative at its end, the estimate of its local error and that estimate's order."""

    rows: Rows
    rate: Rows
    error: Rows
    order: Float[Array, ""]


class Solver(eqx.Module):
    """Base of the steppers."""

    def allowed(self, stiff: Stiff, step: Float[Array, ""]) -> Float[Array, ""]:
        """The length [s] to try where accuracy would allow ``step``."""
        return step

    def step(
        self,
        field: Field,
        stiff: Stiff,
        time: Float[Array, ""],
        rows: Rows,
        rate: Rows,
        step: Stride,
    ) -> Step:
        """Advance ``rows`` from ``time`` by ``step``; ``rate`` is the field there."""
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

    **Arguments:** ``method``: an instance such as ``DOP853()`` or ``diffrax.Tsit5()``.
    """

    method: diffrax.AbstractERK = eqx.field(static=True, default_factory=DOP853)

    @property
    def order(self) -> int:
        return int(self.method.order(None))  # type: ignore[arg-type]

    def step(self, field, stiff, time, rows, rate, step):
        tableau = self.method.tableau
        assert isinstance(tableau, diffrax.ButcherTableau)
        a, b = _square(tableau), np.asarray(tableau.b_sol)
        errors = np.stack([getattr(self.method, "second_error", tableau.b_error), tableau.b_error])
        if not np.allclose(a[-1], b):  # not first-same-as-last: the end is one more stage
            a = np.block([[a, np.zeros((len(b), 1))], [b[None], np.zeros((1, 1))]])
            errors = np.pad(errors, ((0, 0), (0, 1)))
        stages = len(a)
        nodes = a.sum(axis=1)
        pace, times = step.pace(nodes), time + step.passed(nodes)
        weights = jnp.asarray(a) * pace[None]
        slopes = jnp.zeros((stages, *rows.shape)).at[0].set(rate)

        def stage(i, slopes_and_rows):
            slopes, _ = slopes_and_rows
            weight = lax.dynamic_index_in_dim(weights, i, keepdims=False)
            here = rows + jnp.sum(weight[:, None, None] * slopes, axis=0)
            slope = field(times[i], here)
            return lax.dynamic_update_index_in_dim(slopes, slope, i, 0), here

        slopes, end = lax.fori_loop(1, stages, stage, (slopes, rows))
        error = jnp.sum((errors[-1] * pace)[:, None, None] * slopes, axis=0)
        if hasattr(self.method, "second_error"):
            second = jnp.sum((errors[0] * pace)[:, None, None] * slopes, axis=0)
            error = error**2 / jnp.sqrt(error**2 + 0.01 * second**2 + 1e-300)
        return Step(end, slopes[-1], error, jnp.asarray(float(self.order)))


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
        pace, times = step.pace(times), time + step.passed(times)
        shift = gamma * step.length
        solve = _shifted_solve(stiff.linearisation(), shift)
        # parts[0]: f - J (y - y_n), parts[1]: J (y - y_n), at each stage, times the step
        parts = jnp.zeros((2, stages + 1, *rows.shape)).at[0, 0].set(pace[0] * rate)

        def stage(i, carry):
            parts, _, _ = carry
            weight = lax.dynamic_index_in_dim(weights, i, keepdims=False)
            known = jnp.sum(weight[:, :, None, None] * parts, axis=(0, 1))
            moved = jnp.where(i == stages, known, solve(known))
            stiff = (moved - known) / gamma
            here = rows + moved
            slope = field(times[i], here)
            new = jnp.stack([pace[i] * slope - stiff, stiff])[:, None]
            return lax.dynamic_update_slice_in_dim(parts, new, i, 1), here, slope

        parts, end, slope = lax.fori_loop(1, stages + 1, stage, (parts, rows, rate))
        slopes = jnp.sum(parts, axis=0)[:stages]
        error_now = jnp.sum(jnp.asarray(error)[:, None, None] * slopes, axis=0)
        return Step(end, slope, error_now, jnp.asarray(float(self.order)))


class Automatic(Solver):
    """Explicit where steps are short against the fastest motion, linearly implicit where they want to be longer.

    Ringing is followed far more exactly by the explicit method, so an implicit step must gain more there; the rate of
    ringing is overrated, that of decay is not, hence their bounds lie above and below the explicit method's stability.

    **Arguments:** ``explicit``, ``implicit``: the two solvers; ``ringing``, ``decay``: the largest product of step and
    rate that is stepped explicitly, and how many such steps an implicit one must replace to be preferred.
    """

    explicit: ExplicitRungeKutta = ExplicitRungeKutta()
    implicit: LinearlyImplicit = LinearlyImplicit()
    ringing: tuple[float, float] = (8.0, 4.0)
    decay: tuple[float, float] = (5.0, 1.5)

    def _limits(self, stiff: Stiff) -> tuple[Float[Array, ""], Float[Array, ""]]:
        rates = stiff.rates()
        by_ringing = self.ringing[0] / jnp.maximum(rates.ringing, 1e-150)
        by_decay = self.decay[0] / jnp.maximum(rates.decay, 1e-150)
        limit = jnp.minimum(by_ringing, by_decay)
        return limit, limit * jnp.where(by_decay < by_ringing, self.decay[1], self.ringing[1])

    def allowed(self, stiff, step):
        limit, worth = self._limits(stiff)
        return jnp.where(step > worth, step, jnp.minimum(step, limit))

    def step(self, field, stiff, time, rows, rate, step):
        take = lambda solver: lambda: solver.step(field, stiff, time, rows, rate, step)  # noqa: E731
        within = step.length <= self._limits(stiff)[0] * (1.0 + 1e-9)
        return lax.cond(within, take(self.explicit), take(self.implicit))


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
