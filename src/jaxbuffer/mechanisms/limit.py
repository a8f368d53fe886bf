"""Limits on the quantities of a run: the one place that decides whether a limit is kept, and says so."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from ..value_text import digits_apart, with_unit
from .quantity import Catalogue, Quantity

# Relative. An event that ends a run at a value leaves that value to the rounding of its location: a limit at the same
# value is kept.
ROUNDING = 1e-9
IMPACTS = "impacts"  # what a limit on the number of touchdowns is called
COUNT = Quantity("-", lambda run: run.impact_count, "number of touchdowns", IMPACTS)

UPPER, LOWER = ("≤", "above"), ("≥", "below")


@dataclasses.dataclass(frozen=True)
class Limit:
    """A limit on a quantity of every run.

    **Arguments:**

    - ``name``: of the quantity.
    - ``bound``: in the quantity's unit.
    - ``lowest``: whether it is a lower limit.

    **Example:** a value on the limit keeps it, also where rounding leaves it a little above; NaN does not.

    >>> from jaxbuffer.mechanisms.limit import Limit
    >>> Limit("stroke", 0.025).keeps([0.024, 0.025 + 1e-13, 0.026, float("nan")]).tolist()
    [True, True, False, False]
    """

    name: str
    bound: float
    lowest: bool = False

    def rows(self, values: Any) -> Float[np.ndarray, "..."]:
        """Return how far values are beyond the limit, relative to it; below 0 within it, NaN where a value is."""
        return np.asarray(self.sign * (np.asarray(values, float) / self.bound - 1.0))

    def slopes(self, slopes: Any) -> Float[np.ndarray, "..."]:
        """Return the slopes of `rows` from those of the values."""
        return np.asarray(self.sign * np.asarray(slopes, float) / self.bound)

    def excess(self, values: Any) -> Float[np.ndarray, "..."]:
        """Return how far values are beyond the limit, relative to it: 0 where they keep it, infinite for NaN."""
        return beyond(self.rows(values))

    def keeps(self, values: Any) -> Bool[np.ndarray, "..."]:
        """Return which values keep the limit. One that is not known, NaN or None, does not."""
        known = np.array(values, dtype=float)  # None becomes NaN
        return self.excess(known) == 0.0

    def share(self, values: Any) -> Float[np.ndarray, "..."]:
        """Return the share of the limit that values use: 1 on it, infinite where they are not known."""
        known = np.array(values, dtype=float)
        if not self.lowest:
            return np.where(np.isnan(known), np.inf, known / self.bound)
        # A lower limit is used up the more, the smaller the value: without end at zero.
        positive = known > 0.0
        return np.where(positive, self.bound / np.where(positive, known, 1.0), np.inf)

    def margin(self, value: float | None) -> float | None:
        """Return how far a value keeps from the limit, relative to it; None where it is not known, and for a whole
        number, which has no margin to speak of."""
        if value is None or math.isnan(value) or self.name == IMPACTS:
            return None
        # Adding zero makes 0 of -0, which would be shown with its sign.
        return -float(self.rows(value)) + 0.0

    def quantity(self, catalogue: Catalogue) -> Quantity:
        """Return what is limited: one of a ``catalogue``, or the number of touchdowns."""
        return COUNT if self.name == IMPACTS else catalogue[self.name]

    def worst(self, values: Sequence[float | None]) -> float | None:
        """Return the value nearest to the limit or farthest beyond it; None where one is not known."""
        known = [value for value in values if value is not None and not math.isnan(value)]
        if len(known) < len(values):
            return None
        return min(known) if self.lowest else max(known)

    @property
    def sign(self) -> float:
        """Return 1, or -1 for a lower limit."""
        return -1.0 if self.lowest else 1.0

    @property
    def symbol(self) -> str:
        """Return "≤", or "≥" for a lower limit."""
        return (LOWER if self.lowest else UPPER)[0]

    @property
    def side(self) -> str:
        """Return where a value that breaks the limit is: "above" or "below" it."""
        return (LOWER if self.lowest else UPPER)[1]

    def line(self, quantity: Quantity) -> str:
        """Return the limit in words: "stroke ≤ 25 mm"."""
        return f"{self.name} {self.bound_text(*quantity.in_figures)}"

    def sentence(self, value: float, quantity: Quantity) -> str:
        """Return how a value breaks the limit: "stroke 26 mm is above 25 mm", with as many digits as tell them apart.

        A value that is not known says so.
        """
        if math.isnan(value):
            return f"{self.name} is not known, limit {self.bound_text(*quantity.in_figures)}"
        apart = self.told_apart(value, *quantity.in_figures)
        return f"{self.name} {apart} is {self.side} {quantity.in_words(self.bound)}"

    def bound_text(self, unit: str = "", factor: float = 1.0) -> str:
        """Return "≤ 25 mm"; ``factor``: how many of the ``unit`` the quantity's own one is."""
        return f"{self.symbol} {with_unit(factor * self.bound, unit)}"

    def told_apart(self, value: float, unit: str = "", factor: float = 1.0) -> str:
        """Return a value that breaks the limit, with as many digits as tell it from the bound: "25.0002 mm".

        **Arguments:** ``unit``, ``factor``: as of `bound_text`.
        """
        return with_unit(factor * value, unit, digits_apart(factor * value, factor * self.bound))


def beyond(rows: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
    """Return by how much rows are above 0: 0 within `ROUNDING` of it, infinite for NaN."""
    return np.where(np.isnan(rows), np.inf, np.where(rows > ROUNDING, rows, 0.0))


def both_sides(at_most: Mapping[str, float], at_least: Mapping[str, float]) -> tuple[Limit, ...]:
    """Return upper limits by quantity, then lower ones."""
    upper = [Limit(name, float(bound)) for name, bound in at_most.items()]
    return (*upper, *(Limit(name, float(bound), lowest=True) for name, bound in at_least.items()))
