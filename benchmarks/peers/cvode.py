"""SUNDIALS CVODE through scikit-sundae, which finds the events itself."""

from __future__ import annotations

import numpy as np
from sksundae.cvode import CVODE

from .course import Course, PeerCapture
from .model import Parameters, Vector
from .watch import EVENTS, TOP, slope_jacobian_into, slope_into, watch

CONTACT_STEP = 1e-6  # [s] first step after a touchdown, where the force is still zero and tells nothing about the scale
STOPPED_BY_EVENT = 2


def _solver(course: Course, method: str, rtol: float, atol: float, options: dict) -> CVODE:
    context = course.context

    def right_hand_side(_: float, y: Vector, slope: Vector) -> None:
        slope_into(y, slope, context)

    def jacobian(_: float, y: Vector, __: Vector, matrix: Vector) -> None:
        slope_jacobian_into(y, matrix, context)

    def events(_: float, y: Vector, values: Vector) -> None:
        watch(y, values, context)

    events.direction = [-1] * EVENTS
    return CVODE(
        right_hand_side,
        method=method,
        rtol=rtol,
        atol=atol,
        jacfn=jacobian,
        eventsfn=events,
        num_events=EVENTS,
        first_step=CONTACT_STEP,
        max_num_steps=10**6,
        **options,
    )


def capture(method: str, parameters: Parameters, rtol: float, atol: float, **options) -> PeerCapture:
    """One capture by CVODE's ``method``, "Adams" or "BDF".

    A touchdown starts CVODE afresh, since the remembered approach speed jumps; at a release and at the top of a force it
    only stops to tell.
    """
    course = Course(parameters)
    context, duration = course.context, parameters.duration
    solver = _solver(course, method, rtol, atol, options)
    t, y = 0.0, course.state
    values = np.empty(EVENTS)
    fresh = True
    while not course.over:
        if fresh:
            solver.init_step(t, y)
            fresh = False
        result = solver.step(duration, "normal", duration)
        t, y = result.t, result.y
        if result.status < 0:
            course.outcome = "failed"
        if result.status != STOPPED_BY_EVENT:
            break
        for event in np.flatnonzero(result.i_events[-1]):
            if event >= TOP:
                course.top(event - TOP, t, y)
            else:
                fresh = fresh or event > 1 or not course.presses(event)
                course.meet(event, y)
    course.evaluations = result.nfev
    return course.report(t)
