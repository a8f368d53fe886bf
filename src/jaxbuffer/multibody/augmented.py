"""The augmented system ``[M Φ_qᵀ; Φ_q 0] [q̈; λ] = [F; r]`` (M16), solved by its Schur complement.

M is diagonal, but for a block for each flexible body. The multipliers come from ``Φ_q M⁻¹ Φ_qᵀ`` (M17), a few rows
written out without the zeros of Φ_q: sums of products rather than matrix products, since XLA hands even tiny products
to a library.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from ..plane import Factors, ldl_solve

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
        """Collect the entries of each row by column. ``rows``: those entries; Python's 0 are left out."""
        values: list[Scalar] = []
        pattern = []
        for row in rows:
            # Python's 0 stands for what is zero in every design: it is left out of all sums. A traced zero stays.
            nonzero = {
                column: entry for column, entry in row.items() if not (isinstance(entry, float) and entry == 0.0)
            }
            pattern.append(tuple((column, len(values) + k) for k, column in enumerate(nonzero)))
            values += nonzero.values()
        return SparseRows(stacked(values) if values else jnp.zeros(0), tuple(pattern))

    def times(self, vector: Float[Array, " coordinates"]) -> list[Scalar]:
        """Return Φ_q x, row by row. ``vector``: x, (coordinates,)."""
        return [sum(self.values[k] * vector[column] for column, k in row) for row in self.pattern]


Layout = tuple[tuple[tuple[int, ...], tuple[tuple[int, ...], ...]], ...]
"""For each block of M its columns, and its lower half row by row: an index into the values, -1 for a zero."""


class MassMatrix(NamedTuple):
    """M.

    - ``inverse``: (coordinates,) its diagonal's reciprocals [1/kg, 1/kg, 1/(kg m²), …]; unused in columns of blocks.
    - ``values``: (entries,) of the blocks [kg, kg m, kg m²].
    - ``layout``: where they stand.
    """

    inverse: Float[Array, " coordinates"]
    values: Float[Array, " entries"]
    layout: Layout = ()

    @staticmethod
    def of(
        inverse: Float[Array, " coordinates"],
        blocks: Sequence[tuple[tuple[int, ...], Sequence[Sequence[Scalar]]]],
    ) -> "MassMatrix":
        """Collect the diagonal's reciprocals, and each block's columns and lower half; Python's 0 are left out."""
        values: list[Scalar] = []
        # Where entries stand is known when compiling; only their values are arrays of the program.
        layout = []
        for columns, rows in blocks:
            indices = []
            for row in rows:
                nonzero = [not (isinstance(entry, float) and entry == 0.0) for entry in row]
                indices.append(tuple(len(values) + sum(nonzero[:k]) if keep else -1 for k, keep in enumerate(nonzero)))
                values += [entry for entry, keep in zip(row, nonzero, strict=True) if keep]
            layout.append((columns, tuple(indices)))
        return MassMatrix(inverse, stacked(values) if values else jnp.zeros(0), tuple(layout))

    def blocks(self) -> list[tuple[tuple[int, ...], list[list[Scalar]]]]:
        """Return the columns of each block, and its lower half."""
        entry = lambda k: self.values[k] if k >= 0 else 0.0  # noqa: E731
        return [(columns, [[entry(k) for k in row] for row in rows]) for columns, rows in self.layout]

    def factored(self) -> "FactoredMass":
        """Factorise the blocks of M."""
        return FactoredMass(self.inverse, [(columns, Factors.of(rows)) for columns, rows in self.blocks()])


class FactoredMass(NamedTuple):
    """M, ready to be solved with: the diagonal's reciprocals, and the columns and factors of each block."""

    inverse: Float[Array, " coordinates"]
    blocks: list[tuple[tuple[int, ...], Factors]]

    def solve_row(self, row: Mapping[int, Scalar]) -> dict[int, Scalar]:
        """Return M⁻¹ times a vector given by its entries that can differ from zero."""
        inside = {column for columns, _ in self.blocks for column in columns}
        solved: dict[int, Scalar] = {
            column: entry * self.inverse[column] for column, entry in row.items() if column not in inside
        }
        for columns, factors in self.blocks:
            # M⁻¹ of a row that does not touch a block has no entries there either.
            if any(column in row for column in columns):
                solved.update(zip(columns, factors.solve([row.get(column, 0.0) for column in columns]), strict=True))
        return solved

    def solve(self, vector: Float[Array, " coordinates"]) -> Float[Array, " coordinates"]:
        """Return M⁻¹ times a vector."""
        solved = self.inverse * vector
        if not self.blocks:
            return solved
        # Number by number: writing blocks into an array would be scatters.
        entries = [solved[k] for k in range(vector.shape[0])]
        for columns, factors in self.blocks:
            for column, entry in zip(columns, factors.solve([vector[column] for column in columns]), strict=True):
                entries[column] = entry
        return stacked(entries)


def solve_augmented(
    mass: MassMatrix,
    jacobian: SparseRows,
    force: Float[Array, " coordinates"],
    rhs: Float[Array, " rows"],
) -> tuple[Float[Array, " coordinates"], Float[Array, " rows"]]:
    """Solve the augmented system (M17); derivatives follow from the same system (M18).

    **Arguments:**

    - ``mass``: M.
    - ``jacobian``: Φ_q.
    - ``force``: (coordinates,) F [N, N, N m, …].
    - ``rhs``: (rows,) what Φ_q q̈ must be [m/s², rad/s²].

    **Returns:** accelerations q̈, (coordinates,) [m/s², rad/s²], and multipliers λ, (rows,) [N, N m].
    """
    static = (jacobian.pattern, mass.layout)
    return _solve(static, mass.inverse, mass.values, jacobian.values, force, rhs)


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def _solve(
    static: tuple[Pattern, Layout], inverse: Array, masses: Array, values: Array, force: Array, rhs: Array
) -> tuple[Float[Array, " coordinates"], Float[Array, " rows"]]:
    pattern, layout = static
    mass, jacobian = MassMatrix(inverse, masses, layout).factored(), SparseRows(values, pattern)
    if not pattern:
        return mass.solve(force), rhs
    rows = [{column: values[k] for column, k in row} for row in pattern]
    weighted = [mass.solve_row(row) for row in rows]
    # The lower half suffices: the factorisation reads nothing else.
    schur = [
        [sum((weighted[j][c] * entry for c, entry in rows[i].items() if c in weighted[j]), 0.0) for j in range(i + 1)]
        for i in range(len(rows))
    ]
    # What Φ_q q̈ would be without the joints.
    unheld = [sum(entry * force[column] for column, entry in row.items()) for row in weighted]
    # Written out: a call of LAPACK would split the loop's kernel.
    sides: list[Scalar] = [unheld[i] - rhs[i] for i in range(len(pattern))]
    multipliers = ldl_solve(schur, sides)
    return mass.solve(force - _reaction(jacobian, multipliers, force.shape[0])), multipliers


@_solve.defjvp
def _solve_jvp(static: tuple[Pattern, Layout], primals: tuple, tangents: tuple) -> tuple:
    """Solve the same system for a small change, with another right-hand side (M18): that is far cheaper than
    differentiating the factorisation."""
    pattern, layout = static
    inverse, masses, values, _, _ = primals
    d_inverse, d_masses, d_values, d_force, d_rhs = tangents
    acceleration, multipliers = _solve(static, *primals)
    moved = SparseRows(d_values, pattern)
    # M q̈ = F - Φ_qᵀ λ is what an inverse mass multiplies.
    d_force = d_force + d_inverse * acceleration / inverse**2
    if layout:
        d_force = d_force - _block_product(MassMatrix(inverse, d_masses, layout), acceleration)
    if pattern:
        d_force = d_force - _reaction(moved, multipliers, acceleration.shape[0])
        d_rhs = d_rhs - stacked(moved.times(acceleration))
    return (acceleration, multipliers), _solve(static, inverse, masses, values, d_force, d_rhs)


def _block_product(mass: MassMatrix, vector: Float[Array, " coordinates"]) -> Float[Array, " coordinates"]:
    """Return the blocks of M times a vector, zero in all other columns."""
    total: list[Scalar] = [0.0] * vector.shape[0]
    for columns, rows in mass.blocks():
        for i, row in enumerate(rows):
            for j, entry in enumerate(row):
                if not isinstance(entry, float):
                    total[columns[i]] = total[columns[i]] + entry * vector[columns[j]]
                    # An entry of the lower half stands for the one above the diagonal as well.
                    if i != j:
                        total[columns[j]] = total[columns[j]] + entry * vector[columns[i]]
    return stacked(total)


def _reaction(jacobian: SparseRows, multipliers: Array, coordinates: int) -> Float[Array, " coordinates"]:
    """Return Φ_qᵀ λ."""
    total: list[list[Scalar]] = [[] for _ in range(coordinates)]
    for i, row in enumerate(jacobian.pattern):
        for column, k in row:
            total[column].append(multipliers[i] * jacobian.values[k])
    return stacked([sum(terms) if terms else 0.0 for terms in total])
