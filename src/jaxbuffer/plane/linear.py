"""Small symmetric systems solved without LAPACK: a library call inside a loop would split XLA's single kernel."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from ..basis import is_zero


class Factors(NamedTuple):
    """A symmetric positive definite matrix as L D Lᵀ: rows of L below its diagonal of ones, and the diagonal of D.

    What is Python's 0 costs nothing: order rows so that few entries fill in.
    """

    lower: list[list[Scalar]]
    pivot: list[Scalar]

    @staticmethod
    def of(matrix: Float[Array, "m m"] | Sequence[Sequence[Scalar]]) -> "Factors":
        """Factorise a symmetric positive definite matrix. ``matrix``: (m, m), of which only the lower half is read."""
        lower: list[list[Scalar]] = []
        pivot: list[Scalar] = []
        for i in range(len(matrix)):
            lower.append([])
            for j in range(i):
                entry = matrix[i][j]
                for k in range(j):
                    if not (is_zero(lower[i][k]) or is_zero(lower[j][k])):
                        entry = entry - lower[i][k] * lower[j][k] * pivot[k]
                lower[i].append(entry if is_zero(entry) else entry / pivot[j])
            diagonal = matrix[i][i]
            for k in range(i):
                if not is_zero(lower[i][k]):
                    diagonal = diagonal - lower[i][k] * lower[i][k] * pivot[k]
            pivot.append(diagonal)
        return Factors(lower, pivot)

    def forward(self, rhs: Sequence[Scalar] | Float[Array, "m *columns"]) -> list[Any]:
        """Return L⁻¹ times a right-hand side of m entries, each a number or a row of columns."""
        x = list(rhs)
        for i in range(len(x)):
            for k in range(i):
                if not (is_zero(self.lower[i][k]) or is_zero(x[k])):
                    x[i] = x[i] - self.lower[i][k] * x[k]
        return x

    def solve(self, rhs: Sequence[Scalar] | Float[Array, "m *columns"]) -> list[Any]:
        """Return the solution for a right-hand side of m entries, each a number or a row of columns."""
        n = len(self.pivot)
        x = self.forward(rhs)
        x = [entry if is_zero(entry) else entry / self.pivot[i] for i, entry in enumerate(x)]
        for i in reversed(range(n)):
            for k in range(i + 1, n):
                if not (is_zero(self.lower[k][i]) or is_zero(x[k])):
                    x[i] = x[i] - self.lower[k][i] * x[k]
        return x


def evaluated_once(values: Sequence[Scalar], number: Scalar | None = None) -> list[Scalar]:
    """Return the same numbers, each of which a compiled program computes once; Python's numbers stay as they are.

    XLA evaluates cheap operations anew wherever they are used, but never a division. ``number``: any finite one that
    the program computes, from which the divisor is made (default: from each value itself); of values that are to stay
    linear in something, one that does not depend on it.
    """
    places = [k for k, value in enumerate(values) if not isinstance(value, float)]
    array = stacked([values[k] for k in places])
    array = array / (1.0 + 0.0 * (array if number is None else number))
    traced = {place: array[k] for k, place in enumerate(places)}
    return [traced.get(k, value) for k, value in enumerate(values)]


def ldl_solve(
    matrix: Float[Array, "m m"] | Sequence[Sequence[Scalar]], rhs: Float[Array, "m *columns"] | Sequence[Scalar]
) -> Float[Array, "m *columns"]:
    """Solve a symmetric positive definite system by LDLᵀ, written out for the few rows that a mechanism has.

    **Arguments:** ``matrix``: (m, m), of which only the lower half is read; ``rhs``: (m,) or (m, columns).
    **Returns:** the solution, the shape of ``rhs``.
    """
    return jnp.stack(Factors.of(matrix).solve(rhs))


def inverse(matrix: Float[Array, "m m"]) -> Float[Array, "m m"]:
    """Return the inverse of a small ``matrix`` (m, m) near the identity, by Gauss-Jordan elimination without
    pivoting."""
    n = matrix.shape[0]
    index = np.arange(n)
    work = jnp.concatenate([matrix, jnp.eye(n)], axis=1)
    for k in range(n):
        # Near the identity no pivot comes near zero, so rows need not be exchanged.
        row = work[k] / work[k, k]
        column = jnp.where(index == k, 0.0, work[:, k])
        # Masks rather than updates by index: a scatter would split the loop's kernel.
        work = jnp.where((index == k)[:, None], row[None], work - column[:, None] * row[None])
    return work[:, n:]
