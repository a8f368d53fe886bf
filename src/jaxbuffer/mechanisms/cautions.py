"""What is said before anything is computed: numbers without effect, and what the geometry rules out."""

import re
from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType

import jax
import numpy as np

from ..fields import Part, inactive
from .registry import mechanism_of

NUMBER = re.compile(r"(?<!\w)-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


def cautions(
    runs: Sequence[tuple[Part, Part]],
    varied: Collection[str] = (),
    geometry: bool = True,
    units: Mapping[str, str] = MappingProxyType({}),
) -> list[str]:
    """Return a line for each number of a design that has no effect, and for what its geometry rules out.

    **Arguments:** ``runs``: designs with their scenarios, at least one, in the order of their numbers; a line that does
    not hold for all of several, or with other figures, names the first for which it does; ``varied``: paths that a
    sweep or a tuning gives values; ``geometry``: whether to look at the geometry, which a sweep may vary; ``units``:
    those that numbers were typed with, by address.
    """
    view = mechanism_of(runs[0][0]).view
    numbers: dict[str, list[int]] = {}
    firsts: dict[str, str] = {}
    same: dict[str, bool] = {}
    for number, (design, scenario) in enumerate(runs, 1):
        lines = inactive(design, scenario, varied, units)
        # Numbers that are traced are not known, and arrays are many designs at once: neither has one geometry.
        if geometry and _plain(design) and _plain(scenario):
            lines += view.contradictions(design, scenario)
        for line in lines:
            # What is said of several scenarios with other figures is one line, with those of the first.
            kind = NUMBER.sub("#", line)
            same[kind] = same.get(kind, True) and firsts.setdefault(kind, line) == line
            numbers.setdefault(kind, []).append(number)
    return [firsts[kind] + _where(those, len(runs), same[kind]) for kind, those in numbers.items()]


def _where(numbers: list[int], count: int, same: bool) -> str:
    """Return in which of several scenarios that is so, and whether it is the ``same`` in all of these."""
    if len(numbers) == count and same:
        return ""
    more = f" and {len(numbers) - 1} more" if len(numbers) > 1 else ""
    return f" (scenario {numbers[0]}{more} of {count})"


def _plain(part: Part) -> bool:
    """Return whether all numbers are known, and single."""
    leaves = jax.tree.leaves(part)
    return not any(isinstance(leaf, jax.core.Tracer) or np.ndim(leaf) for leaf in leaves)
