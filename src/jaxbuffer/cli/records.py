"""Results as rows and records, each number with its unit in the name, as in ``"stroke [m]"``."""

import dataclasses
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import equinox as eqx
import jax
import numpy as np

from ..capture import Capture
from ..history import BODIES, MULTIPLIERS
from ..mechanisms import get, paths, unit
from ..outcome import Outcome
from ..quantities import quantity_unit
from ..report import FLANKS, UNITS, per, scenario_label
from ..tuning.problem import QUANTITIES
from ..tuning.summary import SHOWN, tuned_warnings
from ..validity import warnings
from ..version import version

if TYPE_CHECKING:
    from ..sensitivity import Sensitivity
    from ..tuning import Tuned
    from ..tuning.evaluation import Evaluation

Table = tuple[list[str], list[Sequence[Any]]]

HISTORY_UNITS = {
    "tip_spin": "rad/s",
    "gap": "m",
    "approach_speed": "m/s",
    "slip": "m/s",
    "contact_force": "N",
    "friction_force": "N",
    "hinge_force": "N",
    "buffer_force": "N",
    "stop_force": "N",
    "stroke": "m",
    "hinge_angle": "rad",
    "throat_distance": "m",
}
COORDINATES = {
    "position": (("x", "m"), ("y", "m"), ("angle", "rad")),
    "velocity": (("x", "m/s"), ("y", "m/s"), ("angle", "rad/s")),
}
MULTIPLIER_UNITS = ("N", "N", "N m", "N")
ENERGIES = (
    "kinetic",
    "spring",
    "contact",
    "stop",
    "axial_damper",
    "torsional_damper",
    "hysteresis",
    "friction",
    "stop_damper",
    "total",
)


def capture_record(capture: Capture) -> dict[str, Any]:
    """Everything but the history. Impacts count from 1."""
    hits, energy, balance = jax.tree.map(np.asarray, (capture.impacts, capture.energy, capture.balance))
    peak_impact = int(capture.peak_impact)
    return {
        "outcome": capture.outcome.name,
        **{f"{name} [{symbol}]": _number(getattr(capture, name)) for name, symbol in UNITS.items()},
        "outside_validity": warnings(capture),
        "peak_flank": FLANKS[int(capture.peak_flank)],
        "peak_impact": peak_impact + 1 if peak_impact >= 0 else None,
        "impacts": [
            {
                "number": k + 1,
                "flank": FLANKS[int(hits.flank[k])],
                "time [s]": _number(hits.time[k]),
                "approach_speed [m/s]": _number(hits.approach_speed[k]),
                "peak_force [N]": _number(hits.peak_force[k]),
                "release_time [s]": _number(hits.release_time[k]),
            }
            for k in range(int(hits.count))
        ],
        "energy_at_end": {f"{name} [J]": _number(getattr(energy, name)) for name in ENERGIES},
        "numerical_balance": {
            "energy [-]": _number(balance.energy),
            "linear_momentum [-]": _number(balance.linear_momentum),
            "angular_momentum [-]": _number(balance.angular_momentum),
            "constraint_drift [m]": _number(balance.drift),
        },
        "first_impact": {
            "effective_mass [kg]": _number(capture.first_impact.effective_mass),
            "effective_energy [J]": _number(capture.first_impact.effective_energy),
            "elastic_peak [N]": _number(capture.first_impact.elastic_peak),
            "predicted_peak [N]": _number(capture.first_impact.predicted_peak),
        },
        "steps_accepted": int(capture.accepted),
        "steps_attempted": int(capture.attempts),
        "design": _fields(capture.design),
        "scenario": _fields(capture.scenario),
        "jaxbuffer": version(),
    }


def capture_history(capture: Capture) -> Table:
    """The history, a row for each accepted step."""
    seen: Any = jax.tree.map(np.asarray, capture.history)
    columns: dict[str, Any] = {"time [s]": seen.time}
    for name, symbol in HISTORY_UNITS.items():
        value = getattr(seen, name)
        if value.ndim == 1:
            columns[f"{name} [{symbol}]"] = value
        else:
            columns |= {f"{name} {flank} [{symbol}]": value[:, k] for k, flank in enumerate(FLANKS)}
    for name, axes in COORDINATES.items():
        for k, body in enumerate(BODIES):
            columns |= {f"{body} {name} {axis} [{s}]": getattr(seen, name)[:, k, i] for i, (axis, s) in enumerate(axes)}
    for k, (name, symbol) in enumerate(zip(MULTIPLIERS, MULTIPLIER_UNITS, strict=True)):
        columns[f"multiplier {name} [{symbol}]"] = seen.multipliers[:, k]
    columns |= {f"energy {name} [J]": getattr(seen.energy, name) for name in ENERGIES}
    return list(columns), np.column_stack([np.asarray(column) for column in columns.values()]).tolist()


def sensitivity_record(result: "Sensitivity") -> dict[str, Any]:
    """Quantities, for each parameter its gradients and elasticities, and the certificate."""
    header, rows = sensitivity_rows(result)
    capture, units = result.capture, [quantity_unit(name) for name in result.quantities]
    return {
        "outcome": capture.outcome.name,
        **{f"{n} [{u}]": _number(x) for n, u, x in zip(result.quantities, units, result.results, strict=True)},
        "derivatives": [dict(zip(header, row, strict=True)) for row in rows],
        "certificate": None if result.certificate is None else certificate_record(result),
        "design": _fields(capture.design),
        "scenario": _fields(capture.scenario),
        "jaxbuffer": version(),
    }


def certificate_record(result: "Sensitivity") -> dict[str, Any]:
    """Verdicts, what they rest on, active peak and runner-up; errors are relative. Impacts count from 1."""
    certificate: Any = result.certificate
    peaks = certificate.peaks
    evidence = {
        name: {
            quantity: dict(zip(result.paths, map(_number, getattr(certificate, field)[k]), strict=True))
            for k, quantity in enumerate(result.quantities)
        }
        for name, field in (
            ("estimated_error [-]", "error"),
            ("change_with_tolerance [-]", "by_tolerance"),
            ("distance_from_differences [-]", "by_differences"),
            ("differences_own_doubt [-]", "doubt"),
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
            "flank": FLANKS[peaks.flank],
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


def sensitivity_rows(result: "Sensitivity") -> Table:
    """A row for each pair of quantity and parameter."""
    header = ["quantity", "parameter", "value", "parameter_unit", "gradient", "gradient_unit", "elasticity [-]"]
    certificate = result.certificate
    rows: list[Sequence[Any]] = []
    for i, quantity in enumerate(result.quantities):
        for k, path in enumerate(result.paths):
            of_scenario = path.startswith("scenario.")
            owner = result.capture.scenario if of_scenario else result.capture.design
            symbol = unit(owner, path.removeprefix("scenario."))
            rows.append(
                [
                    quantity,
                    path,
                    _number(result.values[k]),
                    symbol,
                    _number(result.gradients[i, k]),
                    per(quantity_unit(quantity), symbol),
                    _number(result.elasticities[i, k]),
                    None if certificate is None else _number(certificate.error[i, k]),
                    None if certificate is None else certificate.verdicts[i].name,
                ]
            )
    return [*header, "estimated_error [-]", "verdict"], rows


def tuning_history(tuned: "Tuned") -> Table:
    """A row for each evaluated design; worst values over the scenarios."""
    problem = tuned.problem
    plain = ("evaluation", "stage", "search", "step", "accepted", "feasible", "captures", "status")
    numbers = {"objective": "N", "excess": "-", "radius": "-", "residual": "-"}
    worst = {"peak_force": "N", "peak_hinge_force": "N", "stroke": "m", "hinge_angle": "rad", "end_time": "s"}
    header = [*plain, *(f"{name} [{symbol}]" for name, symbol in numbers.items())]
    header += [f"worst {name} [{symbol}]" for name, symbol in worst.items()]
    header += [f"{v.path} [{unit(problem.design, v.path)}]" for v in problem.variables]
    rows: list[Sequence[Any]] = []
    for it in tuned.records:
        row = [it[name] for name in plain] + [it[name] for name in numbers] + [max(it[name]) for name in worst]
        rows.append([*row, *(it["values"][v.path] for v in problem.variables)])
    return header, rows


def tuned_record(tuned: "Tuned") -> dict[str, Any]:
    """The result: problem, objective, floor, evidence, and every scenario before and after at tight tolerance."""
    problem, (start, end) = tuned.problem, tuned.objective
    scenarios = zip(problem.cases, _cases(tuned.before), _cases(tuned.after), strict=True)
    return {
        "message": tuned.message,
        "converged": tuned.converged,
        "feasible": tuned.feasible,
        "broken": tuned.goal.broken(tuned.after),
        "outside_validity": tuned_warnings(tuned),
        "objective": str(problem.objective),
        "objective_before [N]": _number(start),
        "objective_after [N]": _number(end),
        "first_order_residual [-]": _number(tuned.residual),
        "gradient_error [-]": _number(tuned.gradient_error),
        "above_floor [-]": _number(tuned.above_floor),
        "lowest_first_impact_within_bounds [N]": _number(tuned.floor.lowest),
        "captures": tuned.captures,
        "settings": dataclasses.asdict(tuned.settings),
        "variables": [
            {"path": v.path, "low": v.low, "high": v.high, "scale": v.scale, "value": get(tuned.design, v.path)}
            for v in problem.variables
        ],
        "limits": {name: limit for name, limit in problem.limits.at_most.items()},
        "scenarios": [
            {
                **_fields(case.scenario),
                "factors": dict(case.factors),
                "floor [N]": _number(floor),
                "closed_form_first_peak [N]": _number(closed),
                "T_c [J]": _number(energy),
                "before": before,
                "after": after,
            }
            for (case, before, after), floor, closed, energy in zip(
                scenarios, tuned.floor.simulated, tuned.floor.closed_form, tuned.floor.energy, strict=True
            )
        ],
        "design": _fields(tuned.design),
        "jaxbuffer": version(),
    }


def _cases(point: "Evaluation") -> list[dict[str, Any]]:
    return [
        {
            "outcome": Outcome(int(code)).name,
            "impacts": int(impacts),
            "first_peak [N]": _number(first),
            **{f"{name} [{symbol}]": _number(x) for (name, symbol), x in zip(QUANTITIES.items(), row, strict=True)},
        }
        for code, impacts, first, row in zip(point.code, point.impacts, point.first, point.quantities, strict=True)
    ]


def tuned_comment(tuned: "Tuned") -> str:
    """What the tuned design's file says of its origin."""
    problem, (start, end) = tuned.problem, tuned.objective
    limits = [f"{name} ≤ {limit:g} {QUANTITIES[name]}" for name, limit in problem.limits.at_most.items()]
    lines = [
        f"Tuned by jaxbuffer {version()} with {tuned.captures} captures: {tuned.message}.",
        f"Simulated up to {problem.duration:g} s at rtol {problem.rtol:g}; {', '.join(limits) or 'no limits'}.",
        f"{problem.objective}, before and after: {start:.6g} N, {end:.6g} N.",
    ]
    for k, scenario in enumerate(problem.meetings[:SHOWN]):
        peaks = f"{tuned.before.quantities[k, 0]:.6g} N, {tuned.after.quantities[k, 0]:.6g} N"
        lines.append(f"  peak at {scenario_label(scenario, problem.meetings)}: {peaks}")
    return "\n".join(lines)


def _fields(module: eqx.Module) -> dict[str, Any]:
    record: dict[str, Any] = {}
    for path in paths(module):
        value: Any = module
        for name in path.split("."):
            value = getattr(value, name)
        symbol = unit(module, path)
        record[f"{path} [{symbol}]" if symbol else path] = _number(value) if symbol else value
    return record


def _number(value: Any) -> float | None:
    if value is None:
        return None
    number = float(value)
    return number if math.isfinite(number) else None
