"""Small symmetric systems solved without LAPACK: a library call inside a loop would split XLA's single kernel."""

from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._types import Scalar


def ldl_solve(
    matrix: Float[Array, "m m"] | Sequence[Sequence[Scalar]], rhs: Float[Array, "m *columns"] | Sequence[Scalar]
) -> Float[Array, "m *columns"]:
    """Solve a symmetric positive definite system by LDLᵀ, written out for the few rows that a mechanism has.

    **Arguments:** ``matrix``: (m, m), of which only the lower half is read; ``rhs``: (m,) or (m, columns).
    **Returns:** the solution, the shape of ``rhs``.
    """
    n = len(rhs)
    lower: list[list[Scalar]] = [[] for _ in range(n)]
    pivot: list[Scalar] = []
    for i in range(n):
        for j in range(i):
            entry = matrix[i][j]
            for k in range(j):
                entry = entry - lower[i][k] * lower[j][k] * pivot[k]
            lower[i].append(entry / pivot[j])
        diagonal = matrix[i][i]
        for k in range(i):
            diagonal = diagonal - lower[i][k] * lower[i][k] * pivot[k]
        pivot.append(diagonal)
    x = [rhs[i] for i in range(n)]
    for i in range(n):
        for k in range(i):
            x[i] = x[i] - lower[i][k] * x[k]
    x = [x[i] / pivot[i] for i in range(n)]
    for i in reversed(range(n)):
        for k in range(i + 1, n):
            x[i] = x[i] - lower[k][i] * x[k]
    return jnp.stack(x)


def inverse(matrix: Float[Array, "m m"]) -> Float[Array, "m m"]:
    """The inverse of a small ``matrix`` (m, m) near the identity, by Gauss-Jordan elimination without pivoting."""
    n = matrix.shape[0]
    index = np.arange(n)
    work = jnp.concatenate([matrix, jnp.eye(n)], axis=1)
    for k in range(n):
        row = work[k] / work[k, k]
        column = jnp.where(index == k, 0.0, work[:, k])
        work = jnp.where((index == k)[:, None], row[None], work - column[:, None] * row[None])
    return work[:, n:]
