"""The safe part of a two-dimensional sweep, and the largest rectangle of safe runs in it."""

import dataclasses
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from ..errors import InputError, check_type, suggest
from ..fields import Part, ends_as_typed, get
from ..sweeps.axis import Axis
from ..sweeps.result import Sweep
from ..tables import text
from ..tuning.problem.objective import Limits
from ..value_text import range_text

UNDONE = "not computed"  # of a run that an interrupted sweep has not reached
ROUNDING = 1e-9  # of a range: a value so near to its end is in it


class Between(NamedTuple):
    """The runs within the ranges of some scenarios: how many were computed (``runs``), how many of these are not safe
    (``unsafe``), all of it in a sentence (``words``), and how many there are to compute (``total``)."""

    runs: int
    unsafe: int
    words: str
    total: int


@dataclasses.dataclass(frozen=True)
class SafeRectangle:
    """Where every limit is kept. Print it for the ranges.

    - ``swept``: over two fields of more than one value each; ``limits``: what a safe run keeps.
    - ``axes``: those two; ``values``: theirs in increasing order, (m,) and (n,).
    - ``safe`` (m, n): which runs end as they should and keep every limit; ``share`` (m, n) [-]: the largest share of a
      limit, 1 on it, NaN without numbers; ``reasons`` (m, n): the first thing that each of the others breaks, in words.
    - ``first``, ``second``: lowest and highest value of either field in the largest rectangle of safe runs, or None
      where no run is safe; ``runs``: how many it has.
    - ``scenarios``: for which the design was made, if any are known.

    **Example:** which heights and stiffnesses keep the peak force below 1500 N?

    >>> values = {"scenario.height": [0.05, 0.1, 0.2], "impact.stiffness": [1e11, 2e11]}  # m, N/m^e
    >>> swept = jb.sweep(jb.BarDrop(), jb.BarDropScenario(), over=values)
    >>> found = jb.safe_rectangle(swept, jb.Limits(at_most={"peak_force": 1500.0}))  # N
    >>> found.safe.shape, found.runs > 0
    ((3, 2), True)
    """

    swept: Sweep
    limits: Limits
    axes: tuple[Axis, Axis]
    values: tuple[np.ndarray, np.ndarray]
    safe: Bool[np.ndarray, "m n"]
    share: Float[np.ndarray, "m n"]
    reasons: np.ndarray
    first: tuple[float, float] | None
    second: tuple[float, float] | None
    runs: int
    scenarios: tuple[Part, ...] = ()

    @property
    def between(self) -> Between | None:
        """Return how the runs between the ``scenarios`` do, at those included; None where both fields are not the
        scenario's, or no run lies there. A design that keeps its limits in each scenario may break them in between."""
        prefix, ranges = "scenario.", []
        # Of a single scenario nothing lies in between.
        inside = np.full(self.safe.shape, len(self.scenarios) > 1)
        for k, (axis, values) in enumerate(zip(self.axes, self.values, strict=True)):
            if not axis.path.startswith(prefix) or not self.scenarios:
                return None
            met = [float(get(scenario, axis.path.removeprefix(prefix))) for scenario in self.scenarios]
            room = ROUNDING * (max(met) - min(met))
            within = (values >= min(met) - room) & (values <= max(met) + room)
            inside &= within[:, None] if k == 0 else within
            ranges.append(f"{axis.name.replace('_', ' ')} {_range_words(axis, (min(met), max(met)))}")
        total, run = int(inside.sum()), inside & (self.reasons != UNDONE)
        if not total:
            return None
        runs, unsafe = int(run.sum()), int((run & ~self.safe).sum())
        name, reasons = f"{self.swept.mechanism.view.run_name}s", Counter(self.reasons[run & ~self.safe])
        broken = ", ".join(f"{reason} ({many})" for reason, many in reasons.items())
        if runs == total:
            count = f"{runs} {name}"
            words = f"{unsafe} of {count} are not safe: {broken}" if unsafe else f"all {count} are safe"
        else:
            words = f"{runs} of {total} {name} run, which says nothing of the others"
            words += f"; {unsafe} of these are not safe: {broken}" if unsafe else "; none of these is unsafe"
        return Between(runs, unsafe, f"Between the study's scenarios ({', '.join(ranges)}) {words}.", total)

    @property
    def done(self) -> int:
        """Return how many runs of the sweep were computed."""
        return int((self.reasons != UNDONE).sum())

    @property
    def counted(self) -> str:
        """Say how many runs are safe: "22 of 48 captures", of an interrupted sweep "22 of 30 captures run, of 48"."""
        name, size = f"{self.swept.mechanism.view.run_name}s", self.safe.size
        of = f"{size} {name}" if self.done == size else f"{self.done} {name} run, of {size}"
        return f"{int(self.safe.sum())} of {of}"

    @property
    def criterion(self) -> str:
        """Say what makes a run safe: "captured, stroke ≤ 25 mm"."""
        mechanism = self.swept.mechanism
        codes = {mechanism.outcomes[name]: name for name in mechanism.successes}
        names = [name for code, name in codes.items() if np.any(self.swept.code == code)]
        ends = (" or ".join(names) or mechanism.success or "solved") if self.limits.require_success else "solved"
        if (end := mechanism.required_end(self.limits.ends, self.limits.names)) is not None:
            ends = end.name
        limits = [line.replace("_", " ") for line in self.limits.lines(mechanism.quantities)]
        limits += [f"{it.name} {it.bound_text()}" for it in self.limits.of_impacts]
        return ", ".join([ends, *limits])

    def __repr__(self) -> str:
        mechanism = self.swept.mechanism
        between = [] if self.between is None else [self.between.words]
        lines = [f"Safe ({self.criterion}): {self.counted}"]
        if self.first is None or self.second is None:
            return text(*lines, "  no run is safe", *between)
        parts = zip(self.values, (self.first, self.second), strict=True)
        shape = " × ".join(str(np.sum((values >= part[0]) & (values <= part[1]))) for values, part in parts)
        lines.append(f"largest rectangle of safe {mechanism.view.run_name}s, {self.runs} of them ({shape}):")
        lines += [
            f"  {axis.path:26} {_range_words(axis, part)}"
            for axis, part in zip(self.axes, (self.first, self.second), strict=True)
        ]
        return text(*lines, *between)


def _range_words(axis: Axis, part: tuple[float, float]) -> str:
    """Say a range in its unit, angles in degrees besides: "-0.05 … 0.05 rad (-2.86° … +2.86°)"."""
    # Adding zero makes 0 of -0, which would be shown with its sign.
    low, high, symbol = ends_as_typed(part[0] + 0.0, part[1] + 0.0, axis.unit, axis.typed)
    words = range_text(low, high, symbol, 4, " … ")
    if symbol != "rad":
        return words
    return f"{words} ({range_text(np.degrees(low), np.degrees(high), '°', 3, ' … ')})"


def safe_rectangle(swept: Sweep, limits: Limits | None = None, scenarios: Sequence[Part] = ()) -> SafeRectangle:
    """Find where a two-dimensional sweep is safe, and the largest rectangle of safe runs in it.

    A run is safe that was solved and keeps every limit. The rectangle has the
    most runs of all whose runs are all safe; between its runs nothing was computed.

    **Arguments:**

    - ``swept``: over two fields, and any others with one value each.
    - ``limits``: what a run must keep (default: only that it ends as the mechanism's runs should).
    - ``scenarios``: for which the design was made, such as a tuning's: `SafeRectangle.between` says what is between.

    **Returns:** a `SafeRectangle`.

    **Raises:** `InputError` for sweeps over more or fewer fields and quantities that sweeps have not.

    **Example:**

    >>> values = {"scenario.height": [0.05, 0.1, 0.2], "impact.stiffness": [1e11, 2e11]}  # m, N/m^e
    >>> swept = jb.sweep(jb.BarDrop(), jb.BarDropScenario(), over=values)
    >>> found = jb.safe_rectangle(swept, jb.Limits(at_most={"peak_force": 1500.0}))  # N
    >>> found.first[0], found.second[0]
    (0.05, 100000000000.0)
    """
    limits = Limits() if limits is None else limits
    check_type("limits", limits, Limits, "safe_rectangle(swept, jb.Limits(at_most={'stroke': 0.025}))")
    moving = [k for k, axis in enumerate(swept.grid.axes) if len(axis) > 1]
    if len(moving) != 2:
        raise InputError(f"a safe rectangle needs a sweep over two fields with several values; this has {len(moving)}")
    first, second = (swept.grid.axes[k] for k in moving)
    if choices := [axis.path for axis in (first, second) if not axis.unit]:
        raise InputError(f"a safe rectangle is over numbers; {choices[0]} is a choice")
    # In increasing order, since a sweep's values may be listed in any.
    right, up = np.argsort(first.values), np.argsort(second.values)

    def face(column: np.ndarray) -> np.ndarray:
        return column.reshape(len(first), len(second))[np.ix_(right, up)]

    _check_limits(swept, limits)
    share, reasons = np.zeros((len(first), len(second))), face(_ends(swept, limits))
    limited = [(limit, swept.columns[limit.name]) for limit in limits.each]
    limited += [(limit, swept.impact_count.astype(float)) for limit in limits.of_impacts]
    for limit, values in limited:
        # Not `maximum`: a limit on what a run does not have must not hide the others.
        share = np.fmax(share, face(limit.share(values)))
        name, kept = limit.name.replace("_", " "), face(limit.keeps(values))
        # Before the line below, which would say of a number that is not known that it is beyond its limit.
        reasons[face(np.isnan(values)) & (reasons == "")] = f"{name} not known"
        reasons[~kept & (reasons == "")] = f"{name} {limit.side} its limit"
    share = np.where(face(swept.solved), share, np.nan)
    safe = reasons == ""
    rows, columns = largest_rectangle(safe)
    x, y = first.values[right], second.values[up]
    runs = (rows.stop - rows.start) * (columns.stop - columns.start)
    return SafeRectangle(
        swept=swept,
        limits=limits,
        axes=(first, second),
        values=(x, y),
        safe=safe,
        share=share,
        reasons=reasons,
        first=(float(x[rows][0]), float(x[rows][-1])) if runs else None,
        second=(float(y[columns][0]), float(y[columns][-1])) if runs else None,
        runs=runs,
        scenarios=tuple(scenarios),
    )


def _check_limits(swept: Sweep, limits: Limits) -> None:
    """Raise `InputError` for limits on what sweeps do not have, or the design has not."""
    for name in limits.names:
        if name not in (known := swept.mechanism.swept):
            raise InputError(f"limits.{name} is no quantity of a sweep{suggest(name, known)}")
    # A field that the sweep varies counts as there, although the design may have none of its own.
    moved = set() if swept.grid is None else {axis.path for axis in swept.grid.axes}
    limits.check(swept.mechanism, lambda path: path in moved or get(swept.design, path))


def _ends(swept: Sweep, limits: Limits) -> np.ndarray:
    """Return how each run ended that is not safe for its end alone, "" for the others."""
    good = swept.solved & limits.ended(swept.mechanism, swept.code)
    named = [f"failed: {it.name}" if it.failed else it.name.replace("_", " ") for it in swept.outcomes]
    words = np.where(swept.done, np.array(named, object), UNDONE)
    # As objects, because an array of texts would cut off longer reasons that are put into it later.
    return np.where(good, "", words).astype(object)


def largest_rectangle(mask: Bool[np.ndarray, "m n"]) -> tuple[slice, slice]:
    """Find rows and columns of the largest rectangle of true entries: empty slices if there is none, the first of
    equals.

    Row by row, each column has a bar as high as its unbroken true entries up to that row. The largest rectangle under
    the bars is found with a stack of rising ones, so that each entry is looked at a fixed number of times: O(m n).

    **Source:** the largest rectangle in a histogram; D. Vandevoorde, Dr. Dobb's Journal 23(4), 1998.
    """
    heights: Int[np.ndarray, " n"] = np.zeros(mask.shape[1], int)
    most, largest = 0, (slice(0, 0), slice(0, 0))
    for row, entries in enumerate(mask):
        heights = np.where(entries, heights + 1, 0)
        rising: list[tuple[int, int]] = []  # where each bar could begin, and its height
        # A last bar of no height closes all that are still rising.
        for column, height in enumerate([*heights.tolist(), 0]):
            begin = column
            while rising and rising[-1][1] >= height:
                begin, tall = rising.pop()
                if (size := tall * (column - begin)) > most:
                    most, largest = size, (slice(row + 1 - tall, row + 1), slice(begin, column))
            rising.append((begin, height))
    return largest
