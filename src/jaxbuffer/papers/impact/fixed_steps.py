"""The rigid bar's first contact by backward differences of the second order at a fixed step, GSTIFF's kind."""

import math
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.integrate import solve_ivp
from scipy.optimize.elementwise import find_root

from ...mechanisms.bar_drop import BarDrop, BarDropScenario

BEGINNINGS = 20  # of grids, evenly over a step
FOLLOWED = 3e-4  # s from the touch at least, and ten steps
ACROSS = 1e-3  # rad to either side of the angle without contact, where the next one is searched


def peaks(design: BarDrop, scenario: BarDropScenario, step: float) -> Float[np.ndarray, " beginnings"]:
    """Return the largest force [N] that each grid of times a ``step`` [s] apart computes.

    With α, ω and φ of the new instant, ω = (3φ - 4φ₁ + φ₂)/2h and α = (3ω - 4ω₁ + ω₂)/2h solve
    m l²/3 α + m g l/2 cos φ = F l cos φ with F = max(0, k δ^e + c STEP(δ) δ̇) and δ = -l sin φ.
    """
    length, gravity = float(design.bar.length), float(scenario.gravity)
    weight = 1.5 * gravity / length  # 1/s²
    inertia = float(design.bar.mass) * length**2 / 3.0

    def fallen(_: float, y: Any) -> list[float]:
        return [y[1], -weight * math.cos(y[0])]

    def touch(_: float, y: Any) -> float:
        return float(y[0])

    touch.terminal = True  # type: ignore[attr-defined]
    start = [math.asin(float(scenario.height) / length), 0.0]
    # The grids begin on the exact fall, so that only the contact is wrong in them.
    fall = solve_ivp(fallen, (0.0, 2.0), start, events=touch, rtol=1e-11, atol=1e-14, dense_output=True)
    # Where the instants of a grid lie about the touch is chance, so many beginnings are tried.
    begin = fall.t[-1] - step * (1.0 + np.linspace(0.0, 1.0, BEGINNINGS, endpoint=False))
    (last, spin), (before, spin_before) = fall.sol(begin), fall.sol(begin - step)
    largest = np.zeros(BEGINNINGS)

    def rate(now: Any, old: Any, older: Any) -> Any:
        return (3.0 * now - 4.0 * old + older) / (2.0 * step)

    def pushed(angle: Any, turning: Any) -> Any:
        return force_of(design, -length * np.sin(angle), -length * np.cos(angle) * turning)

    def residual(angle: Any, last: Any, before: Any, spin: Any, spin_before: Any) -> Any:
        turning = rate(angle, last, before)
        acceleration = rate(turning, spin, spin_before) + weight * np.cos(angle)
        return inertia * acceleration - pushed(angle, turning) * length * np.cos(angle)

    # A grid begins up to two steps before the touch.
    for _ in range(2 + max(10, math.ceil(FOLLOWED / step))):
        free = (4.0 * spin - spin_before - 2.0 * step * weight) / 3.0  # without contact
        ahead = (4.0 * last - before + 2.0 * step * free) / 3.0
        # Without contact the new angle would be `ahead`; contact moves it towards zero, where the force ends.
        bracket = ahead - ACROSS, np.maximum(ahead, 0.0) + ACROSS
        angle = find_root(residual, bracket, args=(last, before, spin, spin_before)).x
        turning = rate(angle, last, before)
        largest = np.maximum(largest, pushed(angle, turning))
        last, before, spin, spin_before = angle, last, turning, spin
    return largest


def force_of(design: BarDrop, depth: Any, closing: Any) -> Any:
    """Return IMPACT [N] of the depth [m] and its rate [m/s]."""
    spring, damper = components(design, depth, closing)
    # As the ball leaves, the damper alone would pull it back; IMPACT never pulls.
    return np.maximum(0.0, spring + damper)


def components(design: BarDrop, depth: Any, closing: Any, printed: bool = False) -> tuple[Any, Any]:
    """Return F₁ = k δ^e and F₂ = c STEP(δ) δ̇ [N]. ``printed``: with the printed a = c in place of a = -c, so that the
    damping is 2 c at the touch and falls to c."""
    impact, deep = design.impact, np.maximum(depth, 0.0)
    share = np.clip(deep / float(impact.ramp_depth), 0.0, 1.0)
    risen = share**2 * (3.0 - 2.0 * share)
    damping = float(impact.damping) * (2.0 - risen if printed else risen)
    return float(impact.stiffness) * deep ** float(impact.exponent), damping * closing * (deep > 0.0)
