"""The loop: steps, control of their size, and every event located on the step's interpolant.

A touchdown starts the method afresh, since the remembered approach speed jumps there. A release does not: the force has
come down to zero by itself.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from numba import njit

from ..contact import SLOWEST_TOUCHDOWN, both_gaps
from ..course import PeerCapture
from ..parameters import Parameters, Vector
from ..start import STATES
from ..watch import ACTIVE, context_of, forces, slope_into, watch_along
from .dop853 import dop853_of
from .method import Mechanism, Method
from .rodas4 import RODAS4

CONTACT_STEP = 1e-5  # [s] first step into a contact: a guess made from the zero force at touchdown would leap over it
ROOT = 1e-14  # [s] how closely a touchdown, a release or the end is located
TOP_ROOT = 1e-9  # [s] a force's top, where an error counts by its square
HOPELESS = 0.8  # a top whose estimate is below this part of the highest one so far need not be located
SAFETY, LEAST, MOST = 0.9, 0.2, 10.0  # of the next step over this one
SHORTEST = 1e-15  # [s]
OUTCOMES = ("timeout", "captured", "escaped", "failed")
FAILED = 3
PEAK, TIME, CONTACT = range(3)  # of the highest top so far [N, s, -]


def meet_of(mechanism: Mechanism):
    """What happens at a touchdown or release."""
    active, memory, approach = mechanism.active, mechanism.active + mechanism.contacts, mechanism.approach

    @njit
    def meet(event: int, y: Vector, context: Vector) -> int:
        """Let a contact close or open in ``context``; how many touchdowns that is."""
        if context[active + event] != 0.0:
            context[active + event] = 0.0
            return 0
        context[active + event] = 1.0
        context[memory + event] = max(approach(event, y, context), SLOWEST_TOUCHDOWN)
        return 1

    return meet


@njit
def fell(event: int, before: Vector, now: Vector) -> bool:
    """Whether a watched number fell through zero."""
    return before[event] > 0.0 and now[event] <= 0.0


def root_of(mechanism: Mechanism, method: Method):
    """Where, as a fraction up to ``late`` of a step, a watched number falls through zero, by false position."""
    at, top, slope_into, watch_along = method.at, mechanism.contacts + 2, mechanism.slope_into, mechanism.watch_along

    @njit(error_model="numpy")
    def value(event, x, y, new, terms, room, context):
        point, flow, values = room
        at(x, y, new, terms, point)
        if event >= top:
            slope_into(point, flow, context)
        watch_along(point, flow, values, context)
        return values[event]

    @njit(error_model="numpy")
    def root(event, late, close, y, new, terms, room, context):
        low, high = 0.0, late
        f_low = value(event, low, y, new, terms, room, context)
        f_high = value(event, high, y, new, terms, room, context)
        if f_low <= 0.0:
            return low
        if f_high >= 0.0:
            return high
        side = 0
        for _ in range(100):
            x = (low * f_high - high * f_low) / (f_high - f_low)
            f = value(event, x, y, new, terms, room, context)
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

    return root


def settle_of(mechanism: Mechanism, method: Method):
    """What a step crossed: the fraction at which the method must start afresh or stop, and by which event (or -1)."""
    interpolant, at, root = method.interpolant, method.at, root_of(mechanism, method)
    contacts, active = mechanism.contacts, mechanism.active
    forces, watch_along = mechanism.forces, mechanism.watch_along
    top, events = contacts + 2, 2 * contacts + 2

    @njit(error_model="numpy")
    def settle(t, h, y, new, before, now, best, terms, room, work, context):
        interpolant(y, h, new, context, terms, work)
        late, halt = 1.0, -1
        for event in range(top):
            if fell(event, before, now) and (event >= contacts or context[active + event] == 0.0):
                x = root(event, late, ROOT / h, y, new, terms, room, context)
                if halt < 0 or x < late:
                    late, halt = x, event
        for event in range(top, events):
            if fell(event, before, now):
                x = root(event, 1.0, TOP_ROOT / h, y, new, terms, room, context)
                if halt < 0 or x < late:
                    at(x, y, new, terms, room[0])
                    force = forces(room[0], context)[event - top]
                    if force > best[PEAK]:
                        best[PEAK], best[TIME], best[CONTACT] = force, t + x * h, event - top
        if halt >= 0:
            at(late, y, new, terms, room[0])
            new[:] = room[0]
            watch_along(new, new, now, context)  # distances alone count
        return late, halt

    return settle


def worth_a_look_of(mechanism: Mechanism):
    """Which steps are looked at more closely."""
    contacts, active, forces = mechanism.contacts, mechanism.active, mechanism.forces
    top, events = contacts + 2, 2 * contacts + 2

    @njit(error_model="numpy")
    def worth_a_look(h, y, new, before, now, best, context):
        """Whether a step crossed anything but a release, or a top that the tangents at its ends show to be a low
        one."""
        for event in range(top):
            if fell(event, before, now) and (event >= contacts or context[active + event] == 0.0):
                return True
        for event in range(top, events):
            if fell(event, before, now):
                left = forces(y, context)[event - top] + before[event] * h
                right = forces(new, context)[event - top] - now[event] * h
                if max(left, right) >= HOPELESS * best[PEAK]:
                    return True
        return False

    return worth_a_look


def loop_of(mechanism: Mechanism, method: Method):
    """The compiled loop of a method for a mechanism."""
    step, workspace, settle = method.step, method.workspace, settle_of(mechanism, method)
    terms_of, power, slopes = method.terms, -1.0 / method.order, method.stages  # those that locate events are few
    states, contacts, active, slope_into, watch_along, *_ = mechanism
    events, meet, worth_a_look = 2 * contacts + 2, meet_of(mechanism), worth_a_look_of(mechanism)

    @njit(error_model="numpy")
    def loop(y, context, duration, rtol, atol):
        """Outcome, end, best (3,), touchdowns, steps and slopes of one capture; ``y`` and ``context`` are altered."""
        work, terms, best = workspace(), np.empty((terms_of, states)), np.zeros(3)
        slope, new, new_slope = np.empty(states), np.empty(states), np.empty(states)
        before, now = np.empty(events), np.empty(events)
        room = (np.empty(states), np.empty(states), np.empty(events))
        t, h, fresh, rejected, anew = 0.0, CONTACT_STEP, True, False, True
        impacts, steps, attempts = int(np.sum(context[active : active + contacts])), 0, 0  # it may start in contact
        while t < duration:
            if fresh:
                slope_into(y, slope, context)
                watch_along(y, slope, before, context)
                # The event just met stands at zero give or take a rounding: it lies behind.
                before[:contacts] = np.maximum(before[:contacts], 1e-300)
                h, fresh, anew = CONTACT_STEP, False, True
            h = min(h, duration - t)
            error = step(y, slope, h, rtol, atol, anew, context, new, new_slope, work)
            attempts, anew = attempts + 1, False
            if not error < 1.0:
                h *= LEAST if math.isnan(error) else max(LEAST, SAFETY * error**power)
                rejected = True
                if h < SHORTEST:
                    return FAILED, t, best, impacts, steps, attempts * slopes
                continue
            most = 1.0 if rejected else MOST
            factor = min(most, max(LEAST, SAFETY * error**power)) if error > 0.0 else most
            rejected, anew = False, True
            steps += 1
            watch_along(new, new_slope, now, context)
            late, halt, changed = 1.0, -1, False
            if worth_a_look(h, y, new, before, now, best, context):
                late, halt = settle(t, h, y, new, before, now, best, terms, room, work, context)
            for event in range(contacts):
                if event != halt and fell(event, before, now):
                    impacts += meet(event, new, context)
                    changed = True
            t += late * h
            y, new = new, y
            if halt >= contacts:
                return halt - contacts + 1, t, best, impacts, steps, attempts * slopes
            if halt >= 0:
                impacts += meet(halt, y, context)
                fresh = True
                continue
            slope, new_slope = new_slope, slope
            before, now = now, before
            if changed:
                watch_along(y, slope, before, context)
            h *= factor
        return 0, t, best, impacts, steps, attempts * slopes

    return loop


@njit(inline="always")
def approach(flank: int, y: Vector, context: Vector) -> float:
    """How fast a flank's gap closes [m/s]."""
    return -both_gaps(y, context[0:30])[2 + flank]


PLANE = Mechanism(
    states=STATES,
    contacts=2,
    active=ACTIVE.start,
    slope_into=slope_into,
    watch_along=watch_along,
    forces=forces,
    approach=approach,
)
METHODS = {"dop853": dop853_of(STATES, slope_into), "rodas4": RODAS4}
LOOPS = {name: loop_of(PLANE, method) for name, method in METHODS.items()}


def capture(method: str, parameters: Parameters, rtol: float, atol: float | Vector) -> PeerCapture:
    """One capture by a ``method`` of this folder."""
    y, context = context_of(parameters)
    allowed = np.full(STATES, atol) if np.ndim(atol) == 0 else np.asarray(atol)
    code, end, best, impacts, steps, slopes = LOOPS[method](y, context, parameters.duration, rtol, allowed)
    flank = ("lower", "upper")[int(best[CONTACT])]
    return PeerCapture(OUTCOMES[code], end, float(best[PEAK]), float(best[TIME]), flank, impacts, steps, slopes)


dop853 = partial(capture, "dop853")
rodas4 = partial(capture, "rodas4")
