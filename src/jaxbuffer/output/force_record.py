"""The largest contact force over time, as a record: what a page needs to draw it and to tell its values."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float

from ..mechanisms.run import Run
from ..run.instants import at_times
from .pulses import fine_times

TIMES = 2000  # evenly spread ones
DIGITS = 7  # of a time [s] after the point: a tenth of a microsecond
SIGNIFICANT = 6  # digits of a force


def force_over_time(run: Run) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """Times [s], close to each other where a contact is closed, and the largest force of any contact then [N].

    **Arguments:** ``run``: one simulated with ``history=True``.
    """
    time = fine_times(run, TIMES)
    return time, np.max(np.asarray(at_times(run, time).contact_force), axis=1)


def force_record(runs: Mapping[str, Run], scenario: str) -> dict[str, Any]:
    """The forces of some runs by name: "before" and "after" say. ``scenario``: theirs, in words."""
    return {"scenario": scenario, "curves": [{"name": name, **_curve(run)} for name, run in runs.items()]}


def _curve(run: Run) -> dict[str, list[float]]:
    """A run's times and forces, without those that lie between two others without any force."""
    time, force = force_over_time(run)
    idle = np.concatenate([[False], (force[:-2] == 0.0) & (force[1:-1] == 0.0) & (force[2:] == 0.0), [False]])
    forces = [float(f"{value:.{SIGNIFICANT}g}") for value in force[~idle]]
    return {"time [s]": np.round(time[~idle], DIGITS).tolist(), "force [N]": forces}
