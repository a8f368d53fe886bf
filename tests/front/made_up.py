"""Captures and tunings made up in a moment: what the front shows of them needs no simulation."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxbuffer import Outcome, Scenario, get, replace, table2
from jaxbuffer.capture import Capture
from jaxbuffer.certificate import Certificate, Peaks, Verdict
from jaxbuffer.first_impact import FirstImpact
from jaxbuffer.history import History
from jaxbuffer.integrate import Log
from jaxbuffer.metrics import Balance, Energy, Impacts
from jaxbuffer.sensitivity import PARAMETERS, QUANTITIES, Sensitivity
from jaxbuffer.sweep import Sweep
from jaxbuffer.tune import Iteration, Problem, Tuned

STEPS = 400
END = 0.04  # s
PULSE = 3e-3  # s


def made_up_capture(scenario=None, peak=250.0, at=0.02, outcome=Outcome.captured, design=None) -> Capture:
    """Half a sine on the upper flank, linear motion, constant energy."""
    design, scenario = design or table2(), scenario or Scenario()
    time = np.linspace(0.0, END, STEPS)
    force = np.zeros((STEPS, 2))
    inside = np.abs(time - at) < PULSE / 2
    force[inside, 1] = peak * np.cos(np.pi * (time[inside] - at) / PULSE)
    ramp = time / END
    shares = (1.0 - ramp, 0.2 * ramp, 0 * ramp, 0.3 * ramp, 0.2 * ramp, 0.1 * ramp, 0.2 * ramp)
    energy = Energy(*(jnp.asarray(share) for share in shares))
    two, bodies = np.zeros((STEPS, 2)), np.zeros((STEPS, 4, 3))
    history = History(
        **{name: jnp.asarray(value) for name, value in {
            "time": time, "position": bodies, "velocity": bodies, "tip_spin": ramp, "multipliers": np.zeros((STEPS, 4)),
            "gap": 0.01 - two, "approach_speed": two, "slip": two, "contact_force": force,
            "friction_force": 0.3 * force, "hinge_force": force[:, 1], "buffer_force": 4 * ramp,
            "stroke": 0.0075 * ramp, "hinge_angle": -0.004 * ramp, "throat_distance": 0.03 * (1 - ramp),
        }.items()},
        energy=energy,
    )  # fmt: skip
    slots = jnp.zeros(3)
    hits = Impacts(
        time=slots.at[0].set(at - PULSE / 2),
        flank=jnp.array([1, -1, -1]),
        approach_speed=slots.at[0].set(0.07),
        peak_force=slots.at[0].set(peak),
        release_time=slots.at[0].set(jnp.nan),
        count=jnp.asarray(1),
    )
    return Capture(
        **{name: jnp.asarray(value) for name, value in {
            "code": int(outcome), "peak_force": peak, "peak_time": at, "peak_flank": 1, "peak_impact": 0,
            "peak_hinge_force": 1.5 * peak, "peak_buffer_force": 4.0, "stroke": 0.0075, "hinge_angle": 0.004,
            "end_time": END, "contact_time": PULSE, "impact_count": 1, "throat_distance": 0.0, "capture_margin": 0.3,
            "attempts": STEPS + 20, "accepted": STEPS,
        }.items()},
        design=design,
        scenario=scenario,
        impacts=hits,
        first_impact=FirstImpact(*(jnp.asarray(x) for x in (0.2, 5e-4, 150.0, 143.0))),
        energy=Energy(*(getattr(energy, name)[-1] for name in energy.__dataclass_fields__)),
        balance=Balance(*(jnp.asarray(1e-9) for _ in range(4))),
        log=Log.empty(2, jnp.zeros((1, 26)), 2, 6),
        history=history,
    )  # fmt: skip


def made_up_certificate(paths, quantities=QUANTITIES, verdict=Verdict.trusted) -> Certificate:
    shape = (len(quantities), len(paths))
    peaks = Peaks(250.0, 0.02, 1, 0, 2, 200.0, 0.2, "buffer.c_A", -0.3)
    verdicts = (verdict, *(Verdict.trusted for _ in quantities[1:]))
    return Certificate(np.full(shape, 1e-5), *(np.full(shape, x) for x in (1e-5, 1e-6, 1e-7)), peaks, verdicts, verdict,
                       "made up in a test", False, 6)  # fmt: skip


def made_up_sensitivity(
    capture=None, paths=PARAMETERS, quantities=QUANTITIES, certified=True, verdict=Verdict.trusted
) -> Sensitivity:
    shape = (len(quantities), len(paths))
    numbers = np.arange(1.0, 1.0 + shape[0] * shape[1]).reshape(shape)
    results = np.array([250.0, 375.0, 0.0075, 0.004, END])[: len(quantities)]
    certificate = made_up_certificate(paths, quantities, verdict) if certified else None
    return Sensitivity(
        capture or made_up_capture(),
        tuple(paths),
        np.ones(len(paths)),
        tuple(quantities),
        results,
        numbers,
        numbers / 100,
        certificate,
    )


def made_up_tuning(problem: Problem, count: int = 5) -> Tuned:
    """Every peak falls by a fifth and every variable goes half of the way to its low bound."""
    halfway = {v.path: 0.5 * (v.low + float(get(problem.design, v.path))) for v in problem.variables}
    design = replace(problem.design, halfway)
    peaks = [250.0 + 50.0 * k for k in range(len(problem.scenarios))]
    iterations = []
    for number in range(count):
        share = number / (count - 1)
        now = tuple((1 - 0.2 * share) * peak for peak in peaks)
        values = {p: (1 - share) * float(get(problem.design, p)) + share * x for p, x in halfway.items()}
        strokes = tuple(0.01 for _ in peaks)
        iterations.append(Iteration(number, 1 - 0.2 * share, max(now), now, strokes, number != 2, values, 0.1))
    pairs = list(zip(problem.scenarios, peaks, strict=True))
    before = tuple(made_up_capture(s, peak, design=problem.design) for s, peak in pairs)
    after = tuple(made_up_capture(s, 0.8 * peak, at=0.025, design=design) for s, peak in pairs)
    paths = tuple(v.path for v in problem.variables)
    check = made_up_sensitivity(after[-1], paths)
    return Tuned(problem, design, iterations, before, after, check, True, "converged: in a test")


def made_up_sweep(design, scenarios, outcomes=None) -> Sweep:
    """A peak of 1000 N per m/s and 0.1 N per N/m, so that each capture shows what it was computed for."""
    speed, stiffness = np.broadcast_arrays(
        *np.atleast_1d(np.asarray(scenarios.approach_speed, float), np.asarray(design.buffer.k_A, float))
    )
    count = max(np.size(leaf) for leaf in jax.tree.leaves((design, scenarios)))
    peak = np.broadcast_to(1e3 * speed + 0.1 * stiffness, (count,)).copy()
    code = np.zeros(count, int)
    for index, outcome in (outcomes or {}).items():
        code[index] = outcome
        if Outcome(outcome).failed:
            peak[index] = np.nan
    share = peak / np.nanmax(peak)
    whole = np.ones(count, int)
    rest = (0.02 * share, whole, 1.5 * peak, 4 * share, 0.01 * share, 0.005 * share, share, share)
    return Sweep(code, peak, *rest, 3 * whole, 400 * whole)
