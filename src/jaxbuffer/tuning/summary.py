"""A tuning's summary: before and after, what limits it, where it lies beyond the contact law's validity."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, SupportsFloat

import numpy as np
from rich.table import Table

from ..fields import get
from ..mechanisms.energy import energy_text
from ..tables import table, text
from .message import headline

if TYPE_CHECKING:
    from .tuned import Tuned

SHOWN = 12  # scenarios in a table
FIGURES = {"m": ("mm", 1e3), "rad": ("deg", 180.0 / math.pi)}  # units that people are shown
OWN = 3  # own quantities in that table, in place of the usual ones


def tuned_table(tuned: "Tuned") -> str:
    """The tables as text."""
    return text(*tuned_parts(tuned))


def tuned_parts(tuned: "Tuned") -> list[str | Table]:
    """Before and after: objective, every scenario (the worst ones if there are many), variables, constraints, floor."""
    problem, (start, end) = tuned.problem, tuned.objective
    summary_ = table("Objective and what limits it")
    for heading in ("", "before", "after"):
        summary_.add_column(heading, justify="left" if not heading else "right")
    change = f" ({100.0 * (end / start - 1.0):+.2f} %)" if start > 0.0 else ""
    unit, factor = problem.objective.in_figures(problem.catalogue)
    summary_.add_row(
        f"{problem.worded(problem.objective)} [{unit}]", f"{factor * start:.6g}", f"{factor * end:.6g}{change}"
    )
    if problem.then is not None and tuned.goal.ceiling is not None:
        unit, factor = problem.then.objective.in_figures(problem.catalogue)
        then = [factor * tuned.goal.value(point) for point in (tuned.before, tuned.after)]
        summary_.add_row(f"then {problem.worded(problem.then.objective)} [{unit}]", *(f"{value:.6g}" for value in then))
    points = (tuned.before, tuned.after)
    ended = f"cases {problem.mechanism.success or 'solved'}"
    summary_.add_row(ended, *(f"{int(np.sum(p.succeeded))} of {len(p.code)}" for p in points))
    facts = [
        *_floor_facts(tuned),
        f"evidence at rtol 1e-9: {100.0 * tuned.residual:.2g} % of the objective left to gain by small changes;"
        f" the search's slopes are right to"
        f" {100.0 * tuned.gradient_error:.2g} %; {tuned.captures}"
        f" {problem.mechanism.run_name}s, {tuned.screened} of them without derivatives",
    ]
    facts += [] if tuned.corners is None else tuned.corners.lines(problem)
    facts += tuned_warnings(tuned)
    facts += [f"limit {line}" for line in tuned.why]
    broken = tuned.goal.broken(tuned.after)
    facts += [f"broken: {line}" for line in broken[:SHOWN]]
    facts += [f"and {len(broken) - SHOWN} more" for _ in broken[SHOWN : SHOWN + 1]]
    tables = [summary_, _tuned_cases(tuned), _tuned_variables(tuned)]
    return [headline(tuned.message, tuned.feasible), *tables, *facts]


def tuned_warnings(tuned: "Tuned") -> list[str]:
    """In how many scenarios the tuned design lies beyond a limit of validity, or a quantity still rises at the end of
    the run, and which variables change nothing, a line each."""
    problem, peaks = tuned.problem, tuned.after.quantities[:, 0]
    count: dict[str, int] = {}
    for case, peak in zip(problem.cases, peaks, strict=True):
        for limit in problem.mechanism.validity(case.of(tuned.design), peak):
            count[limit.beyond] = count.get(limit.beyond, 0) + int(np.sum(limit.passed))
    lines = [f"{what} in {n} of {len(problem.cases)} scenarios" for what, n in count.items() if n]
    for name, rising in zip(problem.mechanism.tuned, tuned.after.rising.T, strict=True):
        if n := int(np.sum(rising)):
            where = f"where the {problem.mechanism.run_name} ends, in {n} of {len(problem.cases)} scenarios"
            lines.append(f"{problem.catalogue[name].title} is still rising {where}: it is the largest up to there only")
    for path in tuned.without_effect:
        lines.append(f"without effect: {path} changes nothing, neither at the start nor in the result; leave it out")
    return lines


def _floor_facts(tuned: "Tuned") -> list[str]:
    """The floor of the worst scenario, or that it is not known."""
    floor, cases = tuned.floor, len(tuned.problem.cases)
    if floor is None:
        return []
    if floor.unknown:
        return [
            "floor, the first impact that no buffer softens: unknown, as the first impact can not be simulated in"
            f" {floor.unknown} of {cases} scenarios"
        ]
    return [
        "floor, the first impact in the worst scenario, which no buffer softens:",
        f"  without any buffer {np.max(floor.simulated):.6g} N;"
        f" the tuned peak is {100.0 * tuned.above_floor:+.3f} % above it",
        f"  elastic and frictionless, in closed form {np.max(floor.closed_form):.6g} N,"
        f" from an energy of {energy_text(np.max(floor.energy))} that the contact takes up (effective energy T_c⁻)",
        f"  within the bounds none gets below {floor.lowest:.6g} N",
    ]


def _tuned_cases(tuned: "Tuned") -> Table:
    """The largest peak, the own quantities or else those drawn of a sweep that are tuned, impacts and outcomes."""
    problem, before, after = tuned.problem, tuned.before, tuned.after
    mechanism, catalogue, count = problem.mechanism, problem.catalogue, len(problem.cases)
    cases = table("Scenarios" if count <= SHOWN else f"The {SHOWN} of {count} scenarios with the largest peak force")
    cases.add_column("scenario")
    usual = [name for name in mechanism.defaults.mapped[1:3] if name in problem.names]
    others = list(problem.quantities)[:OWN] or usual
    headings = ["peak force [N]", "change"]
    for name in others:
        quantity = catalogue[name]
        headings.append(f"{quantity.title} [{quantity.in_figures[0]}]")
    for heading in (*headings, "impacts", "before", "after"):
        cases.add_column(heading, justify="left" if heading in ("before", "after") else "right")
    first, last = before.quantities, after.quantities
    highest = np.argsort(-last[:, 0], kind="stable")
    for k in highest[:SHOWN] if count > SHOWN else range(count):
        shown = []
        for name in others:
            factor, q = catalogue[name].in_figures[1], problem.names.index(name)
            shown.append(f"{factor * first[k, q]:.4g} → {factor * last[k, q]:.4g}")
        cases.add_row(
            problem.cases[k].label(problem.cases),
            *_change(first[k, 0], last[k, 0]),
            *shown,
            f"{before.impacts[k]} → {after.impacts[k]}",
            mechanism.outcomes(int(before.code[k])).name,
            mechanism.outcomes(int(after.code[k])).name,
        )
    return cases


def _tuned_variables(tuned: "Tuned") -> Table:
    variables = table("Variables")
    variables.add_column("field")
    for heading in ("before", "tuned", "low", "high", "unit"):
        variables.add_column(heading, justify="left" if heading == "unit" else "right")
    variables.add_column("")
    problem = tuned.problem
    for variable in problem.variables:
        start, value = (float(get(design, variable.path)) for design in (problem.design, tuned.design))
        numbers = [problem.shown(variable.path, x) for x in (start, value, variable.low, variable.high)]
        texts = [f"{number:.5g}" for number, _ in numbers]
        variables.add_row(variable.path, *texts, numbers[0][1], variable.at_bound(value))
    return variables


def _change(before: SupportsFloat, after: SupportsFloat) -> tuple[str, str]:
    before, after = float(before), float(after)
    return f"{before:.5g} → {after:.5g}", f"{100.0 * (after / before - 1.0):+.1f} %"


def objective_in_words(value: float, unit: str, digits: int) -> str:
    """An objective's value in the unit that people are shown: "7.1 mm"."""
    symbol, factor = FIGURES.get(unit, (unit, 1.0))
    return f"{factor * value:.{digits}g} {symbol}".rstrip(" -")


def in_words(it: Mapping[str, Any], success: str | None = None, most: int | None = None) -> str:
    """One evaluation of a tuning on one line; ``success``: how runs should end, as the mechanism calls it; ``most``
    evaluations that there can be."""
    count = "" if most is None else f"{it['evaluation'] + 1} of at most {most}, "
    where = "start" if it["status"] == "start" else f"search {it['search'] + 1}, step {it['step']}"
    stage = "then, " if it["stage"] else ""
    text = f"{count}{stage}{where}: {objective_in_words(it['objective'], it['unit'], 5)}"
    if not it["feasible"]:
        met = it["succeeded"]
        text += "" if all(met) else f", {sum(met)} of {len(met)} {success or 'solved'}"
        text += ", limits broken"
    return text + ("" if it["residual"] is None else f", {100.0 * it['residual']:.2g} % left to gain")
