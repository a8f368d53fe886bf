"""Small symmetric systems solved without LAPACK: a library call inside a loop would split XLA's single kernel."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._types import Scalar
from ..basis import is_zero, less, times


class Cholesky(NamedTuple):
    """A symmetric positive definite matrix as L Lᵀ: rows of L below its diagonal, and that diagonal.

    What is Python's 0 costs nothing: order rows so that few entries fill in. XLA evaluates cheap operations anew
    wherever their result is used, and so whole chains of them, but never a division or a root: with these factors every
    number that is used again is the result of one.
    """

    lower: list[list[Scalar]]
    diagonal: list[Scalar]

    @staticmethod
    def of(matrix: Float[Array, "m m"] | Sequence[Sequence[Scalar]]) -> "Cholesky":
        """Factorise a symmetric positive definite matrix. ``matrix``: (m, m), of which only the lower half is read."""
        lower: list[list[Scalar]] = []
        diagonal: list[Scalar] = []
        for i in range(len(matrix)):
            lower.append([])
            for j in range(i):
                lower[i].append(_divided(_less_products(matrix[i][j], lower[i][:j], lower[j]), diagonal[j]))
            diagonal.append(jnp.sqrt(_less_products(matrix[i][i], lower[i], lower[i])))
        return Cholesky(lower, diagonal)

    def forward(self, rhs: Sequence[Scalar] | Float[Array, "m *columns"]) -> list[Any]:
        """Return L⁻¹ times a right-hand side of m entries, each a number or a row of columns."""
        x: list[Any] = []
        for entry, row, diagonal in zip(rhs, self.lower, self.diagonal, strict=True):
            x.append(_divided(_less_products(entry, row, x), diagonal))
        return x

    def solve(self, rhs: Sequence[Scalar] | Float[Array, "m *columns"]) -> list[Any]:
        """Return the solution for a right-hand side of m entries, each a number or a row of columns."""
        x = self.forward(rhs)
        for i in reversed(range(len(x))):
            column = [row[i] for row in self.lower[i + 1 :]]
            x[i] = _divided(_less_products(x[i], column, x[i + 1 :]), self.diagonal[i])
        return x


def _less_products(entry: Any, factors: Sequence[Any], others: Sequence[Any]) -> Any:
    """Return a number less the sum of products of ``factors`` and ``others``."""
    for a, b in zip(factors, others, strict=True):
        entry = less(entry, times(a, b))
    return entry


def _divided(entry: Any, divisor: Scalar) -> Any:
    return entry if is_zero(entry) else entry / divisor


def cholesky_solve(
    matrix: Float[Array, "m m"] | Sequence[Sequence[Scalar]], rhs: Float[Array, "m *columns"] | Sequence[Scalar]
) -> Float[Array, "m *columns"]:
    """Solve a symmetric positive definite system by Cholesky's factors, written out for the few rows that a
    mechanism has.

    **Arguments:** ``matrix``: (m, m), of which only the lower half is read; ``rhs``: (m,) or (m, columns).
    **Returns:** the solution, the shape of ``rhs``.
    """
    return jnp.stack(Cholesky.of(matrix).solve(rhs))


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
