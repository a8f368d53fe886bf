"""Runge-Kutta methods as numbers, from the coefficients that diffrax ships."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import diffrax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int


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


def explicit(method: diffrax.AbstractERK) -> Method:
    """Read an explicit method of diffrax, such as ``DOP853()`` or ``diffrax.Tsit5()``."""
    tableau = method.tableau
    assert isinstance(tableau, diffrax.ButcherTableau)
    weights, last = _square(tableau), np.asarray(tableau.b_sol)
    errors = np.stack([tableau.b_error, getattr(method, "second_error", np.zeros(len(last)))])
    if not np.allclose(weights[-1], last):  # the end is one more stage
        weights, errors = _with_end(weights, last), np.pad(errors, ((0, 0), (0, 1)))
    order = float(method.order(None))  # type: ignore[arg-type]
    return Method(weights, weights.sum(axis=1), errors, 0.0, order, len(weights))


def diagonally_implicit(method: diffrax.AbstractSolver) -> Method:
    """Read a singly diagonally implicit method of diffrax with an explicit first stage, such as ``diffrax.Kvaerno5()``;
    of an implicit-explicit one, such as ``diffrax.KenCarp5()``, the implicit half."""
    tableau = method.tableau  # type: ignore[attr-defined]
    # diffrax lists the explicit half first.
    tableau = getattr(tableau, "tableaus", [tableau])[-1]
    square = _square(tableau)
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


def _square(tableau: diffrax.ButcherTableau) -> np.ndarray:
    stages = len(tableau.b_sol)
    weights = np.zeros((stages, stages))
    for i, row in enumerate(tableau.a_lower):
        weights[i + 1, : i + 1] = row
    if tableau.a_diagonal is not None:
        weights += np.diag(tableau.a_diagonal)
    return weights


def _with_end(weights: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Append a stage with the weights of the solution."""
    return np.block([[weights, np.zeros((len(last), 1))], [last[None], np.zeros((1, 1))]])
