"""Small symmetric systems solved without LAPACK: a library call inside a loop would split XLA's single kernel."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._types import Scalar
from ..basis import is_zero, less, times
from ..duplication import evaluated_once


class Factors(NamedTuple):
    """A symmetric matrix as L D Lᵀ: rows of L below its diagonal of ones, and the diagonal of D.

    That diagonal may have either sign: a flexible body's mass alone may be indefinite, where joints hold it. What is
    Python's 0 costs nothing: order rows so that few entries fill in. XLA evaluates cheap operations anew wherever their
    result is used, and so whole chains of them, but never a division: what is used many times here is the
    result of one.
    """

    lower: list[list[Scalar]]
    pivot: list[Scalar]

    @staticmethod
    def of(matrix: Float[Array, "m m"] | Sequence[Sequence[Scalar]]) -> "Factors":
        """Factorise a symmetric matrix. ``matrix``: (m, m), of which only the lower half is read."""
        lower: list[list[Scalar]] = []
        pivot: list[Scalar] = []
        for i in range(len(matrix)):
            lower.append([])
            for j in range(i):
                weighted = map(times, lower[j], pivot)
                lower[i].append(_divided(_less_products(matrix[i][j], lower[i], weighted), pivot[j]))
            pivot.append(evaluated_once(_less_products(matrix[i][i], lower[i], map(times, lower[i], pivot))))
        return Factors(lower, pivot)

    def forward(self, rhs: Sequence[Scalar] | Float[Array, "m *columns"]) -> list[Any]:
        """Return L⁻¹ times a right-hand side of m entries, each a number or a row of columns."""
        x, divided = list[Any](), list[Any]()
        for entry, row, pivot in zip(rhs, self.lower, self.pivot, strict=True):
            x.append(_less_products(entry, map(times, row, self.pivot), divided))
            divided.append(_divided(x[-1], pivot))
        return x

    def solve(self, rhs: Sequence[Scalar] | Float[Array, "m *columns"]) -> list[Any]:
        """Return the solution for a right-hand side of m entries, each a number or a row of columns."""
        x = self.forward(rhs)
        for i in reversed(range(len(x))):
            column = [times(row[i], self.pivot[i]) for row in self.lower[i + 1 :]]
            x[i] = _divided(_less_products(x[i], column, x[i + 1 :]), self.pivot[i])
        return x


def _less_products(entry: Any, factors: Iterable[Any], others: Iterable[Any]) -> Any:
    """Return a number less the sum of products of ``factors`` and ``others``, as far as both go."""
    for a, b in zip(factors, others, strict=False):
        entry = less(entry, times(a, b))
    return entry


def _divided(entry: Any, divisor: Scalar) -> Any:
    return entry if is_zero(entry) else entry / divisor


def ldl_solve(
    matrix: Float[Array, "m m"] | Sequence[Sequence[Scalar]], rhs: Float[Array, "m *columns"] | Sequence[Scalar]
) -> Float[Array, "m *columns"]:
    """Solve a symmetric system by its `Factors`, written out for the few rows that a mechanism has.

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
