"""A buffer that fits: its spring by the stroke of the fastest approach, its damper, and its stops."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ....errors import InputError
from ....fields import replace
from ...sizing import ClosedForm, SizedNumber, SizedParts, TradeOff
from .encounter import Encounter, encounter
from .oscillator import first_swing, largest_force
from .rules import REBOUND, REBOUND_DAMPING, damping_for
from .wishes import DockingWishes

DAMPING = 0.3  # damping ratio: about where the largest force is least
FREE_STROKE = 0.18  # of the free length, where no stroke is wished
STOP_ROOM = 0.5  # of the stroke, and of the way left behind it, that the end stop takes
STOP_DAMPING = 0.1  # damping ratio of the end stop
SPAN = np.geomspace(0.1, 10.0, 81)  # times a stiffness, in trade-offs


def size_buffer(design: Any, scenarios: Sequence[Any], **wishes: Any) -> SizedParts:
    """Return the buffer that takes the fastest of some scenarios within a stroke, and its stops (M186).

    The spring is that of one mass μ that meets it: k_A = μ (v D/s)², where D is the first swing over v/ω at a damping
    ratio of 0.3, at which the largest force is about least. The tip stands still meanwhile: where it goes on into a
    latch, the stroke is less. The end stop takes what a faster approach has left, in half a stroke or half of the way
    left.

    **Arguments:**

    - ``design``: in the plane or in space; what is not sized is kept.
    - ``scenarios``: in which it docks.
    - ``wishes``: ``stroke`` [m] (default: ``buffer.max_stroke``, or 18 % of the free length), and ``overspeed`` [-]
      (default 1.5): times the fastest approach that the end stop still takes.

    **Returns:** `SizedParts`, whose ``design`` has the buffer.

    **Raises:** `InputError` for a buffer with a measured curve, a stroke beyond the free length, and no scenario.

    **Example:**

    >>> sized = jb.size_buffer(jb.table2(), [jb.Scenario(approach_speed=0.15)], stroke="2 cm")
    >>> print(f"{sized.design.buffer.k_A:.1f} N/m, {1e3 * sized.estimates['stroke'].value:.1f} mm")
    296.3 N/m, 20.0 mm
    """
    return buffer_for(design, encounter(design, scenarios), DockingWishes(**wishes))


def check_linear(design: Any) -> None:
    """Raise `InputError` for a buffer without a stiffness of its own."""
    if not design.buffer.has("k_A") or not design.buffer.has("c_A"):
        raise InputError(
            "buffer.spring_curve or buffer.damper_curve is given: sizing needs a linear buffer; leave the curve out, or"
            " give k_A and c_A that are about the same"
        )


def buffer_for(design: Any, met: Encounter, wishes: DockingWishes) -> SizedParts:
    """Return the buffer that fits an encounter and wishes."""
    check_linear(design)
    stroke, free = _stroke(design, wishes), float(design.buffer.free_length)
    if stroke >= free:
        raise InputError(f"stroke = {stroke:g} m must be below buffer.free_length = {free:g} m")
    stiffness = met.mass * (met.fastest * first_swing(DAMPING) / stroke) ** 2
    damping = damping_for(DAMPING, stiffness, met.mass)
    room = STOP_ROOM * min(stroke, free - stroke)
    fast = float(wishes.overspeed) * met.fastest
    # ½ μ (f v)² = ½ k_A (s + d)² + ½ k_s d², without the dampers.
    left = met.mass * fast**2 - stiffness * (stroke + room) ** 2
    stop = max(left / room**2, stiffness)
    swing = f"{first_swing(DAMPING):.2f}"
    numbers = (
        SizedNumber("buffer.k_A", stiffness, f"μ ({swing} v/s)²: the fastest approach takes the stroke s"),
        SizedNumber("buffer.c_A", damping, f"2 ζ √(k_A μ), ζ = {DAMPING:g}: about the least force"),
        SizedNumber("buffer.max_stroke", stroke, "the stroke, where the end stop begins"),
        SizedNumber(
            "buffer.stop_stiffness", stop, f"takes {float(wishes.overspeed):g} times the speed in {1e3 * room:.3g} mm"
        ),
        SizedNumber("buffer.stop_damping", damping_for(STOP_DAMPING, stop, met.mass), "2 ζ √(k_s μ), ζ = 0.1"),
        SizedNumber("buffer.rebound_stiffness", REBOUND * stiffness, "20 k_A: it does not pull after capture"),
        SizedNumber("buffer.rebound_damping", REBOUND_DAMPING * damping, "2 c_A"),
    )
    sized = replace(design, {it.path: it.value for it in numbers})
    return SizedParts(design, sized, numbers, buffer_estimates(sized, met, stroke), [buffer_trade_off(sized, met)])


def _stroke(design: Any, wishes: DockingWishes) -> float:
    if wishes.has("stroke"):
        return float(wishes.stroke)
    buffer = design.buffer
    return float(buffer.max_stroke) if buffer.has("max_stroke") else FREE_STROKE * float(buffer.free_length)


def buffer_estimates(design: Any, met: Encounter, stroke: float | None) -> tuple[ClosedForm, ClosedForm]:
    """Return stroke and force of a buffer that takes the fastest approach, the tip standing still."""
    ratio, swing, force = _taken(float(design.buffer.k_A), float(design.buffer.c_A), met)
    return (
        ClosedForm("stroke", swing, "m", stroke, f"first swing at ζ = {ratio:.2g}, tip still"),
        ClosedForm("peak_buffer_force", force, "N", None, "largest deceleration, tip still"),
    )


def _taken(stiffness: float, damping: float, met: Encounter) -> tuple[float, float, float]:
    """Return the damping ratio [-], the stroke [m] and the largest force [N]."""
    frequency = math.sqrt(stiffness / met.mass)
    ratio = min(damping / (2.0 * met.mass * frequency), 0.999)
    force = met.fastest * met.mass * frequency * largest_force(ratio)
    return ratio, met.fastest / frequency * first_swing(ratio), force


def buffer_trade_off(design: Any, met: Encounter) -> TradeOff:
    """Return how stroke and force go with k_A, at the damping ratio of the design."""
    buffer = design.buffer
    taken = [_taken(float(buffer.k_A) * x, float(buffer.c_A) * math.sqrt(x), met)[1:] for x in SPAN]
    strokes, forces = np.array(taken).T
    return TradeOff("buffer.k_A", float(buffer.k_A) * SPAN, {"stroke": strokes, "peak_buffer_force": forces})
