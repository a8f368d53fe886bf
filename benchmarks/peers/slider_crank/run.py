"""A run from event to event: touchdown, release, the clamp of the force at zero; its impacts with their peaks.

An event is located by stepping onto it: the step from the same start is repeated with the length that a bracketing
secant asks for, so that no interpolation enters.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .compiled import njit
from .dop853 import STAGES, error, factor, step
from .model import (
    BRACKET,
    DEPTH,
    FORCE,
    FORCE_RATE,
    FREE,
    PARTING,
    PRESSING,
    RATE,
    SLOWEST_TOUCHDOWN,
    STATES,
    Vector,
    evaluate,
    start,
)
from .parameters import SliderCrank, completed

CONTACT_STEP = 1e-7  # [s] first step after an event
LONGEST = 2e-5  # [s] no step is longer: 0.6 degrees of a crank at 5000 rpm
COLUMNS = 9  # of the log: joint, touchdown, approach, crank angle, peak, its time, release, its rate, longest slip
MODES = slice(STATES + 1, STATES + 3)  # places in a row of the course
MEMORY = slice(STATES + 3, STATES + 5)


@njit
def root(y, h, joint, what, sign, modes, memory, p, k, joints) -> float:
    """Length [s] of the step from ``y`` at whose end ``sign * joints[joint, what]`` just falls to or below zero."""
    early, late = 0.0, h
    evaluate(y, modes, memory, p, k[0], joints)
    f_early = sign * joints[joint, what]
    step(y, h, modes, memory, p, k, joints)
    f_late = sign * joints[joint, what]
    side = 0
    for _ in range(200):
        if late - early <= 1e-15 * h or f_late == 0.0:
            break
        middle = (early * f_late - late * f_early) / (f_late - f_early)
        if not early < middle < late:
            middle = 0.5 * (early + late)
        step(y, middle, modes, memory, p, k, joints)
        value = sign * joints[joint, what]
        if value > 0.0:
            early, f_early = middle, value
            if side == 1:
                f_late *= 0.5
            side = 1
        else:
            late, f_late = middle, value
            if side == -1:
                f_early *= 0.5
            side = -1
    return late


@njit
def first_event(y, h, before, after, modes, memory, p, k, joints):
    """Earliest event within the step: its length [s], joint, and new mode; joint -1 where there is none."""
    first, which, turned = h, -1, FREE
    for joint in range(2):
        if (p.crank_pin if joint == 0 else p.piston_pin) == 0.0:
            continue
        closed = modes[joint] != FREE
        out = 1.0 if closed else -1.0  # sign with which the depth falls to zero at the event
        low, high = out * before[joint, DEPTH], out * after[joint, DEPTH]
        late = -1.0
        if low > 0.0 and high <= 0.0:
            late = h
        elif low > 0.0 and out * before[joint, RATE] < 0.0 < out * after[joint, RATE]:
            turn = root(
                y, h, joint, RATE, -out, modes, memory, p, k, joints
            )  # where the pins come nearest to the event
            step(y, turn, modes, memory, p, k, joints)
            late = turn if out * joints[joint, DEPTH] <= 0.0 else -1.0
        if late > 0.0:
            at = root(y, late, joint, DEPTH, out, modes, memory, p, k, joints)
            if which < 0 or at < first:
                first, which, turned = at, joint, (FREE if closed else PRESSING)
        sign = 1.0 if modes[joint] == PRESSING else -1.0
        if closed and sign * before[joint, BRACKET] > 0.0 and sign * after[joint, BRACKET] <= 0.0:
            at = root(y, h, joint, BRACKET, sign, modes, memory, p, k, joints)
            if which < 0 or at < first:
                first, which, turned = at, joint, (PARTING if modes[joint] == PRESSING else PRESSING)
    return first, which, turned


@njit
def note_peaks(t, y, h, before, after, modes, memory, p, k, joints, log, current) -> None:
    """Enter the largest force within the step in the log, where the force turns from rising to falling."""
    for joint in range(2):
        row = current[joint]
        if modes[joint] != PRESSING or row < 0:
            continue
        if before[joint, FORCE_RATE] > 0.0 and after[joint, FORCE_RATE] <= 0.0:
            at = root(y, h, joint, FORCE_RATE, 1.0, modes, memory, p, k, joints)
            step(y, at, modes, memory, p, k, joints)
            if joints[joint, FORCE] > log[row, 4]:
                log[row, 4], log[row, 5] = joints[joint, FORCE], t + at


@njit
def keep(row, t, y, modes, memory) -> None:
    """Write the start of a step into a row of the course."""
    row[0] = t
    row[1 : STATES + 1] = y
    row[STATES + 1 : STATES + 3] = modes
    row[STATES + 3 : STATES + 5] = memory


@njit
def release(joint, t, after, log, current) -> None:
    """End a joint's impact in the log."""
    log[current[joint], 6], log[current[joint], 7] = t, after[joint, RATE]
    current[joint] = -1


@njit
def release_grazes(met, t, before, after, modes, log, current) -> None:
    """Release what has grazed: where rounding at the touchdown hid the release. ``met``: the joint of the event."""
    for joint in range(2):
        pressing = modes[joint] != FREE and joint != met
        if pressing and after[joint, DEPTH] < 0.0 and after[joint, RATE] < 0.0 and before[joint, DEPTH] <= 0.0:
            modes[joint] = FREE
            release(joint, t, after, log, current)


@njit
def drive(p, y, duration, rtol, log, course, longest):
    """Run until ``duration`` [s] or until the log is full; touchdowns, rows of the course, steps, and time reached.

    ``log`` (touchdowns, 9); ``course`` (rows, 15) gets time, state, modes and memory at the start of each step.
    """
    modes, memory = np.zeros(2), np.full(2, SLOWEST_TOUCHDOWN)
    k, joints = np.empty((STAGES + 1, STATES)), np.zeros((2, 6))
    before, after = np.zeros((2, 6)), np.zeros((2, 6))
    current = np.full(2, -1)
    t, h, touchdowns, steps = 0.0, CONTACT_STEP, 0, 0
    rejected = False
    while t < duration:
        h = min(h, longest, duration - t)
        evaluate(y, modes, memory, p, k[0], before)
        new = step(y, h, modes, memory, p, k, after)
        off = error(h, k, rtol)
        if not off <= 1.0:
            h *= 0.1 if math.isnan(off) else factor(off, True)
            rejected = True
            if h < 1e-16:
                break
            continue
        following = h * factor(off, rejected)
        rejected = False
        taken, joint, turned = first_event(y, h, before, after, modes, memory, p, k, joints)
        if joint >= 0:
            evaluate(y, modes, memory, p, k[0], joints)
            new = step(y, taken, modes, memory, p, k, after)
            following = CONTACT_STEP
        evaluate(y, modes, memory, p, k[0], joints)
        note_peaks(t, y, taken, before, after, modes, memory, p, k, joints, log, current)
        if steps < course.shape[0]:
            keep(course[steps], t, y, modes, memory)
        steps += 1
        for each in range(2):
            if current[each] >= 0 and after[each, FORCE] > 0.0:
                log[current[each], 8] = max(log[current[each], 8], abs(after[each, 5]))
        t, y, h = t + taken, new, following
        if joint >= 0:
            if turned == PRESSING and modes[joint] == FREE:
                if touchdowns == log.shape[0]:
                    break
                memory[joint] = max(after[joint, RATE], SLOWEST_TOUCHDOWN)
                log[touchdowns] = np.array([joint, t, after[joint, RATE], y[0], 0.0, np.nan, np.nan, 0.0, 0.0])
                current[joint] = touchdowns
                touchdowns += 1
            elif turned == FREE:
                release(joint, t, after, log, current)
            modes[joint] = turned
        release_grazes(joint, t, before, after, modes, log, current)
        if touchdowns == log.shape[0] and current[0] < 0 and current[1] < 0:
            break
    return touchdowns, min(steps, course.shape[0]), steps, t, y


class Impact(NamedTuple):
    """One impact, from touchdown to release."""

    joint: int  # 0 crank pin, 1 piston pin
    time: float  # [s] of the touchdown
    approach_speed: float  # [m/s]
    crank_angle: float  # [rad] at the touchdown
    peak_force: float  # [N] largest normal force
    peak_time: float  # [s]
    release_time: float  # [s] nan: still pressing
    separation: float  # [m/s] rate of the depth at the release, negative
    largest_slip: float  # [m/s] at the steps' ends


class Run(NamedTuple):
    """A run: its impacts, and the start of each step (time, state, modes, memory: 15 numbers) as far as asked for."""

    crank: SliderCrank
    log: NDArray[np.float64]  # (impacts, 9)
    course: NDArray[np.float64]  # (rows, 15)
    steps: int
    end_time: float  # [s]
    end_state: Vector  # (10,)

    @property
    def impacts(self) -> list[Impact]:
        return [Impact(int(row[0]), *(float(x) for x in row[1:])) for row in self.log]


def simulate(
    crank: SliderCrank,
    duration: float,
    rtol: float = 1e-12,
    impacts: int = 1000,
    rows: int = 0,
    state: Vector | None = None,
    longest: float = LONGEST,
) -> Run:
    """Run for ``duration`` [s], or until all of so many ``impacts`` are over; the course has at most ``rows`` rows.

    ``state`` (10,), free of contact, replaces the start; ``longest`` [s] bounds the step.
    """
    crank = SliderCrank(*(float(x) for x in completed(crank)))
    log, course = np.zeros((impacts, COLUMNS)), np.zeros((rows, STATES + 5))
    begun = start(crank) if state is None else np.array(state, dtype=float)
    events, points, steps, end, last = drive(crank, begun, float(duration), float(rtol), log, course, float(longest))
    return Run(crank, log[:events], course[:points], steps, end, last)
