"""A latch that fits: it pulls the tip in with little energy, holds the vehicles in time, and stays under a strength."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ....fields import replace
from ....value_text import percent_text
from ...sizing import ClosedForm, SizedNumber, SizedParts, TradeOff
from .buffer import SPAN, check_linear
from .encounter import Encounter, encounter
from .oscillator import SpringsInARow, at_rest_after
from .rules import GROWING, closing_time, damping_for, pull_stiffness, turn_stiffness
from .wishes import DockingWishes

RATIOS = np.linspace(0.45, 0.9, 10)  # damping ratios of the row of latch and buffer, the usual one first
TURN_RATIOS = np.linspace(0.7, 0.9, 5)  # of the turn
PULL = 0.5  # of the energy that may be put in, what pulls the tip in; the rest turns the probe
USED = 0.9  # of the largest force that is wished, which impacts before and rebounds after may exceed by a tenth
SOFTEST = 1e-4  # of the stiffness that the energy allows, where one is sought that a force allows
HALVINGS = 40  # of that range on a logarithmic scale: to eleven digits


def size_latch(design: Any, scenarios: Sequence[Any], **wishes: Any) -> SizedParts:
    """Return the latch that fits some scenarios, behind the design's buffer (M185, M187).

    Of the energy that it may put in, half pulls the tip to its seat: k = ½ w μ v²/(r² + 0.3 (v τ)²), with the slowest
    speed v, the largest miss r and the closing time τ, in which the tip goes on; half turns the probe onto the axis:
    k_t = ½ w μ v²/φ². Both are upper bounds, whatever the damping. A damping ratio of 0.45 or, where that is too slow,
    of up to 0.9 lets the reduced mass come to rest on buffer and latch in a row; one of 0.7 to 0.9 the turn of the
    vehicles about the tip.

    **Arguments:**

    - ``design``: in the plane or in space; what is not sized is kept.
    - ``scenarios``: in which it docks.
    - ``wishes``: ``settling_time`` [s], within which the vehicles are held after latching (default: what comes of the
      rest); ``latch_energy_share`` [-] (default 0.1); ``peak_latch_force`` [N] (default: the latch's strength, if it
      has one).

    **Returns:** `SizedParts`, whose ``design`` has the latch; ``remarks`` say which wishes stand in each other's way.

    **Raises:** `InputError` for a buffer with a measured curve, and no scenario.

    **Example:**

    >>> scenarios = [jb.Scenario(approach_speed=speed) for speed in (0.05, 0.15)]
    >>> sized = jb.size_latch(jb.table2(), scenarios, latch_energy_share="8 %")
    >>> latch = sized.design.latch
    >>> print(f"{latch.stiffness:.1f} N/m, {latch.damping:.1f} N s/m, {latch.turn_stiffness:.3f} N m/rad")
    30.3 N/m, 18.5 N s/m, 0.049 N m/rad
    """
    return latch_for(design, encounter(design, scenarios), DockingWishes(**wishes))


def latch_for(design: Any, met: Encounter, wishes: DockingWishes) -> SizedParts:
    """Return the latch that fits an encounter and wishes."""
    check_linear(design)
    if design.latch.has("strength") and not wishes.has("peak_latch_force"):
        wishes = dataclasses.replace(wishes, peak_latch_force=float(design.latch.strength))
    share, quiet = float(wishes.latch_energy_share), float(design.latch.quiet)
    closing = closing_time(float(design.probe.tip_radius), met.slowest)
    depth = float(design.latch.depth)
    most = pull_stiffness(met.mass, met.slowest, math.hypot(met.miss, depth), closing, PULL * share)
    stiffness, ratio = _stiffness_and_ratio(design, met, wishes, most)
    why = f"½ k r² and what closing in {closing:.3g} s adds are {percent_text(PULL * share)} of ½ μ v²"
    if stiffness < most:
        why = f"{percent_text(USED)} of the largest force, on buffer and latch"
    turning, turn_why = turn_stiffness(met.mass, met.slowest, met.angle, (1.0 - PULL) * share)
    turn_ratio = _turn_ratio(met, turning, wishes.settling_time, quiet)
    inertia = met.turn_inertia
    numbers = (
        SizedNumber("latch.stiffness", stiffness, why),
        SizedNumber("latch.damping", _damping(design, met, stiffness, ratio), f"ζ = {ratio:.2g} with the buffer"),
        SizedNumber("latch.turn_stiffness", turning, turn_why),
        SizedNumber(
            "latch.turn_damping", damping_for(turn_ratio, turning, inertia), f"ζ = {turn_ratio:.2g} of the turn"
        ),
        SizedNumber("latch.closing_time", closing, "the tip goes half of its radius on meanwhile"),
    )
    sized = replace(design, {it.path: it.value for it in numbers})
    estimates = latch_estimates(sized, met, wishes)
    remarks = _in_the_way(estimates, stiffness < most)
    return SizedParts(design, sized, numbers, estimates, [latch_trade_off(sized, met, wishes, ratio)], remarks)


def _row(design: Any, met: Encounter, stiffness: float, damping: float) -> SpringsInARow:
    buffer = design.buffer
    return SpringsInARow(met.mass, float(buffer.k_A), float(buffer.c_A), stiffness, damping)


def _damping(design: Any, met: Encounter, stiffness: float, ratio: float) -> float:
    """Return the latch's damping with which buffer and latch in a row have a damping ratio, to first order [N s/m]."""
    soft, its = float(design.buffer.k_A), float(design.buffer.c_A)
    # Each takes a share of the displacement, and loses by its square.
    of_buffer, of_latch = stiffness / (soft + stiffness), soft / (soft + stiffness)
    both = damping_for(ratio, stiffness * of_latch, met.mass)
    return max(both - its * of_buffer**2, 0.05 * both) / of_latch**2


def _stiffness_and_ratio(design: Any, met: Encounter, wishes: DockingWishes, most: float) -> tuple[float, float]:
    """Return the stiffness, up to ``most``, that a force allows, and the smallest damping ratio that is quick enough
    with it; the quickest ratio where none is."""
    within, left = wishes.settling_time, float(design.latch.quiet) / (1.0 + float(wishes.latch_energy_share))
    quickest = (math.inf, most, float(RATIOS[0]))
    for ratio in map(float, RATIOS):
        stiffness = most
        if wishes.has("peak_latch_force"):
            stiffness = _stiffness_for_force(design, met, USED * float(wishes.peak_latch_force), most, ratio)
        if within is None:
            return stiffness, ratio
        time = _row(design, met, stiffness, _damping(design, met, stiffness, ratio)).arrest(left).at_rest
        if time <= float(within):
            return stiffness, ratio
        quickest = min(quickest, (time, stiffness, ratio))
    return quickest[1:]


def _turn_ratio(met: Encounter, turning: float, within: Any, quiet: float) -> float:
    times = [_turn_time(met, turning, float(it), quiet) for it in TURN_RATIOS]
    quick = [k for k, time in enumerate(times) if within is None or time <= float(within)]
    return float(TURN_RATIOS[quick[0] if quick else int(np.argmin(times))])


def _turn_time(met: Encounter, turning: float, ratio: float, quiet: float) -> float:
    """Return when the turn that the latch put in is at rest [s]."""
    put_in = turning * met.angle**2 / (met.mass * met.slowest**2)
    frequency = math.sqrt(turning / met.turn_inertia)
    return at_rest_after(ratio, frequency, min(quiet / put_in, 1.0)) if put_in > 0.0 else 0.0


def _force(design: Any, met: Encounter, stiffness: float, damping: float) -> float:
    """Return the latch's largest force [N]: along the axis, of the fastest approach, and across it, of the miss."""
    along = met.fastest * _row(design, met, stiffness, damping).arrest(0.1).force
    return math.hypot(along, stiffness * met.miss)


def _stiffness_for_force(design: Any, met: Encounter, force: float, most: float, ratio: float) -> float:
    """Return the largest stiffness up to ``most`` whose force is at most so large, by halving [N/m]."""

    def too_much(stiffness: float) -> bool:
        return _force(design, met, stiffness, _damping(design, met, stiffness, ratio)) > force

    if not too_much(most):
        return most
    low, high = SOFTEST * most, most
    for _ in range(HALVINGS):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if too_much(middle) else (middle, high)
    return low


def latch_estimates(design: Any, met: Encounter, wishes: DockingWishes) -> tuple[ClosedForm, ...]:
    """Return what closed forms say of a design's latch."""
    latch, share = design.latch, float(wishes.latch_energy_share)
    stiffness, damping, turning = (float(it) for it in (latch.stiffness, latch.damping, latch.turn_stiffness))
    row = _row(design, met, stiffness, damping).arrest(float(latch.quiet) / (1.0 + share))
    ratio = float(latch.turn_damping) / (2.0 * math.sqrt(turning * met.turn_inertia))
    turn = _turn_time(met, turning, min(ratio, 0.999), float(latch.quiet))
    slower = "the vehicles on buffer and latch" if row.at_rest >= turn else "the turn about the tip"
    wished = [None if it is None else float(it) for it in (wishes.settling_time, wishes.peak_latch_force)]
    return (
        ClosedForm("settling_time", max(row.at_rest, turn), "s", wished[0], f"rest of {slower}"),
        ClosedForm(
            "latch_energy_share", _put_in(design, met, stiffness), "-", share, "½ k (r² + 0.3 (v τ)²) + ½ k_t φ²"
        ),
        ClosedForm(
            "peak_latch_force", _force(design, met, stiffness, damping), "N", wished[1], "fast approach, and k r"
        ),
    )


def _put_in(design: Any, met: Encounter, stiffness: float) -> float:
    """Return the share of the slowest approach's energy that closing puts in at most [-]."""
    latch = design.latch
    square = met.miss**2 + float(latch.depth) ** 2 + GROWING * (met.slowest * float(latch.closing_time)) ** 2
    return (stiffness * square + float(latch.turn_stiffness) * met.angle**2) / (met.mass * met.slowest**2)


def latch_trade_off(design: Any, met: Encounter, wishes: DockingWishes, ratio: float) -> TradeOff:
    """Return how energy, force and time go with the latch's stiffness, at one damping ratio."""
    values = float(design.latch.stiffness) * SPAN
    quantities = dict[str, list[float]]()
    for stiffness in map(float, values):
        damping = _damping(design, met, stiffness, ratio)
        other = replace(design, {"latch.stiffness": stiffness, "latch.damping": damping})
        for it in latch_estimates(other, met, wishes):
            quantities.setdefault(it.quantity, []).append(it.value)
    return TradeOff("latch.stiffness", values, {name: np.array(it) for name, it in quantities.items()})


def _in_the_way(estimates: Sequence[ClosedForm], by_force: bool) -> list[str]:
    """Return a line where the vehicles are not held in time, with what keeps the latch soft."""
    time = estimates[0]
    if time.kept or time.limit is None:
        return []
    keeps, less = ("peak_latch_force", "") if by_force else ("latch_energy_share", ", or miss by less")
    if "turn" in time.rule:
        keeps, less = "latch_energy_share", ", or turn by less"
    return [
        f"held after {time.value:.3g} s for the {time.limit:.3g} s wished: {keeps} keeps the latch soft; allow more of"
        f" it or more time{less}"
    ]
