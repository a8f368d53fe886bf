"""Runge-Kutta methods as numbers, from the coefficients that diffrax ships."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..._types import AbstractERK, AbstractSolver


class Method(NamedTuple):
    """A method of n stages, the last one at the step's end: its slope is the derivative there, which the event search
    and the next step need anyway.

    ``weights`` of the earlier stages, and ``gamma`` of a stage itself (all but the first and the last; zero in an
    explicit method). ``nodes``: times as fractions of the step. ``errors``: weights of the estimate of the local error
    and of a coarser one that steadies it (Hairer's DOP853; zeros for none). ``order`` of the estimate; ``stages`` in
    use, where zeros follow; ``first`` row of the weights, where those of several methods stand below each other.
    """

    weights: Float[np.ndarray, "rows n"]
    nodes: Float[np.ndarray, " n"] | Float[Array, " n"]
    errors: Float[np.ndarray, "2 n"] | Float[Array, "2 n"]
    gamma: float | Float[Array, ""]
    order: float | Float[Array, ""]
    stages: int | Int[Array, ""]
    first: int | Int[Array, ""] = 0


def explicit(method: AbstractERK) -> Method:
    """Read an explicit method of diffrax, such as ``diffrax.Tsit5()``."""
    tableau: Any = method.tableau  # type: ignore[attr-defined]
    order = float(method.order(None))  # type: ignore[arg-type]
    return explicit_of_rows(tableau.a_lower, tableau.b_sol, [tableau.b_error, 0.0 * tableau.b_error], order)


def explicit_of_rows(
    lower: Sequence[Sequence[float]], solution: Sequence[float], errors: Sequence[Sequence[float]], order: float
) -> Method:
    """Return an explicit method by the rows of its Butcher tableau, the first stage's left out, the weights of its
    ``solution`` and of its two ``errors``, and the ``order`` of their estimate."""
    weights, last, errors_of_stages = _square(lower, len(solution)), np.asarray(solution), np.stack(errors)
    if not np.allclose(weights[-1], last):  # the end is one more stage
        weights, errors_of_stages = _with_end(weights, last), np.pad(errors_of_stages, ((0, 0), (0, 1)))
    return Method(weights, weights.sum(axis=1), errors_of_stages, 0.0, order, len(weights))


def diagonally_implicit(method: AbstractSolver) -> Method:
    """Read a singly diagonally implicit method of diffrax with an explicit first stage, such as ``diffrax.Kvaerno5()``;
    of an implicit-explicit one, such as ``diffrax.KenCarp5()``, the implicit half."""
    tableau: Any = method.tableau  # type: ignore[attr-defined]
    # diffrax lists the explicit half first.
    tableau = getattr(tableau, "tableaus", [tableau])[-1]
    square = _square(tableau.a_lower, len(tableau.b_sol)) + np.diag(tableau.a_diagonal)
    nodes, gamma = np.append(square.sum(axis=1), 1.0), float(square[1, 1])
    weights, error = _with_end(np.tril(square, -1), np.asarray(tableau.b_sol)), np.append(tableau.b_error, 0.0)
    order = float(method.order(None))  # type: ignore[arg-type]
    return Method(weights, nodes, np.stack([error, 0.0 * error]), gamma, order, len(nodes))


def one_of(methods: Sequence[Method], which: Int[Array, ""]) -> Method:
    """Pick a method at run time."""
    longest = max(len(method.nodes) for method in methods)

    def filled(values: Array | np.ndarray) -> np.ndarray:
        """Fill up the axes that are as long as the stages."""
        n = values.shape[-1]
        return np.pad(values, [(0, longest - n if size == n else 0) for size in values.shape])

    def chosen(values: Sequence[Any]) -> Array:
        return jnp.asarray(np.stack([filled(v) if np.ndim(v) else v for v in values]))[which]

    weights, nodes, errors, gamma, order, stages, _ = zip(*methods, strict=True)
    # Picking the weights row by row, when they are wanted, costs less than picking all of them.
    below = np.concatenate([filled(values) for values in weights])
    others = (chosen(values) for values in (nodes, errors, gamma, order, stages))
    return Method(below, *others, longest * which)  # type: ignore[call-arg, arg-type]


def _square(lower: Sequence[Sequence[float]], stages: int) -> np.ndarray:
    """Return the weights of earlier stages as a square, from the rows of all stages but the first."""
    weights = np.zeros((stages, stages))
    for i, row in enumerate(lower):
        weights[i + 1, : i + 1] = row
    return weights


def _with_end(weights: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Append a stage with the weights of the solution."""
    return np.block([[weights, np.zeros((len(last), 1))], [last[None], np.zeros((1, 1))]])
