"""The safe part of a two-dimensional sweep, and the largest rectangle of safe runs in it."""

import dataclasses
from collections.abc import Mapping

import numpy as np
from jaxtyping import Bool, Float, Int

from ..errors import InputError, check_number, check_type, suggest
from ..sweeps.grid import Axis
from ..sweeps.swept import Swept

COUNT = "impact_count"


@dataclasses.dataclass(frozen=True)
class SafeRectangle:
    """Where every limit is kept. Print it for the ranges.

    - ``swept``: over two fields of more than one value each; ``limits``: by quantity, in its unit.
    - ``axes``: those two; ``values``: theirs in increasing order, (m,) and (n,).
    - ``safe`` (m, n): which runs end as they should and keep every limit; ``share`` (m, n) [-]: the largest share of a
      limit, 1 on it, NaN without numbers; ``reasons`` (m, n): the first thing that each of the others breaks, in words.
    - ``first``, ``second``: lowest and highest value of either field in the largest rectangle of safe runs, or None
      where no run is safe; ``runs``: how many it has.

    **Example:** which heights and stiffnesses keep the peak force below 1500 N?

    >>> values = {"scenario.height": [0.05, 0.1, 0.2], "impact.stiffness": [1e11, 2e11]}  # m, N/m^e
    >>> from jaxbuffer.sweeps.swept import swept_over
    >>> swept = swept_over(jb.BarDrop(), jb.BarDropScenario(), values)
    >>> found = jb.safe_rectangle(swept, {"peak_force": 1500.0})  # N
    >>> found.safe.shape, found.runs > 0
    ((3, 2), True)
    """

    swept: Swept
    limits: Mapping[str, float]
    axes: tuple[Axis, Axis]
    values: tuple[np.ndarray, np.ndarray]
    safe: Bool[np.ndarray, "m n"]
    share: Float[np.ndarray, "m n"]
    reasons: np.ndarray
    first: tuple[float, float] | None
    second: tuple[float, float] | None
    runs: int

    @property
    def asked(self) -> str:
        """What makes a run safe, in words: "captured, stroke ≤ 25 mm"."""
        mechanism = self.swept.found.mechanism
        words = [mechanism.success or "solved"]
        for name, limit in self.limits.items():
            quantity = mechanism.quantities.get(name)
            unit, factor = (quantity.shown or (quantity.unit, 1.0)) if quantity else ("", 1.0)
            words.append(f"{name.replace('_', ' ')} ≤ {factor * limit:.6g} {unit}".rstrip(" -"))
        return ", ".join(words)

    def __repr__(self) -> str:
        from .summary import rectangle_summary

        return rectangle_summary(self)


def safe_rectangle(swept: Swept, limits: Mapping[str, float] | None = None) -> SafeRectangle:
    """Where a two-dimensional sweep is safe, and the largest rectangle of safe runs in it.

    A run is safe that was solved, ended as the mechanism's runs should, and is above no limit. The rectangle has the
    most runs of all whose runs are all safe; between its runs nothing was computed.

    **Arguments:**

    - ``swept``: over two fields, and any others with one value each.
    - ``limits``: upper limits by quantity, in its unit (default: none but the end that a run must have).

    **Returns:** a `SafeRectangle`.

    **Raises:** `InputError` for sweeps over more or fewer fields and quantities that sweeps have not.

    **Example:**

    >>> values = {"scenario.height": [0.05, 0.1, 0.2], "impact.stiffness": [1e11, 2e11]}  # m, N/m^e
    >>> from jaxbuffer.sweeps.swept import swept_over
    >>> swept = swept_over(jb.BarDrop(), jb.BarDropScenario(), values)
    >>> found = jb.safe_rectangle(swept, {"peak_force": 1500.0})  # N
    >>> found.first[0], found.second[0]
    (0.05, 100000000000.0)
    """
    limits = {} if limits is None else limits
    check_type("limits", limits, Mapping, "safe_rectangle(swept, {'stroke': 0.025})")
    moving = [k for k, axis in enumerate(swept.grid.axes) if len(axis) > 1]
    if len(moving) != 2:
        raise InputError(f"a safe rectangle needs a sweep over two fields with several values; this has {len(moving)}")
    first, second = (swept.grid.axes[k] for k in moving)
    right, up = np.argsort(first.values), np.argsort(second.values)

    def face(column: np.ndarray) -> np.ndarray:
        return column.reshape(len(first), len(second))[np.ix_(right, up)]

    safe, share = face(_succeeded(swept)), np.zeros((len(first), len(second)))
    reasons = face(_ends(swept))
    for name, limit in limits.items():
        of_limit = face(_column(swept, name, limit)) / limit
        share = np.fmax(share, of_limit)
        reasons[(of_limit > 1.0) & (reasons == "")] = f"{name.replace('_', ' ')} above its limit"
    share = np.where(face(swept.solved), share, np.nan)
    safe = safe & (np.nan_to_num(share, nan=np.inf) <= 1.0)
    rows, columns = largest_rectangle(safe)
    x, y = first.values[right], second.values[up]
    runs = (rows.stop - rows.start) * (columns.stop - columns.start)
    return SafeRectangle(
        swept=swept,
        limits=dict(limits),
        axes=(first, second),
        values=(x, y),
        safe=safe,
        share=share,
        reasons=reasons,
        first=(float(x[rows][0]), float(x[rows][-1])) if runs else None,
        second=(float(y[columns][0]), float(y[columns][-1])) if runs else None,
        runs=runs,
    )


def _succeeded(swept: Swept) -> np.ndarray:
    mechanism = swept.found.mechanism
    good = True if mechanism.success is None else swept.found.code == mechanism.outcomes[mechanism.success]
    return swept.solved & good


def _ends(swept: Swept) -> np.ndarray:
    """How each run ended that is not safe for its end alone, "" for the others."""
    named = [f"failed: {it.name}" if it.failed else it.name.replace("_", " ") for it in swept.found.outcomes]
    words = np.where(swept.done, np.array(named, object), "not computed")
    return np.where(_succeeded(swept), "", words).astype(object)


def _column(swept: Swept, name: str, limit: float) -> np.ndarray:
    mechanism = swept.found.mechanism
    known = (*mechanism.swept, COUNT)
    if name not in known:
        raise InputError(f"limits.{name} is no quantity of a sweep{suggest(name, known)}")
    unit = "-" if name == COUNT else mechanism.quantities[name].unit
    check_number(f"limits.{name}", limit, unit, low=0.0, low_open=True)
    values = swept.found.columns[name].astype(float)
    return np.where(np.isnan(values), np.inf, values)  # what is not known is not safe


def largest_rectangle(mask: Bool[np.ndarray, "m n"]) -> tuple[slice, slice]:
    """Rows and columns of the largest rectangle of true entries, empty slices if there is none; the first of equals.

    Row by row, each column has a bar as high as its unbroken true entries up to that row. The largest rectangle under
    the bars is found with a stack of rising ones, so that each entry is looked at a fixed number of times: O(m n).

    **Source:** the largest rectangle in a histogram; D. Vandevoorde, Dr. Dobb's Journal 23(4), 1998.
    """
    heights: Int[np.ndarray, " n"] = np.zeros(mask.shape[1], int)
    most, found = 0, (slice(0, 0), slice(0, 0))
    for row, entries in enumerate(mask):
        heights = np.where(entries, heights + 1, 0)
        rising: list[tuple[int, int]] = []  # where each bar could begin, and its height
        for column, height in enumerate([*heights.tolist(), 0]):
            begin = column
            while rising and rising[-1][1] >= height:
                begin, tall = rising.pop()
                if (size := tall * (column - begin)) > most:
                    most, found = size, (slice(row + 1 - tall, row + 1), slice(begin, column))
            rising.append((begin, height))
    return found
