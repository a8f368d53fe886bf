"""SUNDIALS IDA through scikit-sundae: the differential-algebraic form, as the paper's own solver has it."""

from __future__ import annotations

import numpy as np
from sksundae.ida import IDA

from .course import Course, PeerCapture
from .model import STATES, Matrix, Parameters, Vector
from .residual import UNKNOWNS, consistent, residual_into, residual_jacobian_into
from .watch import EVENTS, TOP, watch

CONTACT_STEP = 1e-5  # [s] first step after a touchdown, where the force is still zero and tells nothing about the scale
UNTESTED = 1e6  # [N] keeps the multipliers out of the error test: they follow from the state and leap with the force
STOPPED_BY_EVENT = 2


def _solver(course: Course, rtol: float, atol: float, options: dict) -> IDA:
    context = course.context

    def residual(_: float, z: Vector, dz: Vector, out: Vector) -> None:
        residual_into(z, dz, out, context)

    def jacobian(_: float, z: Vector, dz: Vector, __: Vector, rate: float, matrix: Matrix) -> None:
        residual_jacobian_into(z, dz, rate, matrix, context)

    def events(_: float, z: Vector, __: Vector, values: Vector) -> None:
        watch(z[:STATES], values, context)

    events.direction = [-1] * EVENTS
    tolerances = np.full(UNKNOWNS, atol)
    tolerances[STATES:] = UNTESTED
    return IDA(
        residual,
        rtol=rtol,
        atol=tolerances,
        jacfn=jacobian,
        eventsfn=events,
        num_events=EVENTS,
        algebraic_idx=range(STATES, UNKNOWNS),
        first_step=CONTACT_STEP,
        max_num_steps=10**6,
        **options,
    )


def capture(parameters: Parameters, rtol: float, atol: float, **options) -> PeerCapture:
    """One capture by IDA; it starts afresh at a touchdown, as CVODE does."""
    course = Course(parameters)
    context, duration = course.context, parameters.duration
    solver = _solver(course, rtol, atol, options)
    t, y = 0.0, course.state
    fresh = True
    while not course.over:
        if fresh:
            solver.init_step(t, *consistent(y, context))
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
    course.evaluations = result.nfev
    return course.report(t)
