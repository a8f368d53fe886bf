"""CVODE driven from compiled code: its right-hand side, Jacobian and root functions are C functions made by numba.

Nothing of Python runs inside a capture. The restarts are those of `sundials`; the solver and its memory are made once
for all captures of a process.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import carray, cfunc, njit, types

from ..contact import SLOWEST_TOUCHDOWN, both_gaps
from ..course import PeerCapture
from ..jacobian import jacobian_into
from ..parameters import Parameters, Vector
from ..start import STATES
from ..watch import CAPTURE, CONTEXT, EVENTS, TOP, context_of, forces, slope_into, watch_along
from . import sundials_library

CONTACT_STEP = 1e-5  # [s] first step after a touchdown, where the force is still zero and tells nothing about the scale
METHODS = {"Adams": 1, "BDF": 2}
NORMAL, STOPPED_BY_EVENT = 1, 2
MOST_STEPS = 10**6
FAILED = 3
OUTCOMES = ("timeout", "captured", "escaped", "failed")
C = sundials_library.functions()
# What the C functions need beside the state, one after another: context, room for a Jacobian, a slope, reactions.
MATRIX, SLOPE, REACTIONS = CONTEXT, CONTEXT + STATES * STATES, CONTEXT + STATES * STATES + STATES
ROOM = REACTIONS + 4

if C is not None:
    array_of, matrix_of = C["N_VGetArrayPointer"], C["SUNDenseMatrix_Data"]
    run, restart, first_step, stop_at = C["CVode"], C["CVodeReInit"], C["CVodeSetInitStep"], C["CVodeSetStopTime"]
    roots_of, steps_of, calls_of = C["CVodeGetRootInfo"], C["CVodeGetNumSteps"], C["CVodeGetNumRhsEvals"]
    P = types.uintp
    DATA = types.CPointer(types.float64)

    @cfunc(types.int32(types.float64, P, P, DATA))
    def right_hand_side(_, y, slope, data):
        """CVRhsFn."""
        out = carray(array_of(slope), (STATES,))
        slope_into(carray(array_of(y), (STATES,)), out, carray(data, (CONTEXT,)))
        return 0

    @cfunc(types.int32(types.float64, P, P, P, DATA, P, P, P))
    def jacobian(_, y, slope, matrix, data, one, two, three):
        """CVLsJacFn; SUNDIALS stores columns one after another."""
        room = carray(data, (ROOM,))
        values = carray(data, (ROOM,))[MATRIX:SLOPE].reshape((STATES, STATES))
        state = carray(array_of(y), (STATES,))
        p, active, memory = room[0:30], room[30:32], room[32:34]
        jacobian_into(state, values, p, active, memory, room[SLOPE:REACTIONS], room[REACTIONS:ROOM])
        columns = carray(matrix_of(matrix), (STATES, STATES))
        for column in range(STATES):
            for row in range(STATES):
                columns[column, row] = values[row, column]
        return 0

    @cfunc(types.int32(types.float64, P, types.CPointer(types.float64), DATA))
    def events(_, y, values, data):
        """CVRootFn."""
        room = carray(data, (ROOM,))
        state, flow = carray(array_of(y), (STATES,)), room[SLOPE:REACTIONS]
        if room[30] != 0.0 or room[31] != 0.0:
            slope_into(state, flow, room[0:CONTEXT])
        watch_along(state, flow, carray(values, (EVENTS,)), room[0:CONTEXT])
        return 0

    @njit(error_model="numpy")
    def note(fallen, t, y, context, best):
        """Let the events of a stop happen: outcome (or 0), touchdowns, and whether the solver must start afresh."""
        for flank in range(2):
            if fallen[TOP + flank] != 0:
                force = forces(y, context)[flank]
                if force > best[0]:
                    best[0], best[1], best[2] = force, t, flank
        impacts = 0
        for flank in range(2):
            if fallen[flank] == 0:
                continue
            if context[30 + flank] != 0.0:
                context[30 + flank] = 0.0
            else:
                context[30 + flank] = 1.0
                context[32 + flank] = max(-both_gaps(y, context[0:30])[2 + flank], SLOWEST_TOUCHDOWN)
                impacts += 1
        for event in range(CAPTURE, TOP):
            if fallen[event] != 0:
                return event - 1, impacts
        return 0, impacts

    @njit(error_model="numpy")
    def loop(memory, vector, y, room, duration):
        """Outcome, end, best (3,), touchdowns, steps and right-hand sides of one capture."""
        context, best, fallen = room[0:CONTEXT], np.zeros(3), np.zeros(EVENTS, np.int32)
        reached, count = np.zeros(1), np.zeros(1, np.int64)
        t, fresh, impacts, steps, calls = 0.0, True, 1, 0, 0
        while True:
            if fresh:
                restart(memory, t, vector)
                first_step(memory, CONTACT_STEP)
                stop_at(memory, duration)
            status = run(memory, duration, vector, reached.ctypes.data, NORMAL)
            t = reached[0]
            outcome, met = 0, 0
            if status == STOPPED_BY_EVENT:
                roots_of(memory, fallen.ctypes.data)
                outcome, met = note(fallen, t, y, context, best)
                impacts += met
            fresh = met > 0
            if fresh or outcome != 0 or status != STOPPED_BY_EVENT:
                steps_of(memory, count.ctypes.data)
                steps += count[0]
                calls_of(memory, count.ctypes.data)
                calls += count[0]
            if status < 0:
                return FAILED, t, best, impacts, steps, calls
            if outcome != 0 or status != STOPPED_BY_EVENT:
                return outcome, t, best, impacts, steps, calls


@cache
def solver(method: str):
    """CVODE's memory and vector, and the arrays behind them: state (25,), absolute tolerances (25,), room."""
    context = np.zeros(1, np.uintp)
    C["SUNContext_Create"](0, context.ctypes.data)
    sun = int(context[0])
    C["SUNContext_ClearErrHandlers"](sun)
    y, atol, room = np.zeros(STATES), np.ones(STATES), np.zeros(ROOM)
    vector, allowed = (C["N_VMake_Serial"](STATES, array.ctypes.data, sun) for array in (y, atol))
    memory = C["CVodeCreate"](METHODS[method], sun)
    matrix = C["SUNDenseMatrix"](STATES, STATES, sun)
    directions = np.full(EVENTS, -1, np.int32)
    linear = C["SUNLinSol_Dense"](vector, matrix, sun)
    for name, *arguments in (
        ("CVodeInit", right_hand_side.address, 0.0, vector),
        ("CVodeSVtolerances", 1e-6, allowed),
        ("CVodeSetUserData", room.ctypes.data),
        ("CVodeSetLinearSolver", linear, matrix),
        ("CVodeSetJacFn", jacobian.address),
        ("CVodeRootInit", EVENTS, events.address),
        ("CVodeSetRootDirection", directions.ctypes.data),
        ("CVodeSetMaxNumSteps", MOST_STEPS),
    ):
        if C[name](memory, *arguments) != 0:
            raise RuntimeError(f"{name} of SUNDIALS failed")
    return memory, vector, allowed, y, atol, room


def capture(method: str, parameters: Parameters, rtol: float, atol: float | Vector) -> PeerCapture:
    """One capture by CVODE's ``method``, "Adams" or "BDF", step equations by Newton's method with a dense Jacobian."""
    memory, vector, allowed, y, tolerances, room = solver(method)
    y[:], room[0:CONTEXT] = context_of(parameters)
    tolerances[:] = atol
    C["CVodeSVtolerances"](memory, rtol, allowed)
    code, end, best, impacts, steps, calls = loop(memory, vector, y, room, parameters.duration)
    flank = ("lower", "upper")[int(best[2])]
    return PeerCapture(OUTCOMES[code], end, float(best[0]), float(best[1]), flank, impacts, steps, int(calls))
