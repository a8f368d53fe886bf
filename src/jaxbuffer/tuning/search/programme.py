"""A linear or convex quadratic programme, built a row at a time, and what constraints ask of a model of a step."""

import warnings
from collections.abc import Iterable
from typing import NamedTuple, Protocol

import numpy as np
import scipy
from jaxtyping import Float

from ..problem.objective import Objective

Entries = list[tuple[int, float]]  # column and coefficient
Step = Float[np.ndarray, " variables"]
Source = tuple[str, int | tuple[int, int], np.ndarray | float]  # of a row: field of the tangent, where, coefficient
Row = tuple[Entries, float, tuple[Source, ...]]


class Minimum(NamedTuple):
    """The point where a programme is least, and the duals of its rows, none of them negative."""

    x: Float[np.ndarray, " columns"]
    duals: Float[np.ndarray, " rows"]


class Programme:
    """A linear or convex quadratic programme: minimise Σ cost x within bounds and rows Σ a x ≤ b.

    It is built one variable and one row at a time; HiGHS and Clarabel solve it.
    """

    def __init__(self) -> None:
        self.cost: list[float] = []
        self.bounds: list[tuple[float, float]] = []
        self.entries: list[tuple[int, int, float]] = []
        self.right: list[float] = []

    def add(self, cost: float, low: float, high: float = np.inf) -> int:
        """Add a variable and return its column."""
        self.cost.append(cost)
        self.bounds.append((low, high))
        return len(self.cost) - 1

    def row(self, entries: Iterable[tuple[int, float]], right: float) -> None:
        """Add a row."""
        self.entries += [(len(self.right), column, value) for column, value in entries if value != 0.0]
        self.right.append(right)

    def solve(self, curvature: Float[np.ndarray, "n n"]) -> Minimum | None:
        """Solve it with ½ dᵀ B d added, d the first variables and B a positive semidefinite ``curvature``.

        **Returns:** None where the solver gives up.
        """
        rows, columns, values = zip(*self.entries, strict=True)
        matrix = scipy.sparse.csc_matrix((values, (rows, columns)), shape=(len(self.right), len(self.cost)))
        if np.any(curvature):
            return self._quadratic(matrix, curvature)
        result = scipy.optimize.linprog(self.cost, A_ub=matrix, b_ub=self.right, bounds=self.bounds, method="highs")
        # SciPy's marginals are what the cost gains for more on the right: the duals with the other sign.
        return Minimum(result.x, -result.ineqlin.marginals) if result.success else None

    def _quadratic(self, matrix: np.ndarray, curvature: np.ndarray) -> Minimum | None:
        import qpsolvers  # takes a second with its solvers, which few commands need

        along, across = np.indices(curvature.shape).reshape(2, -1)
        square = scipy.sparse.csc_matrix((curvature.ravel(), (along, across)), shape=(len(self.cost),) * 2)
        low, high = np.array(self.bounds).T
        problem = qpsolvers.Problem(square, np.array(self.cost), matrix, np.array(self.right), lb=low, ub=high)
        with warnings.catch_warnings(action="ignore"):  # the solution says the same
            solution = qpsolvers.solve_problem(problem, solver="clarabel")
        if not solution.found or solution.x is None or solution.z is None:
            return None
        return Minimum(solution.x, solution.z)


class StepModel(Protocol):
    """A model of a step, to first order, to which constraints give their rows; ``cases``: numbers of the load cases."""

    cases: range

    def weighted(self, k: int, weights: np.ndarray) -> Row:
        """Return a weighted sum of one load case's quantities: entries and a constant."""

    def margin_row(self, k: int) -> Row:
        """Return the row that keeps one load case's margin above zero."""

    def aggregate(self, objective: Objective, scale: float, cost: float) -> Entries:
        """Return an objective over ``scale`` as entries, whose ``cost`` is that of its value."""
