"""Captures and tunings made up in a moment: what the front shows of them needs no simulation."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np

from jaxbuffer import Outcome, Scenario, get, table2
from jaxbuffer.hybrid import Log
from jaxbuffer.mechanisms.energy import Balance, Energy
from jaxbuffer.mechanisms.history import History
from jaxbuffer.mechanisms.impacts import Impacts
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.mechanisms.probe_cone.capture import Capture, Docking, FirstImpact
from jaxbuffer.sensitivities.certificate import Certificate, Peaks, Verdict
from jaxbuffer.sensitivities.sensitivity import Sensitivity
from jaxbuffer.sweeps.columns import column_names
from jaxbuffer.sweeps.result import Sweep
from jaxbuffer.tuning import Problem
from jaxbuffer.tuning.problem.own_quantities import compose
from jaxbuffer.tuning.problem.settings import Settings
from jaxbuffer.tuning.report.tuned import Tuned
from jaxbuffer.tuning.search.checks import PeakForceBound
from jaxbuffer.tuning.search.evaluation import Evaluation
from jaxbuffer.tuning.search.goal import Goal
from jaxbuffer.tuning.search.measurement import PEAKS

PARAMETERS, QUANTITIES = PROBE_CONE.defaults.parameters, PROBE_CONE.defaults.differentiated
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
    nothing = 0 * ramp
    stored = {"kinetic": 1.0 - ramp, "spring": 0.2 * ramp, "contact": nothing, "stop": nothing}
    lost = {"axial_damper": 0.3 * ramp, "torsional_damper": 0.2 * ramp, "hysteresis": 0.1 * ramp,
            "friction": 0.2 * ramp, "stop_damper": nothing, "hinge_play": nothing, "bending": nothing}  # fmt: skip
    energy = jax.tree.map(jnp.asarray, Energy(stored, lost))
    two, bodies = np.zeros((STEPS, 2)), np.zeros((STEPS, 4, 3))
    history = History(
        **{name: jnp.asarray(value) for name, value in {
            "time": time, "position": bodies, "velocity": bodies, "acceleration": bodies,
            "multipliers": np.zeros((STEPS, 4)),
            "gap": 0.01 - two, "approach_speed": two, "slip": two, "contact_force": force,
            "friction_force": 0.3 * force,
        }.items()},
        others={name: jnp.asarray(value) for name, value in {
            "tip_spin": ramp, "hinge_force": force[:, 1], "buffer_force": 4 * ramp, "stop_force": 0 * ramp,
            "extension": -0.0075 * ramp, "stroke": 0.0075 * ramp, "hinge_angle": -0.004 * ramp,
            "throat_distance": 0.03 * (1 - ramp),
            "relative_energy": 1.0 - 0.8 * ramp, "latch_force": 20 * ramp, "latch_closed": ramp,
        }.items()},
        energy=energy,
    )  # fmt: skip
    first = np.array([1.0, 0.0, 0.0])
    hits = Impacts(
        time=jnp.asarray((at - PULSE / 2) * first),
        contact=jnp.asarray([1, -1, -1]),
        approach_speed=jnp.asarray(0.07 * first),
        peak_force=jnp.asarray(peak * first),
        release_time=jnp.asarray([np.nan, 0.0, 0.0]),
        count=jnp.asarray(1),
    )
    return Capture(
        **{name: jnp.asarray(value) for name, value in {
            "code": int(outcome), "peak_force": peak, "peak_time": at, "peak_contact": 1, "peak_impact": 0,
            "peak_hinge_force": 1.5 * peak, "peak_buffer_force": 4.0, "peak_stop_force": 0.0, "stroke": 0.0075,
            "extension": 0.0,
            "stroke_margin": 0.129, "hinge_angle": 0.004, "penetration": 1e-5,
            "peak_latch_force": 0.0, "passive_force": np.nan,
            "end_time": END, "contact_time": PULSE, "impact_count": 1, "throat_distance": 0.0, "capture_margin": 0.3,
            "capture_share": 1.0, "bending": 0.0, "attempts": STEPS + 20, "accepted": STEPS,
        }.items()},
        design=design,
        scenario=scenario,
        maxima={name: jnp.asarray(value) for name, value in {
            "hinge_force": 1.5 * peak, "buffer_force": 4.0, "stroke": 0.0075, "extension": 0.0, "hinge_angle": 0.004,
        }.items()},
        impacts=hits,
        docking=made_up_docking(),
        first_impact=FirstImpact(*(jnp.asarray(x) for x in (0.2, 5e-4, 150.0, 143.0, PULSE))),
        energy=jax.tree.map(lambda share: jnp.asarray(np.asarray(share)[-1]), energy),
        balance=Balance(*(jnp.asarray(1e-9) for _ in range(4))),
        _located=Log.empty(2, jnp.zeros((1, 30)), 2, 6),
        _observed=(),
        stabilisation=jnp.asarray(20.0),
        history=history,
    )  # fmt: skip


def made_up_docking() -> Docking:
    """Without a latch: three tenths of the energy of relative motion are left, which may take 20 mm of stroke."""
    numbers = dict.fromkeys((field.name for field in dataclasses.fields(Docking)), 0.0)
    numbers |= {"latch_time": np.nan, "settling_time": np.nan}
    numbers |= {"relative_energy": 0.3, "energy_left": 0.03, "arrest_stroke": 0.02}
    return Docking(**{name: jnp.asarray(number) for name, number in numbers.items()})


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


def made_up_evaluation(problem: Problem, scaled, share: float = 1.0) -> Evaluation:
    """Peaks of 250 N, 300 N, … times ``share``, strokes of 10 mm, all captured."""
    cases, n = len(problem.cases), len(problem.variables)
    peaks = np.zeros((cases, PEAKS))
    peaks[:, 0] = share * (250.0 + 50.0 * np.arange(cases))
    numbers = {"peak_hinge_force": 1.5 * peaks[:, 0], "peak_buffer_force": peaks[:, 0] / 50.0, "stroke": 0.01}
    numbers |= {"hinge_angle": 0.004, "end_time": END, "stroke_share": 0.1, "relative_energy": 0.3}
    numbers |= {"energy_left": 0.03, "arrest_stroke": 0.02, "peak_active_acceleration": 1.5 * peaks[:, 0] / 20.0}
    known = problem.measured[1:]
    rest = np.column_stack([np.broadcast_to(numbers.get(name, 0.0), cases) for name in known])
    own = compose(problem, peaks[:, 0], rest, np.zeros((*rest.shape, n)))
    return Evaluation(
        scaled=np.asarray(scaled),
        code=np.full(cases, int(Outcome.captured)),
        solved=np.ones(cases, bool),
        succeeded=np.ones(cases, bool),
        impacts=np.full(cases, 9),
        peaks=peaks,
        slots=np.tile(np.arange(PEAKS), (cases, 1)),
        rest=np.column_stack([rest, own.values]),
        margin=np.ones(cases),
        first=0.5 * peaks[:, 0],
        peaks_slope=np.zeros((cases, PEAKS, n)),
        rest_slope=np.zeros((cases, len(problem.names) - 1, n)),
        margin_slope=np.zeros((cases, n)),
        by_peak=np.column_stack([np.zeros(rest.shape), own.by_peak]),
    )


def made_up_tuning(problem: Problem, count: int = 5) -> Tuned:
    """Every peak falls by a fifth and every variable goes half of the way to its low bound."""
    start = problem.start()
    halfway = np.array([v.scaled(0.5 * (v.low + float(get(problem.design, v.path)))) for v in problem.variables])
    goal, records = Goal(problem, problem.objective), []
    for number in range(count):
        share = number / (count - 1)
        point = made_up_evaluation(problem, start + share * (halfway - start), 1 - 0.2 * share)
        values = dict(zip(problem.paths, map(float, problem.values(point.scaled)), strict=True))
        records.append(
            {
                **{"evaluation": number, "stage": 0, "search": 0, "step": number, "accepted": number != 2},
                **{"objective": goal.value(point), "unit": "N", "feasible": number != 2},
                **{"excess": 0.0, "captures": number},
                **{"radius": 0.1, "residual": 0.02, "status": "running" if number else "start", "values": values},
                "succeeded": [number != 2] * len(problem.cases),
                "outcome": ["captured" if number != 2 else "timeout"] * len(problem.cases),
                **{name: point.quantities[:, q].tolist() for q, name in enumerate(problem.names)},
            }
        )
    before, after = (made_up_evaluation(problem, z, share) for z, share in ((start, 1.0), (halfway, 0.8)))
    return Tuned(
        problem=problem,
        settings=Settings(),
        goal=goal,
        design=problem.built(halfway),
        before=before,
        after=after,
        residual=1.5e-5,
        gradient_error=2e-6,
        ended="converged",
        confirmed=True,
        message="converged: in a test",
        lower_bound=PeakForceBound(
            0.4 * after.peaks[:, 0], 0.45 * after.peaks[:, 0], after.peaks[:, 0] / 1e5, 90.0, {}
        ),
        records=tuple(records),
        captures=123,
    )


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
        if outcome < 0 or Outcome(outcome).failed:
            peak[index] = np.nan
    largest = np.nanmax(np.append(peak, 1.0))
    share = peak / largest
    whole = np.ones(count, int)
    numbers = {
        "peak_time": 0.02,
        "peak_hinge_force": 1.5 * largest,
        "peak_buffer_force": 4.0,
        "peak_stop_force": 0.0,
        "stroke": 0.01,
        "extension": 0.002,
        "peak_latch_force": 0.0,
        "peak_lockout_force": 0.0,
        "lockout_stroke": 0.0,
        "latch_time": np.nan,
        "settling_time": np.nan,
        "relative_energy": 0.3,
        "energy_left": 0.03,
        "arrest_stroke": 0.02,
        "stroke_margin": 0.1,
        "hinge_angle": 0.005,
        "penetration": 1e-5,
        "end_time": 1.0,
        "contact_time": 1.0,
        "throat_distance": 0.03,
        "capture_margin": 0.3,
        "bending": 0.0,
        **{f"{vehicle}_shock_{k}": np.nan for vehicle in ("active", "passive") for k in (1, 2, 3)},
    }
    columns = {"code": code, "peak_force": peak, "peak_flank": whole, "impact_count": 3 * whole}
    columns |= {"attempts": 400 * whole, "trust": 0 * whole} | {name: value * share for name, value in numbers.items()}
    return Sweep(PROBE_CONE, {name: columns[name] for name in column_names(PROBE_CONE)})
