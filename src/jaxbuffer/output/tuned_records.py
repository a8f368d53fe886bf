"""A tuned design and a front as rows and records."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from ..fields import get, unit
from ..labelled.record import amount, amounts, headings, json_number, part_record
from ..tuning.problem.cases import Case
from ..tuning.problem.problem import Problem
from ..tuning.report.front import Front, point_status
from ..tuning.report.levers import levers_record
from ..tuning.report.limits_in_the_way import first_impact_levers
from ..tuning.report.message import headline
from ..tuning.report.tuned import SHOWN, Tuned, tuned_warnings
from ..tuning.search.evaluation import Evaluation, main_values
from ..tuning.tolerances.spread import CAPTION, spread_headings, spread_lines, spread_rows
from ..value_text import with_unit
from ..version import version
from .records import Table, limits_record


def tuned_record(tuned: Tuned) -> dict[str, Any]:
    """Return the result: problem, objective, lower bound, evidence, and every scenario before and after at tight
    tolerance."""
    problem, (start, end), bound = tuned.problem, tuned.objective, tuned.lower_bound
    lowest = None if bound is None else bound.lowest
    levers = [] if bound is None else first_impact_levers(problem, bound, tuned.after)
    return {
        "kind": problem.mechanism.name,
        "identity": tuned.identity,
        "message": tuned.message,
        "converged": tuned.converged,
        "ended": tuned.ended,
        "confirmed": tuned.confirmed,
        "feasible": tuned.feasible,
        "broken_limits": tuned.broken_limits,
        "broken": tuned.goal.broken(tuned.after),
        "outside_validity": tuned_warnings(tuned),
        "objective": problem.format(problem.objective),
        "objective_unit": problem.objective.unit(problem.catalogue),
        "objective_before": json_number(start),
        "objective_after": json_number(end),
        "first_order_residual": amount(tuned.residual, "-"),
        "gradient_error": amount(tuned.gradient_error, "-"),
        "rtol_of_check": amount(tuned.tight, "-"),
        "above_lower_bound": amount(tuned.above_lower_bound, "-"),
        "lowest_first_impact_within_bounds": amount(lowest, "N"),
        "first_impact_levers": [line.strip() for line in levers],
        "levers": levers_record(tuned.levers),
        "captures": tuned.captures,
        "settings": dataclasses.asdict(tuned.settings),
        "variables": _variables(tuned),
        **limits_record(problem.limits, problem.quantities),
        "scenarios": _scenarios(tuned),
        **_scattered(tuned),
        "design": part_record(tuned.design),
        "jaxbuffer": version(),
    }


def _variables(tuned: Tuned) -> list[dict[str, Any]]:
    """Return each variable's bounds, and its values before and after."""
    problem = tuned.problem
    return [
        {
            "path": v.path,
            "low": v.low,
            "high": v.high,
            "scale": v.scale,
            "before": get(problem.design, v.path),
            "value": get(tuned.design, v.path),
            "display_unit": problem.shown(v.path, 0.0)[1],  # the numbers beside it are in SI units
        }
        for v in problem.variables
    ]


def _scenarios(tuned: Tuned) -> list[dict[str, Any]]:
    """Return each load case, its lower bound, and its numbers before and after."""
    points = (tuned.before, tuned.after)
    before_and_after = (case_records(tuned.problem, point, tuned.reported(point)) for point in points)
    each = zip(tuned.problem.cases, _lower_bounds(tuned), *before_and_after, strict=True)
    return [
        {
            "number": tuned.problem.number_text(k),
            **part_record(case.scenario),
            **built_record(case),
            **lower_bound,
            "before": before,
            "after": after,
        }
        for k, (case, lower_bound, before, after) in enumerate(each)
    ]


def built_record(case: Case) -> dict[str, Any]:
    """Return how a load case has the mechanism built."""
    others = {"shifts": dict(case.shifts), "values": dict(case.values)}
    return {"factors": dict(case.factors), **{name: it for name, it in others.items() if it}}


def _scattered(tuned: Tuned) -> dict[str, Any]:
    """Return what scatters, the result in the corners of that, and whose scatter matters."""
    problem, corners = tuned.problem, tuned.corners
    if corners is None:
        return {}
    record = scatter_record(problem) | ({"spread": _spread(tuned)} if problem.tolerances else {})
    each = zip(corners.cases, corners.values, corners.broken, strict=True)
    return record | {
        "corners": {
            "lines": corners.lines(problem),
            "of": corners.what,
            "run": len(corners.cases),
            "all": corners.whole,
            "searched": corners.searched,
            "holding": corners.holding,
            "holds": corners.hold,
            "largest_objective": json_number(corners.largest),
            "objective_in_the_middle": json_number(corners.middle),
            "each": [
                {**part_record(case.scenario), **built_record(case), "objective": json_number(value), "broken": broken}
                for case, value, broken in each
            ],
        },
    }


def scatter_record(problem: Problem) -> dict[str, Any]:
    """Return what scatters: samples and tolerances, of those that a problem has."""
    record, scatter = dict[str, Any](), problem.scatter
    if scatter is not None:
        ranges = {name: [given.kind, *given.range] for name, given in scatter.distributions.items()}
        record["sample"] = {"count": scatter.count, "seed": scatter.seed, "ranges": ranges}
    if problem.tolerances:
        record["tolerances"] = {
            address: {**dataclasses.asdict(it), "in_words": problem.tolerance_text(address)}
            for address, it in problem.tolerances.items()
        }
    return record


def _spread(tuned: Tuned) -> dict[str, Any]:
    """Return which tolerances matter, in words and in numbers."""
    problem, spreads = tuned.problem, tuned.spreads
    return {
        "caption": CAPTION,
        "headings": ["field", "tolerance", *spread_headings(problem, spreads)],
        "rows": spread_rows(problem, spreads),
        "lines": spread_lines(problem, spreads, tuned.tightening),
        "each": [
            {
                "quantity": it.name,
                "unit": problem.catalogue[it.name].unit,
                "as_drawn": json_number(it.drawn),
                "in_corners": [json_number(it.low), json_number(it.high)],
                "changes": dict(zip(problem.tolerances, map(json_number, it.effects), strict=True)),
                "shares": dict(zip(problem.tolerances, map(json_number, it.shares), strict=True)),
                "error": json_number(it.error),
                "trusted": it.trusted,
            }
            for it in spreads
        ],
    }


def _lower_bounds(tuned: Tuned) -> list[dict[str, Any]]:
    """Return what is known of each case's first impact."""
    lower_bound = tuned.lower_bound
    if lower_bound is None:
        return [{} for _ in tuned.problem.cases]
    units = {"lower_bound": "N", "closed_form_first_peak": "N", "T_c": "J"}
    rows = zip(lower_bound.simulated, lower_bound.closed_form, lower_bound.energy, strict=True)
    return [amounts(units, row) for row in rows]


def case_records(
    problem: Problem, point: Evaluation, values: Float[np.ndarray, "cases quantities"]
) -> list[dict[str, Any]]:
    """Return a record for each load case: outcome, impacts, the problem's quantities (``values``) and the margin."""
    units, margin = {name: problem.catalogue[name].unit for name in problem.names}, problem.mechanism.tuning.margin
    if problem.end is not None and problem.end.quantity:  # then the margin is that of this end
        margin = None
    return [
        {
            "outcome": problem.mechanism.outcomes(int(code)).name,
            "impacts": int(impacts),
            **({} if problem.peak_quantity is None else {"first_peak": amount(first, "N")}),
            **amounts(units, row),
            **({} if margin is None else {margin: amount(room, problem.catalogue[margin].unit)}),
        }
        for code, impacts, first, row, room in zip(
            point.code, point.impacts, point.first, values, point.margin, strict=True
        )
    ]


def tuned_comment(tuned: Tuned) -> str:
    """Return what the tuned design's file says of its origin."""
    problem, (start, end) = tuned.problem, tuned.objective
    limits = problem.limits.lines(problem.catalogue)
    before, after = (with_unit(*problem.objective.shown(value, problem.catalogue)) for value in (start, end))
    lines = [
        f"{headline(tuned.message, tuned.goal.feasible(tuned.after), tuned.end_count(tuned.after))}.",
        f"By jaxbuffer {version()} with {tuned.captures} {problem.mechanism.view.run_name}s.",
        f"Simulated up to {problem.duration:g} s at rtol {problem.rtol:g}; {', '.join(limits) or 'no limits'}.",
        f"{problem.format(problem.objective)}, before and after: {before}, {after}.",
    ]
    main, (unit, factor) = problem.main_quantity, problem.catalogue[problem.main_quantity].in_figures
    for k in range(min(len(problem.cases), SHOWN)):
        values = (with_unit(factor * float(main_values(problem, it)[k]), unit) for it in (tuned.before, tuned.after))
        lines.append(f"  {main} at {problem.label(k)}: {', '.join(values)}")
    return "\n".join(lines)


def front_record(front: Front) -> dict[str, Any]:
    """Return the front's points, as in pareto.csv."""
    _, rows = front_rows(front)
    units = _front_units(front)
    return {
        "kind": front.problem.mechanism.name,
        "identity": front.identity,
        "objectives": list(front.objectives),
        "scenarios": len(front.problem.cases),
        "samples": front.problem.samples,
        "points": [amounts(units, row) for row in rows],
        "design": part_record(front.problem.design),
        "jaxbuffer": version(),
    }


def front_rows(front: Front) -> Table:
    """Return a row for each point."""
    problem = front.problem
    rows: list[Sequence[Any]] = []
    for k, (point, values, limits) in enumerate(zip(front.points, front.values, front.limits, strict=True)):
        # A point without a limit has an infinite one, which JSON lacks.
        finite = [None if np.isinf(limit) else float(limit) for limit in limits]
        status = [
            json_number(point.residual),
            json_number(point.gradient_error),
            point.converged,
            point_status(front, k),
        ]
        variables = [float(get(point.design, v.path)) for v in problem.variables]
        rows.append([k + 1, *map(float, values), *finite, *status, *variables])
    return headings(_front_units(front)), rows


def _front_units(front: Front) -> dict[str, str]:
    """Return the unit of each column of a front's points, by name."""
    problem, catalogue = front.problem, front.problem.catalogue
    return {
        "point": "",
        **{f"worst {name}": catalogue[name].unit for name in front.objectives},
        **{f"limit of {name}": catalogue[name].unit for name in front.objectives[1:]},
        **{"first_order_residual": "-", "gradient_error": "-", "converged": "", "status": ""},
        **{v.path: unit(problem.design, v.path) for v in problem.variables},
    }
