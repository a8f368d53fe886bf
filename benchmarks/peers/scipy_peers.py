"""SciPy's solvers, driven step by step: ``solve_ivp`` would call each event separately, from Python, at every step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import OdeSolver
from scipy.optimize import brentq

from .course import Course, PeerCapture
from .parameters import Parameters, Vector
from .watch import EVENTS, TOP, crossings, forces, slope, slope_jacobian, watch, watched

CONTACT_STEP = 1e-5  # [s] first step into a contact: a guess made from the zero force at touchdown would leap over it
ROOT = 1e-14  # [s] how closely an event is located
HOPELESS = 0.8  # a top whose estimate is below this part of the highest one so far need not be located


class Segment:
    """One run of a stepper from one restart to the next."""

    def __init__(self, method: type[OdeSolver], course: Course, t: float, y: Vector, options: dict) -> None:
        self.course = course
        self.context = context = course.context
        self.before, self.now = np.empty(EVENTS), np.empty(EVENTS)
        watch(y, self.before, context)
        # The event just met stands at zero give or take a rounding; it counts as lying behind.
        np.maximum(self.before[:2], 1e-300, out=self.before[:2])
        duration = course.parameters.duration
        first = min(CONTACT_STEP, duration - t)
        self.stepper = method(lambda _, state: slope(state, context), t, y, duration, first_step=first, **options)

    def root(self, event: int, dense: Callable[[float], Vector], early: float, late: float) -> float:
        """Time [s] between ``early`` and ``late`` at which watched number ``event`` falls through zero."""

        def value(t: float) -> float:
            return watched(dense(t), event, self.context)

        # The interpolant may differ from the step's ends in the last bits.
        if value(early) <= 0.0:
            return early
        if value(late) >= 0.0:
            return late
        return brentq(value, early, late, xtol=ROOT, rtol=1e-15)

    def hopeless(self, flank: int, y_old: Vector, y_new: Vector, step: float) -> bool:
        """Whether a top within the latest step is lower than an earlier one, judged by the tangents at its ends."""
        left = forces(y_old, self.context)[flank] + self.before[TOP + flank] * step
        right = forces(y_new, self.context)[flank] - self.now[TOP + flank] * step
        return max(left, right) < HOPELESS * self.course.peak[0]

    def run(self) -> tuple[float, Vector]:
        """Time [s] and state at which the solver must start afresh or stop."""
        course, stepper = self.course, self.stepper
        y_old = stepper.y
        while stepper.status == "running":
            stepper.step()
            course.steps += 1
            mask = crossings(stepper.y, self.before, self.now, self.context)
            if mask:
                end = self.settle(mask, y_old)
                if end is not None:
                    return end
                watch(stepper.y, self.now, self.context)
            self.before, self.now = self.now, self.before
            y_old = stepper.y
        if stepper.status == "failed":
            course.outcome = "failed"
        return stepper.t, stepper.y

    def settle(self, mask: int, y_old: Vector) -> tuple[float, Vector] | None:
        """Deal with what the latest step crossed; time and state of a restart or the end, if it holds one."""
        course, stepper = self.course, self.stepper
        fallen = [event for event in range(EVENTS) if mask >> event & 1]
        halts = [e for e in fallen if e < TOP and (e > 1 or not course.presses(e))]
        tops = [e for e in fallen if e >= TOP]
        early, late, y_late = stepper.t_old, stepper.t, stepper.y
        tops = [e for e in tops if not self.hopeless(e - TOP, y_old, y_late, late - early)]
        halt = None
        if halts or tops:
            dense = stepper.dense_output()
            if halts:
                late, halt = min((self.root(event, dense, early, late), event) for event in halts)
                y_late = dense(late)
            for event in tops:
                if watched(y_late, event, self.context) <= 0.0:
                    t = self.root(event, dense, early, late)
                    course.top(event - TOP, t, dense(t))
        for event in fallen:
            if event < 2 and event not in halts and watched(y_late, event, self.context) <= 0.0:
                course.meet(event, y_late)
        if halt is None:
            return None
        course.meet(halt, y_late)
        return late, y_late


def capture(
    method: type[OdeSolver],
    parameters: Parameters,
    rtol: float,
    atol: float | Vector,
    implicit: bool = False,
    **options: float,
) -> PeerCapture:
    """One capture by a SciPy stepper class.

    An ``implicit`` one is given a compiled Jacobian. A touchdown starts the solver afresh, since the remembered
    approach speed jumps. A release does not, the force having come down to zero by itself: a fresh start there was
    tried and no faster.
    """
    course = Course(parameters)
    context = course.context
    settings: dict = {"rtol": rtol, "atol": atol, **options}
    if implicit:
        settings["jac"] = lambda _, state: slope_jacobian(state, context)
    t, y = 0.0, course.state
    while t < parameters.duration and not course.over:
        segment = Segment(method, course, t, y, settings)
        t, y = segment.run()
        course.evaluations += segment.stepper.nfev
    return course.report(t)
