"""What is said before anything is computed: numbers without effect, and what the geometry rules out."""

from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType

import jax
import numpy as np

from ..fields import Part, inactive
from .registry import mechanism_of


def cautions(
    design: Part,
    scenarios: Sequence[Part],
    varied: Collection[str] = (),
    geometry: bool = True,
    units: Mapping[str, str] = MappingProxyType({}),
) -> list[str]:
    """Return a line for each number of a design that has no effect, and for what its geometry rules out.

    **Arguments:** ``design``; ``scenarios``: those that it is run in, at least one; a line that does not hold for all
    of several names the first for which it does; ``varied``: paths that a sweep or a tuning gives values;
    ``geometry``: whether to look at the geometry, which a sweep may vary; ``units``: those that numbers were typed
    with, by address.
    """
    view = mechanism_of(design).view
    numbers: dict[str, list[int]] = {}
    for number, scenario in enumerate(scenarios, 1):
        lines = inactive(design, scenario, varied, units)
        # Numbers that are traced are not known, and arrays are many designs at once: neither has one geometry.
        if geometry and _plain(design) and _plain(scenario):
            lines += view.contradictions(design, scenario)
        for line in lines:
            numbers.setdefault(line, []).append(number)
    return [line + _where(those, len(scenarios)) for line, those in numbers.items()]


def _where(numbers: list[int], count: int) -> str:
    """Return in which of several scenarios that is so."""
    if len(numbers) == count:
        return ""
    more = f" and {len(numbers) - 1} more" if len(numbers) > 1 else ""
    return f" (scenario {numbers[0]}{more} of {count})"


def _plain(part: Part) -> bool:
    """Return whether all numbers are known, and single."""
    leaves = jax.tree.leaves(part)
    return not any(isinstance(leaf, jax.core.Tracer) or np.ndim(leaf) for leaf in leaves)
