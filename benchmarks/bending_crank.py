"""A slider-crank by SciPy's DOP853 with the product's own right-hand side, compiled: what an integrator alone costs.

For rods that bend there are no equations written out by hand. Touchdown and release are events of `solve_ivp`, peaks
are searched on its dense output.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

import jaxbuffer as jb
from jaxbuffer.mechanisms.slider_crank.system import slider_crank

LONGEST, FIRST = 2e-5, 1e-7  # [s] no step is longer, since a contact may come and go within one; the first one
UNWATCHED = 1e3  # scales by which the error in losses and work counts less than that of the motion


class Equations(NamedTuple):
    """A start, its scales, and compiled functions of a state: its rate, depth and force of the contact."""

    start: Float[np.ndarray, " state"]
    scales: Float[np.ndarray, " state"]
    rate: Callable[..., Any]
    depth: Callable[..., Any]
    force: Callable[..., Any]


def equations(design: jb.SliderCrank, scenario: jb.SliderCrankScenario) -> Equations:
    """Of a slider-crank with one pin that has play; its numbers are constants of what is compiled, since handing them
    over at every call would cost more than the call."""

    def rate(state: Float[Array, " state"], active: Float[Array, " 1"]) -> Float[Array, " state"]:
        return slider_crank(design, scenario).derivative(0.0, state, active)

    def depth(state: Float[Array, " state"]) -> tuple[Array, Array]:
        mechanism = slider_crank(design, scenario)
        gap, closing = mechanism.gaps_at(mechanism.evaluate(state))
        return -gap[0], closing[0]

    def force(state: Float[Array, " state"]) -> Array:
        mechanism = slider_crank(design, scenario)
        return mechanism.normal_force_at(mechanism.evaluate(state), jnp.ones(1))[0]

    mechanism = slider_crank(design, scenario)
    compiled = (jax.jit(each) for each in (rate, depth, force))
    return Equations(np.array(mechanism.start()[0]), np.array(mechanism.scales()), *compiled)


def peaks(of: Equations, duration: float, rtol: float) -> Float[np.ndarray, " impacts"]:
    """Peak force of each impact within ``duration`` [s], in order of touchdown [N]."""
    state, scales = of.start.copy(), of.scales.copy()
    coordinates = (len(state) - 6) // 2  # three losses, the drive's work, the time, the memory
    scales[2 * coordinates :] *= UNWATCHED
    t, pressing, values = 0.0, False, []
    while t < duration:
        active = np.array([float(pressing)])

        def crossing(_: float, y: np.ndarray) -> float:
            return float(of.depth(y)[0])

        crossing.terminal, crossing.direction = True, -1.0 if pressing else 1.0  # type: ignore[attr-defined]
        piece = solve_ivp(
            lambda _, y, active=active: np.asarray(of.rate(y, active)),
            (t, duration),
            state,
            "DOP853",
            events=[crossing],
            dense_output=True,
            rtol=max(rtol, 3e-14),
            atol=rtol * scales,
            first_step=min(FIRST, duration - t),
            max_step=LONGEST,
        )
        if pressing:
            values.append(largest(of, piece))
        t, state = piece.t[-1], piece.y[:, -1].copy()
        if len(piece.t_events[0]):
            pressing = not pressing
            if pressing:
                state[-1] = max(float(of.depth(state)[1]), 1e-5)
    return np.array(values)


def largest(of: Equations, piece: Any) -> float:
    """Largest force on the dense output of a ``piece`` in contact [N]."""
    forces = [float(of.force(y)) for y in piece.y.T]
    top = int(np.argmax(forces))
    low, high = piece.t[max(top - 1, 0)], piece.t[min(top + 1, len(piece.t) - 1)]
    inside = minimize_scalar(
        lambda t: -float(of.force(piece.sol(t))),
        bounds=(low, high),
        method="bounded",
        options={"xatol": 1e-12},
    )
    return max(forces[top], -float(inside.fun))
