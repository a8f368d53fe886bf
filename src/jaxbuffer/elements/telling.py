"""What elements ask of a run for its summary: the largest value of an observable, and when something closed.

A mechanism's own quantities come first, such as ``peak_latch_force`` and ``latch_time``: they may know more than the
observables of the elements do.
"""

import math
from typing import Any, NamedTuple

import numpy as np

SHOWN = {"m": ("mm", 1e3), "rad": ("deg", math.degrees(1.0))}  # units of summaries, and how many the own one is
BY_HOW_MUCH = "the command simulate and jb.trust say by how much"  # after a warning that errors may grow


def largest(run: Any, name: str) -> float:
    """Return the largest value of an observable, by its name; NaN where the run has none."""
    if f"peak_{name}" in run.mechanism.quantities:
        return float(np.asarray(run.quantity(f"peak_{name}")))
    return float(np.asarray(run.maxima.get(name, math.nan)))


class SummaryRow(NamedTuple):
    """A line of a summary that says a number, with what there is of it at most and when it was reached: "25.1 mm of 30
    mm at 0.12 s".

    - ``heading``.
    - ``value``, and the ``limit`` of it or None, in the ``unit``.
    - ``time`` [s], NaN where it is not known.
    - ``note``: what follows the number, before the time.
    - ``least``: what is smaller is rounding, shown as 0 without a time.
    """

    heading: str
    value: float
    unit: str
    limit: Any = None
    time: float = math.nan
    note: str = ""
    least: float = -math.inf

    @staticmethod
    def largest(run: Any, name: str, unit: str, heading: str = "", **others: Any) -> "SummaryRow":
        """Return the row of the largest value of an observable."""
        return SummaryRow(heading, largest(run, name), unit, time=run.maximum_times.get(name, math.nan), **others)

    @property
    def text(self) -> str:
        """Return the number in words."""
        symbol, many = SHOWN.get(self.unit, (self.unit, 1.0))
        of = "" if self.limit is None else f" of {many * float(self.limit):.6g} {symbol}"
        if self.value < self.least:
            return f"0 {symbol}{of}{self.note}"
        return f"{many * float(self.value):.6g} {symbol}{of}{self.note}{when(self.time)}"

    @property
    def line(self) -> tuple[str, str]:
        """Return heading and text."""
        return self.heading, self.text


def when(time: float) -> str:
    """Return a time as it follows a number: " at 0.12 s", or "" where it is not known."""
    return f" at {time:.6g} s" if math.isfinite(time) else ""


def closed_at(run: Any, switch: str) -> float:
    """Return when a switch closed first [s]; NaN where it did not."""
    if f"{switch}_time" in run.mechanism.quantities:
        return float(np.asarray(run.quantity(f"{switch}_time")))
    return run.switch_times.get(switch, math.nan)
