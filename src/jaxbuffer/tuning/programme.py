"""Linear and convex quadratic programmes, built one variable and one row at a time: HiGHS and Clarabel solve them."""

import warnings
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

Entries = list[tuple[int, float]]  # column and coefficient


class Minimum(NamedTuple):
    """Where a programme is least, and the duals of its rows, none of them negative."""

    x: Float[np.ndarray, " columns"]
    duals: Float[np.ndarray, " rows"]


class Programme:
    """Minimise Σ cost x within bounds and rows Σ a x ≤ b."""

    def __init__(self) -> None:
        self.cost: list[float] = []
        self.bounds: list[tuple[float, float]] = []
        self.entries: list[tuple[int, int, float]] = []
        self.right: list[float] = []

    def add(self, cost: float, low: float, high: float = np.inf) -> int:
        """Another variable; returns its column."""
        self.cost.append(cost)
        self.bounds.append((low, high))
        return len(self.cost) - 1

    def row(self, entries: Entries, right: float) -> None:
        """Another row."""
        self.entries += [(len(self.right), column, value) for column, value in entries if value != 0.0]
        self.right.append(right)

    def solve(self, curvature: Float[np.ndarray, "n n"]) -> Minimum | None:
        """With ½ dᵀ B d added, d the first variables and B a positive semidefinite ``curvature``; None where the solver
        gives up."""
        from scipy.sparse import csc_matrix

        rows, columns, values = zip(*self.entries, strict=True)
        matrix = csc_matrix((values, (rows, columns)), shape=(len(self.right), len(self.cost)))
        return self._quadratic(matrix, curvature) if np.any(curvature) else self._linear(matrix)

    def _linear(self, matrix: np.ndarray) -> Minimum | None:
        from scipy.optimize import linprog

        found = linprog(self.cost, A_ub=matrix, b_ub=self.right, bounds=self.bounds, method="highs")
        return Minimum(found.x, -found.ineqlin.marginals) if found.success else None

    def _quadratic(self, matrix: np.ndarray, curvature: np.ndarray) -> Minimum | None:
        import qpsolvers
        from scipy.sparse import csc_matrix

        along, across = np.indices(curvature.shape).reshape(2, -1)
        square = csc_matrix((curvature.ravel(), (along, across)), shape=(len(self.cost),) * 2)
        low, high = np.array(self.bounds).T
        stated = qpsolvers.Problem(square, np.array(self.cost), matrix, np.array(self.right), lb=low, ub=high)
        with warnings.catch_warnings(action="ignore"):  # of what the solution says, too
            found = qpsolvers.solve_problem(stated, solver="clarabel")
        if not found.found or found.x is None or found.z is None:
            return None
        return Minimum(found.x, found.z)
