"""Results as rows and records, each number with its unit in the name, as in ``"stroke [m]"``."""

import dataclasses
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import jax
import numpy as np

from ..experiments.indices import Indices
from ..experiments.rectangle import SafeRectangle
from ..experiments.sample import Sample
from ..experiments.surface import Surface
from ..fields import get, unit
from ..fields.record import record
from ..mechanisms.quantity import unit_of
from ..mechanisms.run import Run, history_columns
from ..run.trust import Trust
from ..sensitivities.result import Sensitivity, advice, sensitivity_rows
from ..sweeps.columns import RunTable
from ..sweeps.result import Sweep
from ..tuning.derived import Derived
from ..tuning.evaluation import Evaluation
from ..tuning.message import headline
from ..tuning.objective import Constraints, Limits
from ..tuning.pareto import Front, point_status
from ..tuning.tuned import SHOWN, Tuned, tuned_warnings
from ..version import version

Table = tuple[list[str], list[Sequence[Any]]]


def run_record(run: Run, constraints: Constraints | None = None, trust: Trust | None = None) -> dict[str, Any]:
    """Return everything but the history; impacts count from 1. ``constraints``: the study's; ``trust`` in numbers."""
    mechanism, names = run.mechanism, run.mechanism.view.names(run.design)
    limits, own = (Limits(), {}) if constraints is None else constraints
    hits, energy, balance = jax.tree.map(np.asarray, (run.impacts, run.energy, run.balance))
    energies = np.asarray(run.loads("effective_energy"))
    peak_impact, catalogue = int(run.peak_impact), mechanism.quantities
    return {
        "kind": mechanism.name,
        "outcome": run.outcome.name,
        **{f"{name} [{catalogue[name].unit}]": _number(catalogue[name].of(run)) for name in mechanism.swept},
        **_limits_record(limits, own),
        "limited": {n: _number(x) for n, x in ({} if constraints is None else constraints.values(run)).items()},
        "trust": None
        if trust is None
        else {
            "verdict": trust.verdict,
            "reason": str(trust),
            "errors": {name: _number(error) for name, error in trust.errors.items()},
        },
        "outside_validity": mechanism.view.warnings(run),
        "diagnosis": dict(mechanism.view.diagnosis(run)) if run.diagnosis else {},
        f"peak_{mechanism.view.contact}": names.contacts[int(run.peak_contact)] if hits.count else None,
        "maximum_times": {f"{name} [s]": _number(time) for name, time in run.maximum_times.items()},
        "peak_impact": peak_impact + 1 if peak_impact >= 0 else None,
        "impacts": [
            {
                "number": k + 1,
                mechanism.view.contact: names.contacts[int(hits.contact[k])],
                "time [s]": _number(hits.time[k]),
                "approach_speed [m/s]": _number(hits.approach_speed[k]),
                "peak_force [N]": _number(hits.peak_force[k]),
                "release_time [s]": _number(hits.release_time[k]),
                "effective_energy [J]": _number(energies[k]),
            }
            for k in range(int(hits.count))
        ],
        "energy_at_end": {f"{name} [J]": _number(getattr(energy, name)) for name in energy.names},
        "numerical_balance": {
            "energy [-]": _number(balance.energy),
            "linear_momentum [-]": _number(balance.linear_momentum),
            "angular_momentum [-]": _number(balance.angular_momentum),
            "constraint_drift [m]": _number(balance.drift),
        },
        **{
            name: {inner: _number(value) for inner, value in values.items()}
            for name, values in mechanism.view.record(run).items()
        },
        "steps_accepted": int(run.accepted),
        "steps_attempted": int(run.attempts),
        "design": record(run.design),
        "scenario": record(run.scenario),
        "jaxbuffer": version(),
    }


def _limits_record(limits: Limits, own: Mapping[str, Derived]) -> dict[str, Any]:
    """What is limited, and what the own quantities among it are."""
    return {
        "limits": dict(limits.at_most),
        "lower_limits": dict(limits.at_least),
        "most_impacts": limits.impacts,
        "quantities": {
            name: {"unit": it.unit, "function": it.signature, "description": it.description} for name, it in own.items()
        },
    }


def run_history(run: Run) -> Table:
    """The history, a row for each accepted step."""
    columns = history_columns(run)
    return list(columns), np.column_stack(list(columns.values())).tolist()


def sensitivity_record(result: Sensitivity) -> dict[str, Any]:
    """Quantities, for each parameter its gradients and elasticities, and the certificate."""
    header, rows = sensitivity_rows(result)
    run, catalogue = result.run, result.run.mechanism.quantities
    units = [unit_of(catalogue, name) for name in result.quantities]
    return {
        "kind": run.mechanism.name,
        "outcome": run.outcome.name,
        **{f"{n} [{u}]": _number(x) for n, u, x in zip(result.quantities, units, result.results, strict=True)},
        "derivatives": [dict(zip(header, row, strict=True)) for row in rows],
        "certificate": None if result.certificate is None else certificate_record(result),
        "advice": [" ".join(line.split()) for line in advice(result)],
        "design": record(run.design),
        "scenario": record(run.scenario),
        "jaxbuffer": version(),
    }


def certificate_record(result: Sensitivity) -> dict[str, Any]:
    """Verdicts, what they rest on, active peak and runner-up; errors are relative. Impacts count from 1."""
    certificate: Any = result.certificate
    peaks, mechanism = certificate.peaks, result.run.mechanism
    names = mechanism.view.names(result.run.design)
    evidence = {
        name: {
            quantity: dict(zip(result.paths, map(_number, getattr(certificate, field)[k]), strict=True))
            for k, quantity in enumerate(result.quantities)
        }
        for name, field in (
            ("estimated_error [-]", "error"),
            ("change_with_tolerance [-]", "by_tolerance"),
            ("distance_from_differences [-]", "by_differences"),
            ("differences_own_uncertainty [-]", "uncertainty"),
        )
    }
    return {
        "verdict": certificate.verdict.name,
        "reason": certificate.reason,
        "verdicts": {n: v.name for n, v in zip(result.quantities, certificate.verdicts, strict=True)},
        "thorough": certificate.thorough,
        "tight_solves": certificate.solves,
        **evidence,
        "active_peak": None
        if peaks is None
        else {
            "force [N]": peaks.force,
            "time [s]": peaks.time,
            mechanism.view.contact: names.contacts[peaks.contact],
            "impact": peaks.impact + 1,
        },
        "runner_up": None
        if peaks is None or peaks.runner_up_impact < 0
        else {
            "force [N]": peaks.runner_up_force,
            "impact": peaks.runner_up_impact + 1,
            "margin [-]": peaks.margin,
            "swapped_by": peaks.swap_path or None,
            "swapped_by_change [-]": _number(peaks.swap_change),
        },
    }


def tuned_record(tuned: Tuned) -> dict[str, Any]:
    """The result: problem, objective, floor, evidence, and every scenario before and after at tight tolerance."""
    problem, (start, end) = tuned.problem, tuned.objective
    scenarios = zip(problem.cases, _cases(tuned, tuned.before), _cases(tuned, tuned.after), strict=True)
    floors = _floors(tuned)
    return {
        "kind": problem.mechanism.name,
        "message": tuned.message,
        "converged": tuned.converged,
        "ended": tuned.ended,
        "borne_out": tuned.borne_out,
        "feasible": tuned.feasible,
        "why": tuned.why,
        "broken": tuned.goal.broken(tuned.after),
        "outside_validity": tuned_warnings(tuned),
        "objective": problem.worded(problem.objective),
        "objective_unit": problem.objective.unit(problem.catalogue),
        "objective_before": _number(start),
        "objective_after": _number(end),
        "first_order_residual [-]": _number(tuned.residual),
        "gradient_error [-]": _number(tuned.gradient_error),
        "rtol_of_check [-]": tuned.tight,
        "above_floor [-]": _number(tuned.above_floor),
        "lowest_first_impact_within_bounds [N]": None if tuned.floor is None else _number(tuned.floor.lowest),
        "captures": tuned.captures,
        "settings": dataclasses.asdict(tuned.settings),
        "variables": [
            {
                "path": v.path,
                "low": v.low,
                "high": v.high,
                "scale": v.scale,
                "before": get(problem.design, v.path),
                "value": get(tuned.design, v.path),
                "shown_in": problem.shown(v.path, 0.0)[1],  # the numbers beside it are in SI units
            }
            for v in problem.variables
        ],
        **_limits_record(problem.limits, problem.quantities),
        "scenarios": [
            {
                **record(case.scenario),
                "factors": dict(case.factors),
                **floor,
                "before": before,
                "after": after,
            }
            for (case, before, after), floor in zip(scenarios, floors, strict=True)
        ],
        **_scattered(tuned),
        "design": record(tuned.design),
        "jaxbuffer": version(),
    }


def _scattered(tuned: Tuned) -> dict[str, Any]:
    """What the cases of a tuning are samples of, and the result in the corners of the ranges."""
    scatter, found = tuned.problem.scatter, tuned.corners
    if scatter is None or found is None:
        return {}
    corners = zip(found.cases, found.values, found.broken, strict=True)
    return {
        "sample": {
            "count": scatter.count,
            "seed": scatter.seed,
            "ranges": {name: [given.kind, *given.range] for name, given in scatter.distributions.items()},
        },
        "corners": {
            "said": found.lines(tuned.problem),
            "run": len(found.cases),
            "all": found.whole,
            "holding": found.holding,
            "largest_objective": _number(found.largest),
            "objective_in_the_middle": _number(found.middle),
            "each": [
                {**record(case.scenario), "factors": dict(case.factors), "objective": _number(value), "broken": broken}
                for case, value, broken in corners
            ],
        },
    }


def _floors(tuned: Tuned) -> list[dict[str, float | None]]:
    """What is known of each case's first impact."""
    floor = tuned.floor
    if floor is None:
        return [{} for _ in tuned.problem.cases]
    names = ("floor [N]", "closed_form_first_peak [N]", "T_c [J]")
    rows = zip(floor.simulated, floor.closed_form, floor.energy, strict=True)
    return [dict(zip(names, map(_number, row), strict=True)) for row in rows]


def _cases(tuned: Tuned, point: Evaluation) -> list[dict[str, Any]]:
    problem = tuned.problem
    units, margin = {name: problem.catalogue[name].unit for name in problem.names}, problem.mechanism.tuning.margin
    return [
        {
            "outcome": problem.mechanism.outcomes(int(code)).name,
            "impacts": int(impacts),
            "first_peak [N]": _number(first),
            **{f"{name} [{symbol}]": _number(x) for (name, symbol), x in zip(units.items(), row, strict=True)},
            **({} if margin is None else {f"{margin} [{problem.catalogue[margin].unit}]": _number(room)}),
        }
        for code, impacts, first, row, room in zip(
            point.code, point.impacts, point.first, point.quantities, point.margin, strict=True
        )
    ]


def tuned_comment(tuned: Tuned) -> str:
    """What the tuned design's file says of its origin."""
    problem, (start, end) = tuned.problem, tuned.objective
    limits = problem.limits.lines(problem.catalogue)
    before, after = (problem.objective.said(value, problem.catalogue, 6) for value in (start, end))
    lines = [
        f"{headline(tuned.message, tuned.feasible)}.",
        f"By jaxbuffer {version()} with {tuned.captures} {problem.mechanism.view.run_name}s.",
        f"Simulated up to {problem.duration:g} s at rtol {problem.rtol:g}; {', '.join(limits) or 'no limits'}.",
        f"{problem.worded(problem.objective)}, before and after: {before}, {after}.",
    ]
    for k, scenario in enumerate(problem.scenarios_met[:SHOWN]):
        peaks = f"{tuned.before.peak_force[k]:.6g} N, {tuned.after.peak_force[k]:.6g} N"
        lines.append(f"  peak at {problem.mechanism.view.label(scenario, problem.scenarios_met)}: {peaks}")
    return "\n".join(lines)


def sweep_record(swept: Sweep, envelope: SafeRectangle | None) -> dict[str, Any]:
    """Return how many runs ended how, and what is safe; the runs themselves are in sweep.nc."""
    places = () if swept.grid is None else swept.grid.axes
    axes = [{**_field(it), "values": np.asarray(it.values).tolist(), "scale": it.scale} for it in places]
    return _of_many(swept, {"axes": axes, "envelope": None if envelope is None else _envelope(envelope)})


def _field(axis: Any) -> dict[str, str]:
    """A swept or sampled field: its path, the unit of its numbers, and the one in which people are shown them."""
    return {"path": axis.path, "unit": axis.unit, "shown_in": axis.typed or axis.unit}


def _envelope(found: SafeRectangle) -> dict[str, Any]:
    """What is asked of a safe run, how many there are, and the largest rectangle of them."""
    ranges = zip(found.axes, (found.first, found.second), strict=True)
    return {
        "asked": found.asked,
        "safe_runs": int(found.safe.sum()),
        "runs": int(found.safe.size),
        "runs_in_rectangle": int(found.runs),
        "rectangle": [
            {**_field(axis), "low": float(part[0]), "high": float(part[1])} for axis, part in ranges if part is not None
        ],
        "reasons": dict(Counter(str(reason) for reason in found.reasons[~found.safe])),
        "between": None
        if (between := found.between) is None
        else {"runs": between.runs, "unsafe_runs": between.unsafe, "words": between.words},
    }


def sample_record(sample: Sample, indices: Indices | None, surfaces: Sequence[Surface]) -> dict[str, Any]:
    """Return ranges, how many runs ended how, indices with intervals, surfaces with cross-validated errors."""
    points = sample.grid
    own = {
        "method": points.method,
        "seed": points.seed,
        "ranges": [{**_field(it), "low": it.low, "high": it.high, "scale": it.scale} for it in points.axes],
        "indices": [] if indices is None else _indices(indices),
        "surfaces": [_surface(surface) for surface in surfaces],
    }
    return _of_many(sample, own)


def _indices(indices: Indices) -> list[dict[str, Any]]:
    return [
        {
            "quantity": name,
            "number": path,
            "first_order [-]": float(it.first[k]),
            "first_order_interval [-]": it.first_interval[:, k].tolist(),
            "total [-]": float(it.total[k]),
            "total_interval [-]": it.total_interval[:, k].tolist(),
            "confidence [-]": indices.confidence,
            "rows": it.rows,
            "rows_asked": indices.asked,
            "from": "response surface" if name in indices.surfaces else "runs",
        }
        for name, it in indices.estimates.items()
        for k, path in enumerate(indices.paths)
    ]


def _surface(surface: Surface) -> dict[str, Any]:
    return {
        "quantity": surface.quantity,
        "unit": surface.unit,
        "kind": surface.kind,
        "runs": len(surface.computed),
        "left_out": dict(surface.left_out),
        "trusted": bool(surface.trusted),
        "cross_validated": {
            kind: {name: float(value) for name, value in error._asdict().items()}
            for kind, error in surface.errors.items()
        },
    }


def indices_rows(indices: Indices) -> Table:
    """Return a row for each quantity and number."""
    header = ["quantity", "number", "first_order [-]", "first_order_low [-]", "first_order_high [-]"]
    header += ["total [-]", "total_low [-]", "total_high [-]", "rows", "from"]
    columns = ("first_order [-]", "first_order_interval [-]", "total [-]", "total_interval [-]")
    rows: list[Sequence[Any]] = []
    for it in _indices(indices):
        first, first_ends, total, total_ends = (it[name] for name in columns)
        rows.append([it["quantity"], it["number"], first, *first_ends, total, *total_ends, it["rows"], it["from"]])
    return header, rows


def surface_rows(surfaces: Sequence[Surface]) -> Table:
    """Return a row for each run that a surface was fitted to; the prediction is by a fit without that run's fold."""
    return ["quantity", "unit", "computed", "predicted", "kind"], [
        [surface.quantity, surface.unit, x.item(), y.item(), surface.kind]
        for surface in surfaces
        for x, y in zip(surface.computed, surface.predicted, strict=True)
    ]


def front_record(front: Front) -> dict[str, Any]:
    """Return the front's points, as in pareto.csv."""
    header, rows = front_rows(front)
    return {
        "kind": front.problem.mechanism.name,
        "objectives": list(front.objectives),
        "scenarios": len(front.problem.cases),
        "samples": front.problem.samples,
        "points": [dict(zip(header, row, strict=True)) for row in rows],
        "design": record(front.problem.design),
        "jaxbuffer": version(),
    }


def front_rows(front: Front) -> Table:
    """Return a row for each point."""
    problem, catalogue = front.problem, front.problem.catalogue
    header = ["point", *(f"worst {name} [{catalogue[name].unit}]" for name in front.objectives)]
    header += [f"limit of {name} [{catalogue[name].unit}]" for name in front.objectives[1:]]
    header += ["first_order_residual [-]", "gradient_error [-]", "converged", "standing"]
    header += [f"{v.path} [{unit(problem.design, v.path)}]" for v in problem.variables]
    rows: list[Sequence[Any]] = []
    for k, (point, values, limits) in enumerate(zip(front.points, front.values, front.limits, strict=True)):
        finite = [None if np.isinf(limit) else float(limit) for limit in limits]
        status = [float(point.residual), float(point.gradient_error), point.converged, point_status(front, k)]
        variables = [float(get(point.design, v.path)) for v in problem.variables]
        rows.append([k + 1, *map(float, values), *finite, *status, *variables])
    return header, rows


def _of_many(swept: RunTable, own: dict[str, Any]) -> dict[str, Any]:
    """Return what sweeps and samples have in common around what is their own; of runs given one by one, whose inputs
    sweep.nc has, neither design nor scenario."""
    mechanism, both = swept.mechanism, {}
    outcomes = Counter(mechanism.outcomes(int(code)).name for code in swept.code[swept.done])
    if swept.grid is not None:
        both = {"design": record(swept.design), "scenario": record(swept.scenario)}
    return {
        "kind": mechanism.name,
        **own,
        "runs": len(swept),
        "done": int(swept.done.sum()),
        "outcomes": dict(outcomes),
        **both,
        "jaxbuffer": version(),
    }


def _number(value: Any) -> float | None:
    if value is None:
        return None
    number = float(value)
    return number if math.isfinite(number) else None
