"""A tuning's summary: before and after, what limits it, where it lies beyond the contact law's validity."""

from typing import TYPE_CHECKING, SupportsFloat

import numpy as np
from rich.table import Table

from ..mechanisms import get, unit
from ..outcome import Outcome
from ..tables import table as _table
from ..tables import text as _text
from ..validity import of_peaks
from .problem import Variable

if TYPE_CHECKING:
    from .tuned import Tuned

SHOWN = 12  # scenarios in a table


def tuned_table(tuned: "Tuned") -> str:
    """Before and after: objective, every scenario (the worst ones if there are many), variables, constraints, floor."""
    problem, (start, end) = tuned.problem, tuned.objective
    summary_ = _table("Objective and what limits it")
    for heading in ("", "before", "after"):
        summary_.add_column(heading, justify="left" if not heading else "right")
    summary_.add_row(f"{problem.objective} [N]", f"{start:.6g}", f"{end:.6g} ({100.0 * (end / start - 1.0):+.2f} %)")
    if problem.then is not None and tuned.goal.ceiling is not None:
        then = [tuned.goal.value(point) for point in (tuned.before, tuned.after)]
        summary_.add_row(f"then {problem.then.objective} [N]", *(f"{value:.6g}" for value in then))
    for text, points in (("cases captured", (tuned.before, tuned.after)),):
        summary_.add_row(text, *(f"{int(np.sum(p.captured))} of {len(p.code)}" for p in points))
    facts = [
        *_floor_facts(tuned),
        f"evidence: first-order residual {tuned.residual:.1e} at rtol 1e-9,"
        f" slopes of the search within {tuned.gradient_error:.1e} of it; {tuned.captures} captures,"
        f" {tuned.screened} of them without derivatives",
    ]
    facts += [f"outside the contact law's validity: {line}" for line in tuned_warnings(tuned)]
    broken = tuned.goal.broken(tuned.after)
    facts += [f"broken: {line}" for line in broken[:SHOWN]]
    tables = [summary_, _tuned_cases(tuned), _tuned_variables(tuned)]
    return _text(f"Tuned: {tuned.message}", *tables, *facts)


def tuned_warnings(tuned: "Tuned") -> list[str]:
    """In how many scenarios the tuned design lies beyond what the contact law is good for, a line each reason."""
    problem, peaks = tuned.problem, tuned.after.quantities[:, 0]
    found = [of_peaks(case.of(tuned.design), peak) for case, peak in zip(problem.cases, peaks, strict=True)]
    lines = []
    for beyond, what in (
        (sum(bool(v.too_deep) for v in found), "the tip goes deeper into a flank than a tenth of its radius"),
        (sum(bool(v.yields) for v in found), "the materials yield"),
    ):
        if beyond:
            lines.append(f"{what} in {beyond} of {len(found)} scenarios")
    return lines


def _floor_facts(tuned: "Tuned") -> list[str]:
    """The floor of the worst scenario, or that it is not known."""
    floor, cases = tuned.floor, len(tuned.problem.cases)
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
        f" from T_c⁻ {1e3 * np.max(floor.energy):.4g} mJ at the tip",
        f"  within the bounds none gets below {floor.lowest:.6g} N",
    ]


def _tuned_cases(tuned: "Tuned") -> Table:
    problem, before, after = tuned.problem, tuned.before, tuned.after
    count = len(problem.cases)
    title = "Scenarios" if count <= SHOWN else f"The {SHOWN} worst of {count} scenarios"
    table = _table(title)
    table.add_column("scenario")
    for heading in (
        "peak force [N]",
        "change",
        "hinge force [N]",
        "change",
        "stroke [mm]",
        "impacts",
        "before",
        "after",
    ):
        table.add_column(heading, justify="left" if heading in ("before", "after") else "right")
    first, last = before.quantities, after.quantities
    worst = sorted(np.argsort(-last[:, 0], kind="stable")[:SHOWN])
    for k in worst:
        table.add_row(
            problem.cases[k].label(problem.cases),
            *_change(first[k, 0], last[k, 0]),
            *_change(first[k, 1], last[k, 1]),
            f"{1e3 * first[k, 3]:.4g} → {1e3 * last[k, 3]:.4g}",
            f"{before.impacts[k]} → {after.impacts[k]}",
            Outcome(int(before.code[k])).name,
            Outcome(int(after.code[k])).name,
        )
    return table


def _tuned_variables(tuned: "Tuned") -> Table:
    table = _table("Variables")
    table.add_column("field")
    for heading in ("before", "tuned", "low", "high", "unit"):
        table.add_column(heading, justify="left" if heading == "unit" else "right")
    table.add_column("")
    problem = tuned.problem
    for variable in problem.variables:
        start, value = (float(get(design, variable.path)) for design in (problem.design, tuned.design))
        numbers = [f"{x:.5g}" for x in (start, value, variable.low, variable.high)]
        table.add_row(variable.path, *numbers, unit(problem.design, variable.path), _at_bound(variable, value))
    return table


def _change(before: SupportsFloat, after: SupportsFloat) -> tuple[str, str]:
    before, after = float(before), float(after)
    return f"{before:.5g} → {after:.5g}", f"{100.0 * (after / before - 1.0):+.1f} %"


def _at_bound(variable: Variable, value: float) -> str:
    near = 1e-6 * (variable.high - variable.low)
    return "at low bound" if value <= variable.low + near else "at high bound" if value >= variable.high - near else ""
