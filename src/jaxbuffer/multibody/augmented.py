"""The augmented system ``[M Φ_qᵀ; Φ_q 0] [q̈; λ] = [F; r]`` with M diagonal (M16), solved by its Schur complement.

The multipliers come from ``Φ_q M⁻¹ Φ_qᵀ`` (M17), a few rows written out without the zeros of Φ_q: sums of products
rather than matrix products, since XLA hands even tiny products to a library.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from ..plane import ldl_solve

Pattern = tuple[tuple[tuple[int, int], ...], ...]
"""For each row of Φ_q its entries that can differ from zero: (column, index into the values)."""


class SparseRows(NamedTuple):
    """Φ_q by its entries.

    - ``values``: (entries,) that can differ from zero [-, m].
    - ``pattern``: where they stand, row by row.
    """

    values: Float[Array, " entries"]
    pattern: Pattern

    @staticmethod
    def of(rows: Sequence[Mapping[int, Scalar]]) -> "SparseRows":
        """From the entries of each row by column. ``rows``: those entries; Python's 0 are left out."""
        values: list[Scalar] = []
        pattern = []
        for row in rows:
            kept = {column: entry for column, entry in row.items() if not (isinstance(entry, float) and entry == 0.0)}
            pattern.append(tuple((column, len(values) + k) for k, column in enumerate(kept)))
            values += kept.values()
        return SparseRows(stacked(values) if values else jnp.zeros(0), tuple(pattern))

    def times(self, vector: Float[Array, " coordinates"]) -> list[Scalar]:
        """Φ_q x, row by row. ``vector``: x, (coordinates,)."""
        return [sum(self.values[k] * vector[column] for column, k in row) for row in self.pattern]


def solve_augmented(
    inverse_mass: Float[Array, " coordinates"],
    jacobian: SparseRows,
    force: Float[Array, " coordinates"],
    rhs: Float[Array, " rows"],
) -> tuple[Float[Array, " coordinates"], Float[Array, " rows"]]:
    """Solve the augmented system (M17); derivatives follow from the same system (M18).

    **Arguments:**

    - ``inverse_mass``: (coordinates,) the diagonal of M⁻¹ [1/kg, 1/kg, 1/(kg m²), …].
    - ``jacobian``: Φ_q.
    - ``force``: (coordinates,) F [N, N, N m, …].
    - ``rhs``: (rows,) what Φ_q q̈ must be [m/s², rad/s²].

    **Returns:** accelerations q̈, (coordinates,) [m/s², rad/s²], and multipliers λ, (rows,) [N, N m].
    """
    if not jacobian.pattern:
        return inverse_mass * force, rhs
    return _solve(jacobian.pattern, inverse_mass, jacobian.values, force, rhs)


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def _solve(
    pattern: Pattern, inverse_mass: Array, values: Array, force: Array, rhs: Array
) -> tuple[Float[Array, " coordinates"], Float[Array, " rows"]]:
    jacobian = SparseRows(values, pattern)
    columns = [dict(row) for row in pattern]
    weighted = [{column: values[k] * inverse_mass[column] for column, k in row} for row in pattern]
    schur = [
        [
            sum((weighted[j][c] * values[k] for c, k in columns[i].items() if c in weighted[j]), 0.0)
            for j in range(i + 1)
        ]
        for i in range(len(pattern))
    ]
    unheld = jacobian.times(inverse_mass * force)
    multipliers = ldl_solve(schur, [unheld[i] - rhs[i] for i in range(len(pattern))])
    return inverse_mass * (force - _reaction(jacobian, multipliers, force.shape[0])), multipliers


@_solve.defjvp
def _solve_jvp(pattern: Pattern, primals: tuple, tangents: tuple) -> tuple:
    """The same system answers a small change, with another right-hand side (M18): far cheaper than differentiating the
    factorisation."""
    inverse_mass, values, _, _ = primals
    d_inverse_mass, d_values, d_force, d_rhs = tangents
    acceleration, multipliers = _solve(pattern, *primals)
    moved = SparseRows(d_values, pattern)
    # M q̈ = F - Φ_qᵀ λ is what an inverse mass multiplies.
    d_force = d_force + d_inverse_mass * acceleration / inverse_mass**2
    d_force = d_force - _reaction(moved, multipliers, acceleration.shape[0])
    d_rhs = d_rhs - stacked(moved.times(acceleration))
    return (acceleration, multipliers), _solve(pattern, inverse_mass, values, d_force, d_rhs)


def _reaction(jacobian: SparseRows, multipliers: Array, coordinates: int) -> Float[Array, " coordinates"]:
    """Φ_qᵀ λ."""
    total: list[list[Scalar]] = [[] for _ in range(coordinates)]
    for i, row in enumerate(jacobian.pattern):
        for column, k in row:
            total[column].append(multipliers[i] * jacobian.values[k])
    return stacked([sum(terms) if terms else 0.0 for terms in total])
