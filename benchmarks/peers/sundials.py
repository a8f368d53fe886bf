"""SUNDIALS through scikit-sundae, which finds the events itself: CVODE on the state, IDA on the whole system.

A touchdown starts the solver afresh, since the remembered approach speed jumps there. At a release and at the top of a
force it only stops to tell: the force has come down to zero by itself.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from sksundae.cvode import CVODE
from sksundae.ida import IDA

from .course import Course, PeerCapture
from .parameters import Matrix, Parameters, Vector
from .residual import UNKNOWNS, consistent, residual_into, residual_jacobian_into
from .start import STATES
from .watch import EVENTS, TOP, slope_into, slope_jacobian_into, watch

CONTACT_STEP = 1e-5  # [s] first step after a touchdown, where the force is still zero and tells nothing about the scale
UNTESTED = 1e6  # [N] keeps the multipliers out of IDA's error test: they follow from the state and leap with the force
STOPPED_BY_EVENT = 2
COMMON = {"num_events": EVENTS, "first_step": CONTACT_STEP, "max_num_steps": 10**6}


def _drive(course: Course, solver: CVODE | IDA, restart: Callable[[float, Vector], object]) -> PeerCapture:
    """Let ``solver`` run from event to event until the capture is over."""
    duration = course.parameters.duration
    t, y = 0.0, course.state
    result, fresh = None, True
    while not course.over:
        if fresh:
            course.evaluations += result.nfev if result else 0  # a restart sets the solver's own count back
            restart(t, y)
            fresh = False
        result = solver.step(duration, "normal", duration)
        t, y = result.t, result.y[:STATES]
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
    course.evaluations += result.nfev
    return course.report(t)


def cvode(method: str, parameters: Parameters, rtol: float, atol: float | Vector, **options) -> PeerCapture:
    """One capture by CVODE's ``method``, "Adams" or "BDF".

    scikit-sundae solves the step equations by Newton's method for either of them; the Jacobian is a compiled one.
    """
    course = Course(parameters)
    context = course.context

    def right_hand_side(_: float, y: Vector, slope: Vector) -> None:
        slope_into(y, slope, context)

    def jacobian(_: float, y: Vector, __: Vector, matrix: Matrix) -> None:
        slope_jacobian_into(y, matrix, context)

    def events(_: float, y: Vector, values: Vector) -> None:
        watch(y, values, context)

    events.direction = [-1] * EVENTS
    settings = COMMON | {"method": method, "rtol": rtol, "atol": atol, "jacfn": jacobian, "eventsfn": events} | options
    solver = CVODE(right_hand_side, **settings)
    return _drive(course, solver, solver.init_step)


def ida(parameters: Parameters, rtol: float, atol: float | Vector, **options) -> PeerCapture:
    """One capture by IDA, on the differential-algebraic form with the multipliers as unknowns."""
    course = Course(parameters)
    context = course.context

    def residual(_: float, z: Vector, dz: Vector, out: Vector) -> None:
        residual_into(z, dz, out, context)

    def jacobian(_: float, z: Vector, dz: Vector, __: Vector, rate: float, matrix: Matrix) -> None:
        residual_jacobian_into(z, dz, rate, matrix, context)

    def events(_: float, z: Vector, __: Vector, values: Vector) -> None:
        watch(z[:STATES], values, context)

    events.direction = [-1] * EVENTS
    tolerances = np.full(UNKNOWNS, UNTESTED)
    tolerances[:STATES] = atol
    settings = COMMON | {"rtol": rtol, "atol": tolerances, "jacfn": jacobian, "eventsfn": events} | options
    solver = IDA(residual, algebraic_idx=range(STATES, UNKNOWNS), **settings)
    return _drive(course, solver, lambda t, y: solver.init_step(t, *consistent(y, context)))
