"""The result of a choice: the best combinations with their margins, and its tables."""

import dataclasses
import math
from typing import Any

from rich.table import Table

from .._types import DataFrame
from ..fields import Part, field_text, get, unit
from ..labelled.arrays import frame
from ..labelled.record import headings
from ..labelled.saved import Saved
from ..tables import html, table, text
from ..tuning.problem.problem import Problem
from ..tuning.report.levers import ASK, DECIDING, Levers, lever_table
from ..tuning.report.limit_rows import ShownRow
from ..tuning.search.evaluation import validity_lines
from ..tuning.search.goal import Goal
from ..tuning.tolerances.corners import SEARCHED
from ..value_text import percent_text, relative_change, with_unit
from .alternatives import Alternative
from .bound import ContinuousOptimum
from .catalogue import PartsCatalogue
from .criterion import Criterion
from .enumeration import RunTally

SHOWN = 12  # broken limits in the table
NOT_CHOSEN = "numbers that were not chosen"


@dataclasses.dataclass(frozen=True)
class Choice(Saved):
    """A finished choice of parts, or of roundings. Print it for tables.

    - ``criterion``: objective and limits, ``problem`` among them.
    - ``catalogues``: what was chosen from.
    - ``ranked``: the best combinations, the best one first; where none keeps the limits, those nearest to them.
    - ``tally``: combinations and runs, and how many were spared.
    - ``optimum``: over the catalogues' ranges; None where it was not asked for.
    - ``continuous``: the design that was rounded; ``nearest``: every number of it at its nearest buildable value; None
      for a choice of parts.
    - ``misfit``: why one of the combinations does not go together, "" where all do.
    - ``tight``: rtol of the numbers [-]; ``reordered``: whether the ranking at the problem's tolerance was another one.
    - ``identity``: a hash of all that makes it the choice it is.
    - ``least``: with a second objective, the combination with the least first one, which may not be among the ranked;
      ``ceiling``: up to which value of the first objective the second one orders.
    - ``levers`` of the best combination's limits and objective, by name, where they were asked for: three of the
      numbers that were chosen, then three others; ``missing``: why they could not be found.

    **Example:**

    >>> parts = {"spring": {"soft": {"k_A": "300 N/m"}, "stiff": {"k_A": "900 N/m"}}}
    >>> choice = jb.choose(jb.Problem(jb.table2(), [jb.Scenario()], []), parts, optimum=False)
    >>> choice.best.names, f"{choice.best.value:.1f} N"
    (('soft',), '264.5 N')
    """

    criterion: Criterion
    catalogues: tuple[PartsCatalogue, ...]
    ranked: tuple[Alternative, ...]
    tally: RunTally
    optimum: ContinuousOptimum | None = None
    continuous: Alternative | None = None
    nearest: Alternative | None = None
    misfit: str = ""
    tight: float = 1e-9
    reordered: bool = False
    identity: str = ""
    least: Alternative | None = None
    ceiling: float = math.inf
    levers: Levers = dataclasses.field(default_factory=dict)
    missing: tuple[str, ...] = ()

    @property
    def problem(self) -> Problem:
        """Return the problem."""
        return self.criterion.problem

    @property
    def best(self) -> Alternative | None:
        """Return the best combination, or the one nearest to the limits; None where none could be run."""
        return self.ranked[0] if self.ranked else None

    @property
    def feasible(self) -> bool:
        """Return whether the best combination keeps every limit in every load case."""
        return self.best is not None and self.best.feasible

    @property
    def design(self) -> Part:
        """Return the best combination's design; the problem's own where none could be run."""
        return self.problem.design if self.best is None else self.best.design

    @property
    def accuracy(self) -> float:
        """Return the largest change of the objective from the problem's tolerance to the tight one, relative [-]."""
        # Since its variables were tuned a combination is another design than the one searched, and does not compare.
        changes = [relative_change(it.searched, it.value) for it in self.ranked if it.tuned is None]
        return max((abs(change) for change in changes if change is not None), default=0.0)

    @property
    def message(self) -> str:
        """Return what came out, in a sentence."""
        count = f"{self.tally.combinations} combinations over {self.problem.over}"
        if self.best is None:
            return f"no combination keeps the limits on price and mass, or goes together: {count}"
        named = self.in_words(self.best)
        if not self.feasible:
            return f"no combination keeps all limits, of {count}; nearest to them was {named}"
        return f"the best of {count}: {named}, with {self.objectives_in_words(self.best)}"

    def objectives_in_words(self, alternative: Alternative) -> str:
        """Return the objective of a combination, and the second one: "285.2 N, then 12.4 mm"."""
        criterion, shown = self.criterion, with_unit(*self.criterion.shown(alternative.value), 5)
        if criterion.then is None or alternative.second is None:
            return shown
        return f"{shown}, then {with_unit(*criterion.then.objective.shown(alternative.second, criterion.catalogue), 5)}"

    def in_words(self, alternative: Alternative) -> str:
        """Return the parts of a combination: "spring S1, damper D3"."""
        pairs = zip(self.catalogues, alternative.names, strict=True)
        return ", ".join(f"{catalogue.role} {name}" for catalogue, name in pairs)

    def label(self, case: int) -> str:
        """Return what people call a load case."""
        return self.problem.label(case)

    def number(self, case: int) -> str:
        """Return the number of a load case, which `lines` say; what people call it where there is one scenario."""
        return self.problem.number_text(case) if len(self.problem.drawn) > 1 else self.label(case)

    def holding(self, alternative: Alternative) -> int:
        """Return in how many corners of the tolerances a combination keeps every limit and ends as it must."""
        problem = dataclasses.replace(self.problem, design=alternative.design)
        goal, evaluation = Goal(problem, problem.objective), alternative.evaluation
        return sum(not goal.broken_in(evaluation, k) for k in problem.corner_places)

    def to_dataframe(self) -> DataFrame:
        """Return a row for each ranked combination, as in choice.csv."""
        return frame(*ranking_rows(self))

    def __repr__(self) -> str:
        return text(*_parts(self))

    def _repr_html_(self) -> str:
        return html(*_parts(self))


def _parts(choice: Choice) -> list[str | Table]:
    """Return the message, tables, and lines about how the result came about."""
    best = choice.best
    tables = [_ranking(choice)] if best is None else [_limits(choice, best), *_levers(choice), _ranking(choice)]
    tables += [] if best is None else [_fields(choice)]
    ask = [] if best is None or choice.levers else [ASK]
    return [choice.message[:1].upper() + choice.message[1:], *tables, *lines(choice), *ask]


def _levers(choice: Choice) -> list[Table]:
    where = DECIDING if len(choice.problem.cases) > 1 else ""
    made = lever_table(choice.levers, choice.criterion.catalogue, where, NOT_CHOSEN)
    return [] if made is None else [made]


def lines(choice: Choice) -> list[str]:
    """Return a line for each thing to know beside the tables."""
    tally, best, made = choice.tally, choice.best, list[str]()
    counts = {
        "run at every scenario and within all limits": tally.complete,
        "dropped as beaten": tally.beaten,
        "dropped for a limit or for how a run ended": tally.infeasible,
        "above a limit on price or mass": tally.priced_out,
        "dropped for a run that failed": tally.failed,
        "do not go together": tally.unfit,
    }
    made.append(f"of {tally.combinations} combinations " + ", ".join(f"{n} {it}" for it, n in counts.items() if n))
    share = percent_text(tally.spared / tally.possible, ".0f")
    made.append(f"{tally.runs} runs of {tally.possible}: {tally.spared} were spared ({share})")
    if len(choice.problem.drawn) > 1:
        # The ranking has their numbers alone.
        made += [f"largest at {choice.label(case)}" for case in sorted({it.deciding for it in choice.ranked})]
    if choice.misfit:
        made.append(f"one that does not go together: {choice.misfit}")
    if best is not None and (corners := len(choice.problem.corners)):
        which = " that were searched for" if choice.problem.needs_search else ""
        made.append(f"the first holds in {choice.holding(best)} of {corners} corners of the tolerances{which}")
        made += [SEARCHED] if which else []
    if choice.optimum is not None:
        made.append(choice.optimum.line(choice.criterion, best.value if best is not None and best.feasible else None))
    made += _second(choice) + _rounding(choice)
    if best is None:
        return made
    order = "the ranking changed with it" if choice.reordered else "the ranking stayed the same"
    made.append(
        f"numbers are of runs at rtol {choice.tight:g}; from rtol {choice.problem.rtol:g} the objective changed by"
        f" {percent_text(choice.accuracy)} at most, {order}"
    )
    return made + beyond(choice)


def _second(choice: Choice) -> list[str]:
    """Return by what combinations are ordered that are about as good as the best, in a line."""
    then, least = choice.criterion.then, choice.least
    if then is None or least is None:
        return []
    ceiling, second = with_unit(*choice.criterion.shown(choice.ceiling), 5), choice.criterion.in_words(then.objective)
    text = f"then {second}: it orders all within {percent_text(then.tolerance)} of the least objective, up to {ceiling}"
    if any(it.tuned is not None for it in choice.ranked):
        return [text]
    return [f"{text}; {choice.in_words(least)} has the least, {choice.objectives_in_words(least)}"]


def beyond(choice: Choice) -> list[str]:
    """Return a line for each validity limit that the best combination exceeds, and for the limits that it breaks."""
    best = choice.best
    if best is None:
        return []
    made = [*choice.missing, *validity_lines(choice.problem, best.design, best.evaluation)]
    made += [f"broken: {line}" for line in best.broken[:SHOWN]]
    return made + [f"and {len(best.broken) - SHOWN} more" for _ in best.broken[SHOWN : SHOWN + 1]]


def _rounding(choice: Choice) -> list[str]:
    """Return what rounding costs: of the best values, and of the nearest ones."""
    continuous, best, nearest = choice.continuous, choice.best, choice.nearest
    if continuous is None:
        return []
    shown = with_unit(*choice.criterion.shown(continuous.value), 5)
    made = [f"the continuous design has {shown}" + ("" if continuous.feasible else ", and breaks limits")]
    for what, it in (("the best rounding", best), ("each number at its nearest value", nearest)):
        if it is not None:
            cost = percent_text(relative_change(continuous.value, it.value), "+.2g")
            broken = "" if it.feasible else f", and breaks limits: {it.broken[0]}"
            made.append(f"{what}, {choice.in_words(it)}: {cost}{broken}")
    return made


def _ranking(choice: Choice) -> Table:
    """Return the best combinations: parts, objective, what decides it, and the tightest limit."""
    symbol, factor = choice.criterion.objective.in_figures(choice.criterion.catalogue)
    known, then = choice.criterion.catalogue, choice.criterion.then
    then_symbol, then_factor = ("", 1.0) if then is None else then.objective.in_figures(known)
    totals = {name: known[name].in_figures[0] for name in (choice.best.totals if choice.best else ())}
    # Price or mass alone has a column of its own.
    has_column = then is None or dict(then.objective.weights) in [{name: 1.0} for name in totals]
    of_second = {} if has_column else {"then": then_symbol}
    title = "Ranking" if choice.feasible else "Nearest to the limits, none within them"
    numbers = (*headings({"objective": symbol}), "above", *headings(of_second), *headings(totals))
    made = table(title, ("", *(it.role for it in choice.catalogues)), numbers)
    for heading in ("largest at", "tightest"):
        made.add_column(heading)
    made.add_column("left", justify="right")
    for place, it in enumerate(choice.ranked, 1):
        # Where none is feasible the limits make the order, and how far an objective is above the first says nothing.
        change = relative_change(choice.ranked[0].value, it.value) if choice.feasible and place > 1 else None
        tightest = it.margins[0] if it.margins else None
        made.add_row(
            str(place),
            *it.names,
            f"{factor * it.value:.6g}",
            "" if change is None else percent_text(change, ".2g"),
            *(f"{then_factor * it.second:.6g}" for _ in of_second if it.second is not None),
            *(f"{choice.criterion.catalogue[name].in_figures[1] * it.totals[name]:.5g}" for name in totals),
            choice.number(it.deciding),
            "" if tightest is None else tightest.limit.name,
            "" if tightest is None else percent_text(tightest.share, ".3g"),
        )
    return made


def _limits(choice: Choice, best: Alternative) -> Table:
    """Return every limit of the best combination with its worst load case."""
    made = table("Limits of the first", ("limit",), ("value", "bound", "room"))
    made.add_column("load case")
    for row in limits_of(choice, best):
        made.add_row(row.name, row.value, row.bound, row.room, row.where)
    return made


def limits_of(choice: Choice, best: Alternative) -> list[ShownRow]:
    """Return every limit of a combination as people are shown it, those on price and mass too, the least room first."""
    each = [(it.share, it.limit, it.value, choice.label(it.case)) for it in best.margins]
    totals = ((limit, best.totals[limit.name]) for limit in choice.criterion.limits)
    each += [(limit.margin(value), limit, value, "") for limit, value in totals]
    rows = []
    for room, limit, value, where in sorted(each, key=lambda it: -math.inf if it[0] is None else it[0]):
        quantity = choice.criterion.catalogue[limit.name]
        bound, text = limit.bound_text(*quantity.in_figures), quantity.in_words(value, 5)
        rows.append(ShownRow(quantity.title or limit.name, text, bound, percent_text(room, ".3g"), where))
    return rows


def _fields(choice: Choice) -> Table:
    """Return what the parts of the best combination set, and the tuned variables."""
    made = table("Numbers of the first", ("field", "part"), ("value",))
    assert choice.best is not None
    for path, name in set_by(choice, choice.best).items():
        made.add_row(path, name, _shown(choice, choice.best, path))
    return made


def set_by(choice: Choice, alternative: Alternative) -> dict[str, str]:
    """Return the name of what has set each field of a combination, by path: a part, or the tuning."""
    made = dict[str, str]()
    for catalogue, name in zip(choice.catalogues, alternative.names, strict=True):
        part = next(it for it in catalogue.parts if it.name == name)
        made |= dict.fromkeys(part.fields, name)
    return made | (dict.fromkeys(choice.problem.paths, "tuned") if alternative.tuned is not None else {})


def _shown(choice: Choice, alternative: Alternative, path: str) -> str:
    """Return a number of a combination in the unit that it was typed with."""
    value = get(alternative.design, path)
    if not unit(alternative.design, path):
        return field_text(value, "")
    return with_unit(*choice.problem.shown(path, float(value)))


def ranking_rows(choice: Choice) -> tuple[list[str], list[list[Any]]]:
    """Return a header and a row for each ranked combination: parts, objective, sums, worst values and margins."""
    criterion, problem = choice.criterion, choice.problem
    totals = choice.best.totals if choice.best else {}
    units = {"rank": "", **{it.role: "" for it in choice.catalogues}, "feasible": ""}
    units |= {"objective": criterion.objective.unit(criterion.catalogue)}
    of_second = {} if criterion.then is None else {"then": criterion.then.objective.unit(criterion.catalogue)}
    units |= of_second | {name: criterion.catalogue[name].unit for name in totals} | {"largest at": ""}
    limits = [margin.limit for margin in choice.best.margins] if choice.best else []
    for limit in limits:
        units |= {f"worst {limit.name} ({limit.symbol})": problem.catalogue[limit.name].unit}
        units |= {f"left of {limit.name} ({limit.symbol})": "-", f"{limit.name} ({limit.symbol}) at": ""}
    rows = []
    for place, it in enumerate(choice.ranked, 1):
        row: list[Any] = [place, *it.names, it.feasible, it.value, *(it.second for _ in of_second)]
        row += [*(it.totals[name] for name in totals), choice.label(it.deciding)]
        for limit in limits:
            # Each combination has its tightest margin first, while the columns are in the order of the best one's.
            margin = next(one for one in it.margins if one.limit == limit)
            row += [margin.value, margin.share, choice.label(margin.case)]
        rows.append(row)
    return headings(units), rows
