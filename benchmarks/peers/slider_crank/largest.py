"""The largest acceleration of the slider and torque of the drive within a run, located between its steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize_scalar

from .dop853 import STAGES, step
from .model import STATES, Vector, evaluate
from .run import MEMORY, MODES, Run


def largest(run: Run) -> dict[str, float]:
    """Of a run with its course: |acceleration| [m/s²] and |torque| [N m], each with its time [s]."""
    maxima = {}
    for name, place in (("slider_acceleration", 0), ("drive_torque", 1)):
        values = np.array([_values(run, row, 0.0)[place] for row in run.course])
        top = int(np.argmax(np.abs(values)))
        best, at = abs(float(values[top])), float(run.course[top, 0])
        for row in run.course[max(top - 1, 0) : top + 1]:
            force, time = _within(run, row, place)
            if force > best:
                best, at = force, time
        maxima[name], maxima[f"{name}_time"] = best, at
    return maxima


def _values(run: Run, row: Vector, after: float) -> tuple[float, float]:
    """Acceleration of the slider [m/s²] and torque [N m] a time ``after`` [s] the step that starts with ``row``."""
    k, joints = np.empty((STAGES + 1, STATES)), np.zeros((2, 6))
    state, modes, memory = row[1 : STATES + 1].copy(), row[MODES].copy(), row[MEMORY].copy()
    torque = evaluate(state, modes, memory, run.crank, k[0], joints)
    if after > 0.0:
        state = step(state, after, modes, memory, run.crank, k, joints)
        torque = evaluate(state, modes, memory, run.crank, k[0], joints)
    return float(k[0, 7]), float(torque)


def _within(run: Run, row: Vector, place: int) -> tuple[float, float]:
    """Largest magnitude inside the step that starts with ``row``, and its time [s]."""
    later = run.course[:, 0][run.course[:, 0] > row[0]]
    length = (later[0] if len(later) else run.end_time) - row[0]
    value: Callable[[float], float] = lambda after: -abs(_values(run, row, after)[place])  # noqa: E731
    inside = minimize_scalar(value, bounds=(0.0, length), method="bounded", options={"xatol": 1e-8 * length})
    return -float(inside.fun), float(row[0] + inside.x)
