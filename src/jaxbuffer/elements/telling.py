"""What elements ask of a run to tell of it: the largest value of an observable, and when something closed.

A mechanism's own quantities come first, such as ``peak_latch_force`` and ``latch_time``: they may know more than the
observables of the elements do.
"""

import math
from typing import Any

import numpy as np

BY_HOW_MUCH = "the command simulate and jb.trust say by how much"  # after a warning that errors may grow


def largest(run: Any, name: str) -> float:
    """Return the largest value of an observable, by its name; NaN where the run has none."""
    if f"peak_{name}" in run.mechanism.quantities:
        return float(np.asarray(run.quantity(f"peak_{name}")))
    return float(np.asarray(run.maxima.get(name, math.nan)))


def reached(run: Any, name: str) -> str:
    """Return when that was: " at 0.12 s", or "" where it is not known."""
    return when(run.maximum_times.get(name, math.nan))


def when(time: float) -> str:
    """Return a time as it follows a number: " at 0.12 s", or "" where it is not known."""
    return f" at {time:.6g} s" if math.isfinite(time) else ""


def closed_at(run: Any, switch: str) -> float:
    """Return when a switch closed first [s]; NaN where it did not."""
    if f"{switch}_time" in run.mechanism.quantities:
        return float(np.asarray(run.quantity(f"{switch}_time")))
    return run.switch_times.get(switch, math.nan)
