"""Observables of an assembled mechanism: those that it is given, and those of its elements."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from .._types import Scalar
from ..errors import InputError
from .layout import Closed, EvaluatedState, Layout, State


class Observable(NamedTuple):
    """An observable: its ``name``; ``of``: its value from the mechanism, an evaluated state and the state's rate;
    ``of_rate``: whether it depends on the rate; ``least``: what its largest value is at least, as a depth is 0 where
    nothing touches; ``roundoff``: from the mechanism, what of it is rounding where nothing acts."""

    name: str
    of: Callable[[Any, EvaluatedState, State], Scalar]
    of_rate: bool = False
    least: float = -math.inf
    roundoff: Callable[[Any], Scalar] | None = None


def element_observables(layout: Layout, at: EvaluatedState, rate: State, active: Closed) -> dict[str, Scalar]:
    """Return the values of the elements' observables, by name. ``rate`` of the state; ``active``: closed contacts and
    switches."""
    values: dict[str, Scalar] = {}
    acceleration, closed = rate[layout.places["v"]], layout.of_elements(active)
    for k, (element, it) in enumerate(zip(layout.elements, at.elements, strict=True)):
        values |= element.observables(it, closed[k])
        if element.observed_of_rate:
            values |= element.observables_of_rate(it, acceleration, layout.own(rate, k))
    return values


def element_records(layout: Layout, at: EvaluatedState, active: Closed) -> dict[str, Scalar]:
    """Return what elements show in a history besides, by name.

    **Raises:** `InputError` where two elements show the same.
    """
    records: dict[str, Scalar] = {}
    sources: dict[str, str] = {}
    for element, it, closed in zip(layout.elements, at.elements, layout.of_elements(active), strict=True):
        recorded = element.recorded(it, closed)
        # An element may record with its sign what it observes without; of two elements one would hide the other.
        for name in {*element.observed, *element.observed_of_rate, *recorded}:
            if sources.setdefault(name, element.name) != element.name:
                both = f"{sources[name]!r} and {element.name!r}"
                raise InputError(f"the elements {both} both show {name!r}: give one of them another name")
        records |= recorded
    return records
