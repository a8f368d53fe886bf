"""The continuous optimum over the ranges that catalogues span: what any catalogue within them could reach."""

import dataclasses
from collections.abc import Sequence
from typing import Any

from ..fields import Part, get, replace, unit
from ..tuning.problem.variable import Variable
from ..tuning.report.tuned import Tuned
from ..tuning.tune import tune
from ..value_text import percent_text, relative_change, with_unit
from .catalogue import TOTALS, PartsCatalogue
from .criterion import Criterion

SAME = 1e-6  # relative: values that are no further apart are taken for one, well above their errors at rtol 1e-9


@dataclasses.dataclass(frozen=True)
class ContinuousOptimum:
    """The best design found if every number that parts set could be anything in its catalogue's range.

    - ``tuned``: the tuning that found it; None where there was none.
    - ``value``: its objective, with the least price and mass there are.
    - ``none``: why there is none, in words.
    """

    tuned: Tuned | None = None
    value: float = float("nan")
    none: str = ""

    def line(self, criterion: Criterion, best: float | None) -> str:
        """Return it in a line beside the ``best`` combination's value, None where none is feasible."""
        if self.tuned is None:
            return f"continuous optimum: none, {self.none}"
        ranges = ", ".join(self.tuned.problem.paths)
        shown = with_unit(*criterion.shown(self.value), 5)
        start = f"continuous optimum over the catalogues' ranges of {ranges}: {shown}"
        if not self.tuned.feasible:
            return f"{start}, and it breaks limits too: other parts within these ranges will hardly keep them"
        if best is None:
            return f"{start}, within all limits: parts near its numbers would do"
        change = relative_change(self.value, best) or 0.0
        if change < -SAME:
            return f"{start}, which the best combination is below: the search has found a local optimum, no bound"
        above = f"; the best combination is {percent_text(change, '.2g')} above it"
        above = above if change > SAME else ", which the best combination reaches"
        sure = (
            "searches from different starts agree on it"
            if self.tuned.confirmed
            else "found by a search that no other one confirms"
        )
        return f"{start}{above}; {sure}: a local optimum, so no strict bound"


def continuous_optimum(
    criterion: Criterion,
    catalogues: Sequence[PartsCatalogue],
    start: Part,
    **tuning: Any,
) -> ContinuousOptimum:
    """Tune every number that parts set within the range of its catalogue, and the problem's own variables.

    **Arguments:** ``start``: the best combination's design; ``tuning``: keywords of `tune`.
    """
    objective = criterion.of_runs
    if objective is None:
        return ContinuousOptimum(none="price and mass alone decide")
    ranges, why = _ranges(catalogues, start)
    if why or not ranges:
        return ContinuousOptimum(none=why or "no number differs between the parts")
    own = criterion.problem
    # A second objective may raise the first one within its tolerance, and the bound is one on the first.
    problem = dataclasses.replace(
        own, design=_within(start, ranges), variables=(*ranges, *own.variables), objective=objective, then=None
    )
    tuned = tune(problem, **tuning)
    # No combination is cheaper or lighter than the least of each catalogue, whichever parts those are.
    least = {name: sum(min(part.totals.get(name, 0.0) for part in it.parts) for it in catalogues) for name in TOTALS}
    return ContinuousOptimum(tuned, tuned.objective[1] + criterion.constant(least))


def _ranges(catalogues: Sequence[PartsCatalogue], design: Part) -> tuple[list[Variable], str]:
    """Return a variable for each number that differs between the parts of a catalogue, or why there is none."""
    ranges = []
    for catalogue in catalogues:
        for path in catalogue.paths:
            values = [part.fields[path] for part in catalogue.parts if path in part.fields]
            whole = len(values) == len(catalogue.parts)
            if whole and len(set(map(repr, values))) == 1:
                continue
            if not unit(design, path) or not whole:
                return [], f"{path} differs between the parts and is no number with a range"
            low, high = min(values), max(values)
            ranges.append(Variable(path, low, high, "log" if low > 0.0 else "linear"))
    return ranges, ""


def _within(design: Part, ranges: Sequence[Variable]) -> Part:
    """Return the design with every number in its range; that of a combination is there already."""
    inside = {it.path: min(max(float(get(design, it.path)), it.low), it.high) for it in ranges}
    return replace(design, inside)
