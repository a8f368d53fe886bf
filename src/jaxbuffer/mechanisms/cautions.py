"""What is said before anything is computed: numbers without effect, and what the geometry rules out."""

from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType

import jax
import numpy as np

from ..fields import Part, inactive
from .registry import mechanism_of
from .view import Caution


def cautions(
    runs: Sequence[tuple[Part, Part]],
    varied: Collection[str] = (),
    geometry: bool = True,
    units: Mapping[str, str] = MappingProxyType({}),
    measured: bool = True,
    corners: Sequence[tuple[str, Part, Part]] = (),
) -> list[str]:
    """Return a line for each number of a design that has no effect, and for what its geometry rules out.

    Of several scenarios' lines on one subject it returns the worst, with the scenario's number.

    **Arguments:** ``runs``: pairs of a design and the scenario that it is run in, at least one, in the order of their
    numbers; ``varied``: paths that a sweep or a tuning gives values; ``geometry``: whether to look at the geometry,
    which a sweep may vary; ``units``: those that numbers were typed with, by address; ``measured``: whether to say what
    a run measures, too; ``corners``: further runs by their numbers, as a tuning's in the corners of tolerances, of
    which the geometry alone counts, because what a number needs is the same in all corners.
    """
    by_subject: dict[str, list[tuple[str, Caution]]] = {}
    numbered = [(str(number), *pair) for number, pair in enumerate(runs, 1)]
    for k, (number, design, scenario) in enumerate([*numbered, *corners]):
        lines = inactive(design, scenario, varied, units) if k < len(runs) else []
        found = [Caution(line, line) for line in lines]
        # Numbers that are traced are not known, and arrays are many designs at once: neither has one geometry.
        if geometry and _plain(design) and _plain(scenario):
            found += mechanism_of(design).view.contradictions(design, scenario)
        for caution in found:
            if measured or not caution.measured:
                by_subject.setdefault(caution.subject, []).append((number, caution))
    return [_worst_line(those, len(runs) + len(corners)) for those in by_subject.values()]


def _worst_line(those: list[tuple[str, Caution]], count: int) -> str:
    """Return the worst of the lines on one subject, the first of equal ones, and in which of several scenarios that is
    so."""
    number, worst = max(those, key=lambda it: it[1].excess)
    if len({caution.line for _, caution in those}) > 1:
        return f"{worst.line} (worst in scenario {number}; so in {len(those)} of {count})"
    if len(those) == count:
        return worst.line
    more = f" and {len(those) - 1} more" if len(those) > 1 else ""
    return f"{worst.line} (scenario {number}{more} of {count})"


def _plain(part: Part) -> bool:
    """Return whether all numbers are known, and single."""
    leaves = jax.tree.leaves(part)
    return not any(isinstance(leaf, jax.core.Tracer) or np.ndim(leaf) for leaf in leaves)
