"""The order of combinations by a first objective and, of those about as good as the best, by a second one."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from ..mechanisms.limit import beyond
from ..tuning.problem.objective import Objective


class Second(NamedTuple):
    """A second objective of combinations: ``objective`` of their runs, None where ``constant`` alone decides, which
    price and mass add to it; ``ceiling``: how high the first objective may be, by its least value."""

    objective: Objective | None
    constant: Float[np.ndarray, " combinations"]
    ceiling: Callable[[float], float]


def within(values: Float[np.ndarray, "..."], ceiling: float) -> Bool[np.ndarray, "..."]:
    """Return which values of the first objective are not above a ceiling, but for rounding."""
    if not np.isfinite(ceiling):
        return np.full(np.shape(values), ceiling > 0.0)
    return np.asarray(beyond((values - ceiling) / (abs(ceiling) or 1.0)) == 0.0)


def order(
    values: Float[np.ndarray, " combinations"], seconds: Float[np.ndarray, " combinations"], ceiling: float
) -> Int[np.ndarray, " combinations"]:
    """Return the places of combinations in their order: those within the ceiling by their second value, the others
    behind them by the first. Equal ones stay in the order in which they are given."""
    inside = within(values, ceiling)
    return np.lexsort((np.where(inside, seconds, values), ~inside))
