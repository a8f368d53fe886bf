"""Runs and sensitivities as rows and records."""

from collections.abc import Mapping, Sequence
from typing import Any

import jax
import numpy as np

from ..labelled.arrays import Labelled
from ..labelled.record import amount, amounts, json_number, numbers, part_record, rows
from ..mechanisms.cautions import cautions
from ..mechanisms.quantity import LOAD_UNITS, unit_of
from ..mechanisms.run import Run
from ..mechanisms.run_arrays import history_columns, run_quantities
from ..run.trust import Trust
from ..sensitivities.result import COLUMNS, Sensitivity, advice, sensitivity_rows
from ..tuning.problem.custom_quantity import CustomQuantity
from ..tuning.problem.objective import Constraints, Limits
from ..version import version

Table = tuple[list[str], list[Sequence[Any]]]


def run_record(
    run: Run, constraints: Constraints | None = None, trust: Trust | None = None, number: str = ""
) -> dict[str, Any]:
    """Return everything but the history; impacts count from 1.

    **Arguments:** ``constraints``: the study's; ``trust`` in numbers; ``number``: of the scenario among the study's, ""
    for a single one.
    """
    mechanism, names = run.mechanism, run.mechanism.view.names(run.design)
    limits, own = (Limits(), {}) if constraints is None else constraints
    energy, balance = jax.tree.map(np.asarray, (run.energy, run.balance))
    peak_impact = int(run.peak_impact)
    return {
        "kind": mechanism.name,
        "outcome": run.outcome.name,
        **numbers(run_quantities(run)),
        **limits_record(limits, own),
        "limited": {n: json_number(x) for n, x in ({} if constraints is None else constraints.values(run)).items()},
        "trust": None
        if trust is None
        else {
            "verdict": trust.verdict,
            "reason": str(trust),
            "errors": {name: json_number(error) for name, error in trust.errors.items()},
        },
        "outside_validity": [*run.balance.warnings, *mechanism.view.warnings(run)],
        "cautions": cautions(((run.design, run.scenario),), measured=False),
        "larger_force": mechanism.view.larger_force(run),
        "diagnosis": dict(mechanism.view.diagnosis(run)) if run.diagnosis else {},
        f"peak_{mechanism.view.contact}": names.contact(int(run.peak_contact))
        if int(run.impacts.count) and int(run.peak_contact) >= 0
        else None,
        "maximum_times": {name: amount(time, "s") for name, time in run.maximum_times.items()},
        "peak_impact": peak_impact + 1 if peak_impact >= 0 else None,
        "impacts": _impacts(run),
        "energy_at_end": {name: amount(getattr(energy, name), "J") for name in energy.names},
        "numerical_balance": {
            "energy": amount(balance.energy, "-"),
            "linear_momentum": amount(balance.linear_momentum, "-"),
            "angular_momentum": amount(balance.angular_momentum, "-"),
            "constraint_drift": amount(balance.drift, "m"),
        },
        **mechanism.view.record(run),
        "steps_accepted": int(run.accepted),
        "steps_attempted": int(run.attempts),
        "design": part_record(run.design),
        "scenario": part_record(run.scenario),
        "scenario_number": number,
        "jaxbuffer": version(),
    }


def _impacts(run: Run) -> list[dict[str, Any]]:
    """Return a record for each impact."""
    names, contact = run.mechanism.view.names(run.design), run.mechanism.view.contact
    energies = Labelled(("impact",), np.asarray(run.loads("effective_energy")), LOAD_UNITS["effective_energy"])
    touched = np.asarray(run.impacts.contact)
    return [
        {"number": k + 1, contact: names.contact(int(touched[k])), **row}
        for k, row in enumerate(rows(run.impacts.labelled() | {"effective_energy": energies}))
    ]


def limits_record(limits: Limits, own: Mapping[str, CustomQuantity]) -> dict[str, Any]:
    """Return the limits, and what the own quantities are that they may be on."""
    return {
        "limits": dict(limits.at_most),
        "lower_limits": dict(limits.at_least),
        "most_impacts": limits.impacts,
        "require_success": limits.require_success,
        "ends": list(limits.ends),
        "quantities": {
            name: {"unit": it.unit, "function": it.signature, "description": it.description} for name, it in own.items()
        },
    }


def run_history(run: Run) -> Table:
    """Return the history, a row for each accepted step."""
    columns = history_columns(run)
    return list(columns), np.column_stack(list(columns.values())).tolist()


def sensitivity_record(result: Sensitivity) -> dict[str, Any]:
    """Return the quantities, for each parameter its gradients and elasticities, and the certificate."""
    _, rows = sensitivity_rows(result)
    run, catalogue = result.run, result.run.mechanism.quantities
    units = [unit_of(catalogue, name) for name in result.quantities]
    return {
        "kind": run.mechanism.name,
        "outcome": run.outcome.name,
        **amounts(dict(zip(result.quantities, units, strict=True)), result.results),
        "derivatives": [amounts(COLUMNS, row) for row in rows],
        "certificate": None if result.certificate is None else certificate_record(result),
        "advice": [" ".join(line.split()) for line in advice(result)],
        "design": part_record(run.design),
        "scenario": part_record(run.scenario),
        "jaxbuffer": version(),
    }


def certificate_record(result: Sensitivity) -> dict[str, Any]:
    """Return verdicts, what they rest on, active peak and runner-up; errors are relative. Impacts count from 1."""
    certificate: Any = result.certificate
    peaks, mechanism = certificate.peaks, result.run.mechanism
    names = mechanism.view.names(result.run.design)
    evidence = {
        name: {
            quantity: dict(zip(result.paths, map(json_number, getattr(certificate, field)[k]), strict=True))
            for k, quantity in enumerate(result.quantities)
        }
        for name, field in (
            ("estimated_error", "error"),
            ("change_with_tolerance", "by_tolerance"),
            ("distance_from_differences", "by_differences"),
            ("differences_own_uncertainty", "uncertainty"),
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
            "force": amount(peaks.force, "N"),
            "time": amount(peaks.time, "s"),
            mechanism.view.contact: names.contact(peaks.contact),
            "impact": peaks.impact + 1,
        },
        "runner_up": None
        if peaks is None or peaks.runner_up_impact < 0
        else {
            "force": amount(peaks.runner_up_force, "N"),
            "impact": peaks.runner_up_impact + 1,
            "margin": amount(peaks.margin, "-"),
            "swapped_by": peaks.swap_path or None,
            "swapped_by_change": amount(peaks.swap_change, "-"),
        },
    }
