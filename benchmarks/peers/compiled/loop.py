"""The loop: steps, control of their size, and every event located on the step's interpolant.

A touchdown starts the method afresh, since the remembered approach speed jumps there. A release does not: the force has
come down to zero by itself.
"""

from __future__ import annotations

from functools import partial
from types import ModuleType

import numpy as np
from numba import njit

from ..contact import SLOWEST_TOUCHDOWN, both_gaps
from ..course import PeerCapture
from ..parameters import Parameters, Vector
from ..start import STATES
from ..watch import CAPTURE, ESCAPE, EVENTS, TOP, context_of, distances_into, forces, slope_into, watch_along, watched
from . import dop853 as dop853_method
from . import rodas4 as rodas4_method

CONTACT_STEP = 1e-5  # [s] first step into a contact: a guess made from the zero force at touchdown would leap over it
ROOT = 1e-14  # [s] how closely a touchdown, a release or the end is located
TOP_ROOT = 1e-9  # [s] a force's top, where an error counts by its square
HOPELESS = 0.8  # a top whose estimate is below this part of the highest one so far need not be located
SAFETY, LEAST, MOST = 0.9, 0.2, 10.0  # of the next step over this one
SHORTEST = 1e-15  # [s]
OUTCOMES = ("timeout", "captured", "escaped", "failed")


@njit
def meet(event: int, y: Vector, context: Vector) -> int:
    """Let a contact close or open in ``context``; how many touchdowns that is."""
    if context[30 + event] != 0.0:
        context[30 + event] = 0.0
        return 0
    context[30 + event] = 1.0
    context[32 + event] = max(-both_gaps(y, context[0:30])[2 + event], SLOWEST_TOUCHDOWN)
    return 1


def loop_of(method: ModuleType):
    """The compiled loop of a method."""
    step, interpolant, at = method.step, method.interpolant, method.at
    workspace, terms_of, power = method.workspace, method.TERMS, -1.0 / method.ORDER

    @njit(error_model="numpy")
    def value(event, x, y, new, terms, point, context):
        """A watched number at the fraction ``x`` of a step."""
        at(x, y, new, terms, point)
        if event >= TOP:
            return watched(point, event, context)
        values = np.empty(EVENTS)
        distances_into(point, values, context)
        return values[event]

    @njit(error_model="numpy")
    def root(event, late, close, y, new, terms, point, context):
        """The fraction up to ``late`` at which a watched number falls through zero: false position, kept moving."""
        low, high = 0.0, late
        f_low = value(event, low, y, new, terms, point, context)
        f_high = value(event, high, y, new, terms, point, context)
        if f_low <= 0.0:
            return low
        if f_high >= 0.0:
            return high
        side = 0
        for _ in range(100):
            x = (low * f_high - high * f_low) / (f_high - f_low)
            f = value(event, x, y, new, terms, point, context)
            if f > 0.0:
                done = x - low <= close and side == 1
                low, f_low = x, f
                f_high *= 0.5 if side == 1 else 1.0
                side = 1
            else:
                done = high - x <= close and side == -1
                high, f_high = x, f
                f_low *= 0.5 if side == -1 else 1.0
                side = -1
            if done or high - low <= close or f == 0.0:
                return x
        return high

    @njit(error_model="numpy")
    def loop(y, context, duration, rtol, atol):
        """Outcome, end, peak, its time and flank, touchdowns, steps, evaluations of one capture."""
        work = workspace()
        terms = np.empty((terms_of, STATES))
        slope, new, new_slope, point = np.empty(STATES), np.empty(STATES), np.empty(STATES), np.empty(STATES)
        before, now = np.empty(EVENTS), np.empty(EVENTS)
        t, h, fresh, anew, rejected = 0.0, CONTACT_STEP, True, True, False
        peak, peak_time, peak_flank, impacts, steps, attempts = 0.0, 0.0, 0, 1, 0, 0
        while t < duration:
            if fresh:
                slope_into(y, slope, context)
                watch_along(y, slope, before, context)
                for event in range(2):  # the event just met stands at zero give or take a rounding: it lies behind
                    before[event] = max(before[event], 1e-300)
                h, fresh, anew = min(CONTACT_STEP, duration - t), False, True
            h = min(h, duration - t)
            error = step(y, slope, h, rtol, atol, anew, context, new, new_slope, work)
            attempts += 1
            anew = False
            if not error < 1.0:
                h *= max(LEAST, SAFETY * error**power) if error == error else LEAST
                rejected = True
                if h < SHORTEST:
                    return 3, t, peak, peak_time, peak_flank, impacts, steps, attempts
                continue
            most = 1.0 if rejected else MOST
            factor = min(most, max(LEAST, SAFETY * error**power)) if error > 0.0 else most
            rejected, anew = False, True
            steps += 1
            watch_along(new, new_slope, now, context)
            ready, late, halt = False, 1.0, -1
            for event in range(TOP):
                if before[event] > 0.0 and now[event] <= 0.0 and (event > 1 or context[30 + event] == 0.0):
                    if not ready:
                        interpolant(y, h, new, context, terms, work)
                        ready = True
                    x = root(event, late, ROOT / h, y, new, terms, point, context)
                    if halt < 0 or x < late:
                        late, halt = x, event
            pressed = forces(new, context)
            earlier = forces(y, context)
            for event in range(TOP, EVENTS):
                flank = event - TOP
                if before[event] > 0.0 and now[event] <= 0.0:
                    left, right = earlier[flank] + before[event] * h, pressed[flank] - now[event] * h
                    if max(left, right) < HOPELESS * peak:
                        continue
                    if not ready:
                        interpolant(y, h, new, context, terms, work)
                        ready = True
                    x = root(event, 1.0, TOP_ROOT / h, y, new, terms, point, context)
                    if x < late or halt < 0:
                        at(x, y, new, terms, point)
                        force = forces(point, context)[flank]
                        if force > peak:
                            peak, peak_time, peak_flank = force, t + x * h, flank
            if halt >= 0:
                at(late, y, new, terms, point)
                new[:] = point
                distances_into(new, now, context)
            for event in range(2):
                if event != halt and before[event] > 0.0 and now[event] <= 0.0:
                    impacts += meet(event, new, context)
            t += late * h
            y[:] = new
            if halt >= TOP - 2:
                return halt - 1, t, peak, peak_time, peak_flank, impacts, steps, attempts
            if halt >= 0:
                impacts += meet(halt, y, context)
                fresh = True
                continue
            slope[:] = new_slope
            watch_along(y, slope, before, context)
            h *= factor
        return 0, t, peak, peak_time, peak_flank, impacts, steps, attempts

    return loop


LOOPS = {method: loop_of(method) for method in (dop853_method, rodas4_method)}


def capture(method: ModuleType, parameters: Parameters, rtol: float, atol: float | Vector) -> PeerCapture:
    """One capture by a ``method`` of this folder."""
    y, context = context_of(parameters)
    allowed = np.full(STATES, atol) if np.ndim(atol) == 0 else np.asarray(atol)
    code, end, peak, time, flank, impacts, steps, attempts = LOOPS[method](y, context, parameters.duration, rtol, allowed)
    return PeerCapture(OUTCOMES[code], end, peak, time, ("lower", "upper")[flank], impacts, steps, attempts)


dop853 = partial(capture, dop853_method)
rodas4 = partial(capture, rodas4_method)
