"""The floor of the peak contact force: the first impact, which no buffer softens.

A Hertz impact of the effective mass that the joints leave at the tip, F = K^{2/5} (5 T/2)^{3/5} with
T = ½ v²/(A M_c⁻¹ Aᵀ), is over before a spring or damper has moved: it sets the peak of a buffer gone soft. Friction
and hysteresis lower it by some per cent; so the floor itself is the first impact *simulated* with the buffer taken
away, and the closed form stands beside it and says what it is made of.
"""

import dataclasses
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..mechanisms import CaptureMechanism, Design, Scenario, get, replace
from ..mechanisms.assembly import LOWER, N
from .evaluation import measure
from .problem import Problem

GONE = 1e-6  # what is left of the buffer's springs and dampers
BUFFER = ("buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T")
DURATIONS = 4.0  # of an undamped Hertz impact, 2.943 δ/v each
SHARPER = 0.1  # of the problem's tolerance


class FirstImpact(NamedTuple):
    """``energy`` T_c⁻ [J], ``mass`` effective at the tip [kg], ``peak`` by the closed form [N], ``duration`` [s]."""

    energy: Float[Array, ""]
    mass: Float[Array, ""]
    peak: Float[Array, ""]
    duration: Float[Array, ""]


def first_impact(design: Design, scenario: Scenario) -> FirstImpact:
    """The frictionless elastic first impact in closed form; differentiable (Hertz; seed 002 for T_c⁻)."""
    mechanism = CaptureMechanism(design, scenario)
    state, _ = mechanism.start()
    kin = mechanism.kinematics(state)

    def speed(v: Array) -> Array:
        moved = jnp.concatenate([state[:N], v, state[2 * N :]])
        return mechanism.approach(mechanism.kinematics(moved), moved).approach_speed[LOWER]

    approach, row = jax.value_and_grad(speed)(kin.v)
    response = mechanism.system.response(kin, row[:, None])[:, 0]
    mass = 1.0 / jnp.sum(row * response)
    energy, stiffness = 0.5 * mass * approach**2, jnp.asarray(design.contact_stiffness)
    depth = (2.5 * energy / stiffness) ** 0.4
    return FirstImpact(energy, mass, stiffness**0.4 * (2.5 * energy) ** 0.6, 2.943275 * depth / approach)


@dataclasses.dataclass(frozen=True)
class Floor:
    """A lower limit of the first impact's peak in each case [N]: ``simulated`` without a buffer, and ``closed_form``,
    elastic and frictionless; ``energy`` T_c⁻ [J]; ``lowest``: the least that the objective's first impacts can be
    within the variables' bounds [N], and the numbers that reach it."""

    simulated: Float[np.ndarray, " cases"]
    closed_form: Float[np.ndarray, " cases"]
    energy: Float[np.ndarray, " cases"]
    lowest: float
    at: dict[str, float]


def floor(problem: Problem, places: Float[np.ndarray, " variables"]) -> Floor:
    """The floor at a design, and the lowest one within the bounds."""
    from scipy.optimize import minimize

    def objective(where: np.ndarray) -> tuple[float, np.ndarray]:
        peaks, slopes = _without_buffer(problem, where)
        weights = problem.objective.case_weights(peaks)
        return float(weights @ peaks), weights @ slopes

    found = minimize(objective, places, jac=True, bounds=[(0.0, 1.0)] * len(places), method="L-BFGS-B", tol=1e-6)
    closed = [_closed_form(case.of(problem.built(places)), case.scenario) for case in problem.cases]
    at = dict(zip(problem.paths, map(float, problem.values(found.x)), strict=True))
    return Floor(
        _without_buffer(problem, places)[0],
        np.array([float(c.peak) for c in closed]),
        np.array([float(c.energy) for c in closed]),
        float(found.fun),
        {path: value for path, value in at.items() if path not in BUFFER},
    )


_closed_form = jax.jit(first_impact)


def _without_buffer(problem: Problem, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First peaks [N] of all cases with the buffer gone, and their slopes by the places."""
    drawn, values = problem.built(places), problem.values(places)
    peaks, slopes = [], []
    for case in problem.cases:
        built = case.of(drawn)
        design = replace(built, {path: GONE * float(get(built, path)) for path in BUFFER})
        duration = DURATIONS * float(_closed_form(built, case.scenario).duration)
        found = measure(design, case.scenario, problem.paths, duration, SHARPER * problem.rtol)
        factors = dict(case.factors)
        scale = [
            v.slope(float(x)) * factors.get(v.path, 1.0) * (v.path not in BUFFER)
            for v, x in zip(problem.variables, values, strict=True)
        ]
        peaks.append(float(found.peaks[0]))
        slopes.append(found.peaks_slope[0] * np.array(scale))
    return np.array(peaks), np.array(slopes)
