"""Which tolerance matters: the share of each in the scatter of what is limited, and which one to tighten first."""

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from rich.table import Table

from ...tables import table
from ...value_text import is_plain, percent_text, range_text
from ..problem.problem import Problem
from ..problem.tolerances import moved
from ..search.evaluation import Evaluator
from .corners import CornerRuns, corner_in_sentence
from .targets import Target, targets

TRUSTED = 0.25  # error of the first order, relative to the scatter, up to which shares are relied on
NEAR = 0.1  # of a limit: a target nearer to it, or beyond, is tightened for before the objective
NOTHING = 1e-3  # of the largest change: what is smaller is none
LESS = 0.5  # of a tolerance: what is left of one that is tightened


class Spread(NamedTuple):
    """The scatter of a quantity by tolerances, in the scenario that has its worst corner.

    - ``name``: of the quantity; ``scenario``: its number among the problem's load cases as drawn.
    - ``drawn``: the value without tolerances; ``low``, ``high``: the least and the largest in the corners run.
    - ``effects``: the change by half of each tolerance's width, to first order, in the quantity's unit.
    - ``error``: of the first order in the corners, rms, relative to the rms change there [-]; NaN where one failed.
    """

    name: str
    scenario: int
    drawn: float
    low: float
    high: float
    effects: Float[np.ndarray, " tolerances"]
    error: float

    @property
    def shares(self) -> Float[np.ndarray, " tolerances"]:
        """Return the share of each tolerance in the variance, if each number is anywhere within it as likely [-]."""
        total = float(np.sum(self.effects**2))
        return self.effects**2 / total if total > 0.0 else np.full(len(self.effects), np.nan)

    @property
    def trusted(self) -> bool:
        """Return whether the first order is near enough to what the corners show."""
        return bool(self.error <= TRUSTED)


@dataclasses.dataclass(frozen=True)
class Tightening:
    """What half of each tolerance would bring in the worst corner, by a run each.

    - ``title``: of what is worst there; ``corner``: in words; ``before``: its value there and its limit, in words.
    - ``after``: the values with half of each tolerance, in words, by address, those that help most first; those that do
      not help are left out.
    """

    title: str
    corner: str
    before: str
    after: dict[str, str]

    def line(self) -> str:
        """Return which tolerance to tighten first, in words."""
        where = f"the {self.title} in its worst corner, {self.corner}, is {self.before}"
        if not self.after:
            return f"tighten none: {where}, and half of no single tolerance improves it"
        first, *others = [f"with half of that of {address} {value}" for address, value in self.after.items()]
        rest = f", {others[0]}" if others else ""
        return f"tighten first the tolerance of {next(iter(self.after))}: {where}; {first}{rest} (simulated)"


def spreads(
    problem: Problem, evaluator: Evaluator, scaled: Float[np.ndarray, " variables"], runs: CornerRuns, rtol: float
) -> tuple[Spread, ...]:
    """Return the scatter of the objective's and of each limited quantity, those that the tolerances change."""
    drawn = evaluator.by_tolerances(scaled, problem.drawn, rtol)
    scenarios, evaluation, count = len(problem.scenarios), runs.evaluation, runs.corners
    per_scenario = count // scenarios
    limits = [name for name in problem.limits.names if name in problem.names]
    each = []
    for name in dict.fromkeys([*problem.objective.weights, *limits]):
        q = problem.names.index(name)
        values = np.where(evaluation.solved, evaluation.quantities[:, q], np.nan)[:count].reshape(scenarios, -1)
        if not np.any(np.isfinite(values)):
            continue
        lowest = name in problem.limits.at_least and name not in problem.limits.at_most
        worst = int((np.nanargmin if lowest else np.nanargmax)(values)) // per_scenario
        # Of samples the first one at the scenario stands for its derivatives.
        k = worst * (len(problem.drawn) // scenarios)
        here, slope = float(drawn.quantities[k, q]), drawn.quantities_slope[k, q]
        if not drawn.solved[k]:
            continue
        each.append(
            Spread(
                name=name,
                scenario=k,
                drawn=here,
                low=float(np.nanmin(values[worst])),
                high=float(np.nanmax(values[worst])),
                effects=slope,
                # What is sampled changes the corners too, of which the tolerances know nothing.
                error=_error(problem, here, slope, runs.signs[:per_scenario], values[worst])
                if problem.scatter is None
                else float("nan"),
            )
        )
    return tuple(it for it in each if it.low < it.high or np.any(it.effects))


def _error(
    problem: Problem, drawn: float, slope: np.ndarray, signs: np.ndarray, values: Float[np.ndarray, " corners"]
) -> float:
    """Return the error of the first order in the corners, relative to the change there."""
    tolerances = list(problem.tolerances.values())
    # Slopes are by shares of half a tolerance's width: one of unequal sides has ends that are not at -1 and 1.
    ends = np.array([[it.change(sign) / (0.5 * (it.high - it.low)) for it, sign in zip(tolerances, row, strict=True)]
                     for row in signs])  # fmt: skip
    change = values - drawn
    size = float(np.sqrt(np.mean(change**2)))
    return float(np.sqrt(np.mean((ends @ slope - change) ** 2))) / size if size > 0.0 else float("nan")


def tightening(
    problem: Problem, evaluator: Evaluator, scaled: Float[np.ndarray, " variables"], runs: CornerRuns, rtol: float
) -> Tightening | None:
    """Return what half of each tolerance would bring in the corner that is worst; None where none is known."""
    chosen = _worst(problem, runs)
    if chosen is None:
        return None
    target, k = chosen
    signs, corner = runs.signs[k], runs.cases[k]
    rows = np.tile(signs, (len(signs), 1))
    np.fill_diagonal(rows, LESS * signs)
    cases = [moved(runs.bases[k], problem.tolerances, row) for row in (signs, *rows)]
    (evaluation,) = evaluator([scaled], rtol, slopes=False, cases=cases)
    before, *after = target.values(evaluation)
    helping = {
        address: target.text(value)
        for value, address in sorted(zip(after, problem.tolerances, strict=True))
        if value < before and np.isfinite(value)
    }
    label = corner_in_sentence(problem, corner.label([*problem.drawn, *runs.cases]), k, runs.corners)
    value = target.text(before) if np.isfinite(before) else "not known"
    return Tightening(target.title, label, value + target.bound, helping)


def _worst(problem: Problem, runs: CornerRuns) -> tuple[Target, int] | None:
    """Return the limit that is broken worst in a corner, or nearly so, or else the objective, and the corner."""
    worst = list[tuple[float, int, Target]]()
    for it in targets(problem):
        values = it.values(runs.evaluation)[: runs.corners]
        values = np.where(np.isnan(values), np.inf, values)
        worst.append((float(np.max(values)), int(np.argmax(values)), it))
    near = [it for it in worst if it[2].limited and it[0] > -NEAR]
    some = sorted(near, key=lambda it: -it[0]) or [it for it in worst if not it[2].limited]
    return (some[0][2], some[0][1]) if some else None


CAPTION = "Change by half of each tolerance's width, and its share of the scatter"


def spread_headings(problem: Problem, spreads: Sequence[Spread]) -> list[str]:
    """Return each quantity's title with its unit."""
    quantities = [problem.catalogue[it.name] for it in spreads]
    return [it.title + ("" if is_plain(it.in_figures[0]) else f" [{it.in_figures[0]}]") for it in quantities]


def spread_rows(problem: Problem, spreads: Sequence[Spread]) -> list[list[str]]:
    """Return a row for each tolerance, then what the corners show and the error of the first order; none without
    tolerances."""
    if not spreads:
        return []
    each = [(it, problem.catalogue[it.name].in_figures[1]) for it in spreads]
    rows = []
    for k, address in enumerate(problem.tolerances):
        changes = []
        for it, factor in each:
            effect = float(it.effects[k])
            # What is far below the largest is shown as 0.
            nothing = abs(effect) < NOTHING * float(np.max(np.abs(it.effects))) or not effect
            share = percent_text(it.shares[k], ".0f")
            changes.append("0 (0 %)" if nothing else f"{factor * effect:+.3g} ({share})")
        rows.append([address, problem.tolerance_text(address), *changes])
    rows.append(["as drawn", "", *(f"{factor * it.drawn:.4g}" for it, factor in each)])
    rows.append(["in the corners", "", *(range_text(factor * it.low, factor * it.high, "", 4) for it, factor in each)])
    # Of the first order.
    errors = [
        "not known" if np.isnan(it.error) else f"{percent_text(it.error, '.0f')}{'' if it.trusted else ', no guide'}"
        for it in spreads
    ]
    rows.append(["error of the changes there", "", *errors])
    return rows


def spread_table(problem: Problem, spreads: Sequence[Spread]) -> Table | None:
    """Return the rows as a table; None without tolerances."""
    if not spreads:
        return None
    made = table(CAPTION, ("field", "tolerance"), tuple(spread_headings(problem, spreads)))
    for row in spread_rows(problem, spreads):
        made.add_row(*row)
    return made


def spread_lines(problem: Problem, spreads: Sequence[Spread], first: Tightening | None) -> list[str]:
    """Return which tolerance to tighten first, and for which quantities the shares are no guide, a line each."""
    lines = [] if first is None else [first.line()]
    titles = [problem.catalogue[it.name].title for it in spreads if not it.trusted]
    if titles:
        words = "first-order changes do not say what the corners show"
        lines.append(f"the shares of the {' and the '.join(titles)} are no guide: {words}")
    return lines
