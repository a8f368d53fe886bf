"""The result of a tuning, and its tables."""

import dataclasses
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from rich.table import Table

from ..._types import DataFrame
from ...fields import Part, get, unit
from ...labelled.arrays import frame
from ...labelled.record import headings
from ...labelled.saved import Saved
from ...mechanisms.energy import energy_text
from ...mechanisms.mechanism import EndCount
from ...tables import html, table, text
from ...value_text import before_and_after, change_text, number_text, percent_text, relative_change
from ..problem.problem import Problem
from ..problem.settings import Settings
from ..search.checks import PeakForceBound
from ..search.evaluation import Evaluation, main_values, validity_lines
from ..search.goal import Goal
from ..search.store import Record
from ..tolerances.corners import Corners
from ..tolerances.spread import Spread, Tightening, spread_lines, spread_table
from .broken_limits import broken_limits
from .levers import ASK, DECIDING, Lever, Levers, lever_table, tuned_levers
from .limits_in_the_way import first_impact_levers, limits_in_the_way
from .message import SearchReport, headline

SHOWN = 12  # scenarios in a table
OWN = 3  # own quantities in that table, in place of the usual ones


@dataclasses.dataclass(frozen=True)
class Tuned(Saved):
    """A finished tuning. Print it for tables.

    - ``problem``, ``settings``: the arguments of the tuning.
    - ``goal``: of the last stage.
    - ``design``: the best one.
    - ``before``, ``after``: start and result in every load case at rtol ``tight`` [-], with derivatives.
    - ``residual``: what first-order information there still predicts to gain within a tenth of every range, relative to
      the objective [-].
    - ``gradient_error``: difference between the objective's slopes at the search's tolerance and there, relative to the
      largest [-].
    - ``ended``: how the search ended, a name of `message.Ended`; ``confirmed``: whether an independent search agrees;
      ``message``: both in words.
    - ``lower_bound``: first impacts, which no buffer softens; None where the mechanism has no such lower bound.
    - ``records``: every evaluation, as in the log.
    - ``captures``: solved in all, the last check included, those for ``others`` left out.
    - ``corners``: the design in the corners of the tolerances and of the ranges that the problem scatters over; None
      where there are none of either.
    - ``spreads``: the scatter of the objective's and of each limited quantity by tolerances; ``tightening``: which
      tolerance to tighten first; none without tolerances.
    - ``missing``: a line for each part of the evidence that could not be computed.
    - ``report``: what the search says of itself, of which ``message`` is made; None for a tuning without a search.
    - ``others``: levers of the limits that are no variables; none where they were not asked for.
    - ``identity``: a hash of all that makes it the tuning it is, as its folder has it; "" where that is not known.

    **Example:**

    >>> problem = jb.Problem(jb.table2(), [jb.Scenario()], [jb.Variable("buffer.k_A", 100.0, 2000.0)])
    >>> tuned = jb.tune(problem, iterations=2, starts=1)
    >>> print(f"{jb.get(tuned.design, 'buffer.k_A'):.0f} N/m, feasible: {tuned.feasible}")
    405 N/m, feasible: True
    """

    problem: Problem
    settings: Settings
    goal: Goal
    design: Part
    before: Evaluation
    after: Evaluation
    residual: float
    gradient_error: float
    ended: str
    confirmed: bool
    message: str
    lower_bound: PeakForceBound | None
    records: tuple[Record, ...]
    captures: int
    corners: Corners | None = None
    spreads: tuple[Spread, ...] = ()
    tightening: Tightening | None = None
    tight: float = 1e-9
    identity: str = ""
    missing: tuple[str, ...] = ()
    report: SearchReport | None = None
    others: Levers = dataclasses.field(default_factory=dict)

    @property
    def objective(self) -> tuple[float, float]:
        """Return the problem's objective [N], before and after."""
        first = Goal(self.problem, self.problem.objective)
        return first.value(self.before), first.value(self.after)

    @property
    def worst(self) -> Part:
        """Return the scenario, without tolerances, where the main quantity, the peak force mostly, is largest with the
        tuned design."""
        largest = int(np.argmax(main_values(self.problem, self.after)))
        return self.problem.drawn[self.problem.number(largest) - 1].scenario

    @property
    def screened(self) -> int:
        """Return how many of the captures were solved without derivatives."""
        # A lone start needs no screening, and is run with derivatives at once.
        alone = self.settings.starts == 1
        return 0 if alone else sum(len(it["outcome"]) for it in self.records if it["status"] == "start")

    @property
    def converged(self) -> bool:
        """Return whether the search ended because no larger reduction than its tolerance was left to gain."""
        return self.ended == "converged"

    @property
    def feasible(self) -> bool:
        """Return whether every constraint holds in the result, in every load case and in every corner of what
        scatters."""
        return self.goal.feasible(self.after) and (self.corners is None or self.corners.hold)

    @property
    def inactive_variables(self) -> tuple[str, ...]:
        """Return the paths of variables that change no quantity of any load case, neither at the start nor in the
        result."""
        points = (self.before, self.after)
        slopes = [slope for point in points for slope in (point.quantities_slope[point.solved], point.margin_slope)]
        # Slopes must be exactly zero in all cases of both designs: a small one is an effect.
        still = np.all([np.all(slope == 0.0, axis=tuple(range(slope.ndim - 1))) for slope in slopes], axis=0)
        return tuple(path for path, none in zip(self.problem.paths, still, strict=True) if none)

    @property
    def broken_limits(self) -> list[str]:
        """Return a line for each limit that an infeasible result breaks, the worst first; none for a feasible one.

        A line says in how many scenarios, how far, and which variables hold the result back to first order.
        """
        lines = [str(limit) for limit in broken_limits(self.goal, self.after, self.lower_bound)]
        if self.corners is not None and not self.corners.hold:
            lines.append(self.corners.verdict)
        return lines

    @property
    def levers(self) -> dict[str, list[Lever]]:
        """Return the three strongest levers of each limited quantity, of the objective and of the first impact, by
        name: those among the variables, then the ``others``."""
        return tuned_levers(self.goal, self.after, self.lower_bound, self.others)

    @property
    def above_lower_bound(self) -> float:
        """Return how far the worst peak is above the lower bound of its own first impacts, relative [-].

        It is NaN without a lower bound, and where nothing touches.
        """
        above = (
            None
            if self.lower_bound is None
            else relative_change(self.lower_bound.highest, float(np.max(self.after.peak_force)))
        )
        return float("nan") if above is None else above

    def reported(self, point: Evaluation) -> Float[np.ndarray, "cases quantities"]:
        """Return the quantities of `before` or `after` in the order of `Problem.names`: NaN where a run waited for one
        in vain."""
        return np.where(self.problem.known(point.code), point.quantities, np.nan)

    def end_count(self, point: Evaluation) -> EndCount | None:
        """Return in how many load cases the strictest end was reached that the design can have; None where there is
        none.

        ``point``: `before` or `after`.
        """
        counts = Counter(self.problem.mechanism.outcomes(int(code)).name for code in point.code)
        return self.problem.mechanism.end_count(lambda path: get(self.design, path), counts)

    def to_dataframe(self) -> DataFrame:
        """Return a row for each evaluated design, as in history.csv: objective, worst values, variables."""
        return frame(*tuning_history(self))

    def __repr__(self) -> str:
        return tuned_table(self)

    def _repr_html_(self) -> str:
        return html(*tuned_parts(self))


def tuned_table(tuned: Tuned) -> str:
    """Return the tables as text."""
    return text(*tuned_parts(tuned))


def tuned_parts(tuned: Tuned) -> list[str | Table]:
    """Return a headline, tables of objective, scenarios and variables before and after, and lines about the result."""
    problem = tuned.problem
    lines = [
        *_floor_facts(tuned),
        f"evidence at rtol {tuned.tight:g}: {percent_text(tuned.residual)} of the objective left to gain by small"
        f" changes; the search's slopes are right to {percent_text(tuned.gradient_error)}; {tuned.captures}"
        f" {problem.mechanism.view.run_name}s, {tuned.screened} of them without derivatives",
    ]
    lines += [] if tuned.corners is None else tuned.corners.lines(problem)
    lines += spread_lines(problem, tuned.spreads, tuned.tightening)
    lines += [] if tuned.others else [ASK]
    lines += tuned_warnings(tuned)
    lines += [f"limit {line}" for line in broken_limits(tuned.goal, tuned.after, tuned.lower_bound)]
    broken = tuned.goal.broken(tuned.after)
    lines += [f"broken: {line}" for line in broken[:SHOWN]]
    # A slice of one: the line is there only where some are left out.
    lines += [f"and {len(broken) - SHOWN} more" for _ in broken[SHOWN : SHOWN + 1]]
    limits = limits_in_the_way(tuned.goal, tuned.after, tuned.lower_bound, tuned.inactive_variables)
    where = DECIDING if len(problem.cases) > 1 else ""
    tables = [limits, lever_table(tuned.levers, problem.catalogue, where), _tuned_objective(tuned)]
    tables += [_tuned_cases(tuned), _left_open(tuned), _tuned_variables(tuned)]
    tables.append(spread_table(problem, tuned.spreads))
    first = headline(tuned.message, tuned.goal.feasible(tuned.after), tuned.end_count(tuned.after))
    return [first, *(it for it in tables if it is not None), *lines]


def _tuned_objective(tuned: Tuned) -> Table:
    """Return the objectives and the load cases that succeed, before and after."""
    problem, (start, end) = tuned.problem, tuned.objective
    summary = table("Objective", ("",), ("before", "after"))
    change = "" if relative_change(start, end) is None else f" ({change_text(start, end, '+.2f')})"
    unit, factor = problem.objective.in_figures(problem.catalogue)
    summary.add_row(
        f"{problem.format(problem.objective)} [{unit}]", f"{factor * start:.6g}", f"{factor * end:.6g}{change}"
    )
    if problem.then is not None and tuned.goal.ceiling is not None:
        unit, factor = problem.then.objective.in_figures(problem.catalogue)
        then = [factor * tuned.goal.value(point) for point in (tuned.before, tuned.after)]
        summary.add_row(f"then {problem.format(problem.then.objective)} [{unit}]", *(f"{value:.6g}" for value in then))
    if (corners := tuned.corners) is not None:
        # The design in the corners and as drawn, or in the middle of the ranges.
        unit, factor = problem.objective.in_figures(problem.catalogue)
        cases = len(corners.cases)
        summary.add_row(f"largest in {cases} corners [{unit}]", "", f"{factor * corners.largest:.6g}")
        summary.add_row(f"{corners.middle_title} [{unit}]", "", f"{factor * corners.middle:.6g}")
        summary.add_row("corners in which the design holds", "", f"{corners.holding} of {cases}")
    points = (tuned.before, tuned.after)
    succeeded = f"cases {problem.success or 'solved'}"
    summary.add_row(succeeded, *(f"{int(np.sum(p.succeeded))} of {len(p.code)}" for p in points))
    counts = [count for point in points if (count := tuned.end_count(point)) is not None]
    if counts and counts[0].name != problem.success:
        summary.add_row(f"cases {counts[0].name}", *(f"{count.reached} of {count.runs}" for count in counts))
    return summary


def tuned_warnings(tuned: Tuned) -> list[str]:
    """Return a line for each part of the evidence that is missing, and for each validity limit that the tuned design
    exceeds.

    Lines follow on what the runs leave open, and on each variable that changes nothing.
    """
    problem = tuned.problem
    lines = [*tuned.missing, *validity_lines(problem, tuned.design, tuned.after)]
    if problem.mechanism.tuning.unfinished is not None:
        lines += problem.mechanism.tuning.unfinished(problem, tuned.after)
    lines += unasked_end(tuned)
    for path in tuned.inactive_variables:
        lines.append(f"without effect: {path} changes nothing, neither at the start nor in the result; leave it out")
    return lines


def unasked_end(tuned: Tuned) -> list[str]:
    """Return a line where runs could have a stricter end than the problem asks for and not all have it; else none."""
    problem, before, after = tuned.problem, tuned.end_count(tuned.before), tuned.end_count(tuned.after)
    if before is None or after is None or after.complete or after.name == problem.success:
        return []
    # Where no end is asked for, none is missed.
    if not problem.limits.require_success:
        return []
    earlier = f", {before.reached} before" if before.reached != after.reached else ""
    name = after.name
    return [
        f"{name} is not asked for: {after.reached} of {after.runs} are {name}{earlier}; {name} = true among the"
        " constraints asks for it"
    ]


def _floor_facts(tuned: Tuned) -> list[str]:
    """Return lines about the lower bound of the worst scenario, or one that says that it is not known."""
    lower_bound, cases = tuned.lower_bound, len(tuned.problem.cases)
    if lower_bound is None:
        return []
    if lower_bound.unknown:
        return [
            "lower bound, the first impact that no buffer softens: unknown, as the first impact can not be simulated in"
            f" {lower_bound.unknown} of {cases} scenarios"
        ]
    heading = "lower bound, the first impact in the worst scenario, which no buffer softens:"
    if not lower_bound.highest > 0.0:
        return [heading, "  none: nothing is touched"]
    above, closed = tuned.above_lower_bound, float(np.max(lower_bound.closed_form))
    beyond = f"; the tuned peak is {percent_text(above, '+.3f')} above it" if np.isfinite(above) else ""
    lowest = f"  within the bounds none gets below {lower_bound.lowest:.6g} N"
    lines = [heading, f"  without any buffer {lower_bound.highest:.6g} N{beyond}"]
    if np.isfinite(closed):  # a free start has no closed form
        lines.append(
            f"  elastic and frictionless, in closed form {closed:.6g} N,"
            f" from an energy of {energy_text(np.max(lower_bound.energy))} that the contact takes up"
            " (effective energy T_c⁻)"
        )
    return [*lines, lowest, *first_impact_levers(tuned.problem, lower_bound, tuned.after)]


def _tuned_cases(tuned: Tuned) -> Table:
    """Return each load case's main quantity, some other quantities, impacts and outcome, before and after.

    The other quantities are the problem's own, or else those of the mechanism's map of a sweep that can be tuned.
    """
    problem, before, after = tuned.problem, tuned.before, tuned.after
    mechanism, catalogue, count = problem.mechanism, problem.catalogue, len(problem.cases)
    main, words = problem.main_quantity, problem.main_quantity.replace("_", " ")
    title = "Scenarios" if count <= SHOWN else f"The {SHOWN} of {count} scenarios with the largest {words}"
    # Without the first, which has columns of its own.
    usual = [name for name in mechanism.defaults_for(problem.design).mapped[:3] if name in problem.names]
    others = [name for name in list(problem.quantities)[:OWN] or usual if name != main]
    headings = (f"{catalogue[name].title} [{catalogue[name].in_figures[0]}]" for name in others)
    unit, factor = catalogue[main].in_figures
    cases = table(title, ("scenario",), (f"{words} [{unit}]", "change", *headings, "impacts"))
    for heading in ("before", "after"):
        cases.add_column(heading)
    for k in _shown_cases(tuned):
        start, end = (factor * float(main_values(problem, point)[k]) for point in (before, after))
        cases.add_row(
            problem.label(k),
            before_and_after(start, end, 5),
            change_text(start, end),
            *(_before_and_after(tuned, name, k) for name in others),
            f"{before.impacts[k]} → {after.impacts[k]}",
            mechanism.outcomes(int(before.code[k])).name,
            mechanism.outcomes(int(after.code[k])).name,
        )
    return cases


def _left_open(tuned: Tuned) -> Table | None:
    """Return what the runs of each load case leave open, before and after; None where nothing is known of that, or all
    runs reach the strictest end, which leaves nothing open."""
    problem, mechanism = tuned.problem, tuned.problem.mechanism
    counts = [tuned.end_count(point) for point in (tuned.before, tuned.after)]
    if all(count is not None and count.complete for count in counts):
        return None
    names = [name for name in mechanism.tuning.left_open(lambda path: get(tuned.design, path)) if name in problem.names]
    if not names:
        return None
    quantities = [problem.catalogue[name] for name in names]
    headings = tuple(f"{it.title} [{it.in_figures[0]}]" for it in quantities)
    left = table(f"What is left where the {mechanism.view.run_name} ends", ("scenario",), headings)
    for k in _shown_cases(tuned):
        values = (_before_and_after(tuned, name, k) for name in names)
        left.add_row(problem.label(k), *values)
    return left


def _shown_cases(tuned: Tuned) -> Sequence[int]:
    """Return the numbers of all load cases or, of many, of those where the main quantity is largest."""
    count = len(tuned.problem.cases)
    if count <= SHOWN:
        return range(count)
    return np.argsort(-main_values(tuned.problem, tuned.after), kind="stable")[:SHOWN].tolist()


def _before_and_after(tuned: Tuned, name: str, case: int) -> str:
    """Return a quantity of a load case before and after, in its unit in figures."""
    problem = tuned.problem
    factor, q = problem.catalogue[name].in_figures[1], problem.names.index(name)
    return before_and_after(*(factor * tuned.reported(point)[case, q] for point in (tuned.before, tuned.after)))


def _tuned_variables(tuned: Tuned) -> Table:
    """Return each variable's value before and after, and its bounds."""
    variables = table("Variables", ("field",), ("before", "tuned", "low", "high"))
    for heading in ("unit", ""):
        variables.add_column(heading)
    problem = tuned.problem
    for variable in problem.variables:
        start, value = (float(get(design, variable.path)) for design in (problem.design, tuned.design))
        numbers = [problem.shown(variable.path, x) for x in (start, value, variable.low, variable.high)]
        texts = [number_text(number, 5) for number, _ in numbers]
        variables.add_row(variable.path, *texts, numbers[0][1], variable.at_bound(value))
    return variables


def tuning_history(tuned: Tuned) -> tuple[list[str], list[Sequence[Any]]]:
    """Return a header and a row for each evaluated design, with its worst values over the scenarios.

    ``unit``: that of the stage's objective.
    """
    problem = tuned.problem
    plain = ("evaluation", "stage", "search", "step", "accepted", "feasible", "captures", "status", "objective", "unit")
    numbers = ("excess", "radius", "residual")
    units = dict.fromkeys(plain, "") | dict.fromkeys(numbers, "-")
    units |= {f"worst {name}": problem.catalogue[name].unit for name in problem.names}
    units |= {v.path: unit(problem.design, v.path) for v in problem.variables}
    rows: list[Sequence[Any]] = []
    for it in tuned.records:
        row = [it[name] for name in (*plain, *numbers)]
        # A time that one scenario waited for in vain has no worst value.
        row += [None if None in it[name] else max(it[name]) for name in problem.names]
        rows.append([*row, *(it["values"][v.path] for v in problem.variables)])
    return headings(units), rows
