"""Limits against what load cases reach: a row for each, and their table for people."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, NamedTuple

from rich.table import Table

from ...mechanisms.limit import IMPACTS, Limit
from ...mechanisms.quantity import Catalogue
from ...mechanisms.run import Run
from ...tables import table
from ...value_text import UNKNOWN, percent_text, table_text, unit_text, with_unit
from ..problem.cases import in_sentence
from ..problem.objective import Constraints, Limits

CLOSE = 1e-3  # relative margin below which a value is at its limit
State = Literal["broken", "not known", "at the limit", "kept"]
"""How a value stands to its limit."""
ORDER: tuple[State, ...] = ("broken", "not known", "at the limit", "kept")  # what stands in the way first


class LimitRow(NamedTuple):
    """A limit and the load case that is nearest to it or farthest beyond it.

    ``value`` there, in the quantity's unit, and ``where`` it is, in words; ``room``: how far the value keeps from the
    limit, relative to it [-]. None, and "" for the load case, for what is not known; a number of impacts has no room.
    """

    limit: Limit
    value: float | None
    where: str
    room: float | None
    state: State

    @staticmethod
    def of(limit: Limit, values: Sequence[Mapping[str, Any]], labels: Sequence[str]) -> "LimitRow":
        """Return the row of a limit.

        **Arguments:** ``values``: the quantities of each load case, by name; ``labels``: the load cases in words.
        """
        if limit.name not in values[0]:
            return LimitRow(limit, None, "", None, "not known")
        each = [limit.worst([case[limit.name]]) for case in values]
        value = limit.worst(each)
        room = limit.margin(value)
        # A value that is not known is worse than any, so that it is found here too.
        return LimitRow(limit, value, labels[each.index(value)], room, state_of(limit, value, room))

    def value_text(self, unit: str = "", factor: float = 1.0) -> str:
        """Return the value in a unit: with as many digits as tell it from a bound that it breaks.

        ``factor``: how many of the ``unit`` the quantity's own one is.
        """
        if self.value is None:
            return UNKNOWN
        text = table_text(factor * self.value)
        # Only a broken bound that reads like the value needs more digits: 25 mm beyond 25 mm.
        if self.limit.keeps(self.value) or text != with_unit(factor * self.limit.bound, ""):
            return f"{text}{unit_text(unit)}"
        return self.limit.told_apart(self.value, unit, factor)

    @property
    def room_text(self) -> str:
        """Return the room in per cent."""
        return UNKNOWN if self.room is None else percent_text(self.room, ".3g")


def state_of(limit: Limit, value: Any, room: float | None) -> State:
    """Return how a value stands to a limit; ``room``: of the limit, that is left [-]."""
    if not limit.keeps(value):
        return "broken"
    return "at the limit" if room is not None and room < CLOSE else "kept"


def limit_rows(limits: Iterable[Limit], values: Sequence[Mapping[str, Any]], labels: Sequence[str]) -> list[LimitRow]:
    """Return the rows of some limits, what stands in the way first; arguments as of `LimitRow.of`."""
    rows = [LimitRow.of(limit, values, labels) for limit in limits]
    return sorted(rows, key=lambda row: (ORDER.index(row.state), float("inf") if row.room is None else row.room))


class ShownRow(NamedTuple):
    """A row of the table as people are shown it: what is limited, its value, bound, room and load case, and how it
    stands in the way."""

    name: str
    value: str
    bound: str
    room: str = UNKNOWN
    where: str = UNKNOWN
    state: str = ""

    @staticmethod
    def of(row: LimitRow, catalogue: Catalogue, always: Mapping[str, float]) -> "ShownRow":
        """Return the row of a limit; ``always``: those that a problem need not set, by quantity."""
        limit = row.limit
        quantity = limit.quantity(catalogue)
        usual = " (always)" if not limit.lowest and always.get(limit.name) == limit.bound else ""
        value, bound = row.value_text(*quantity.in_figures), limit.bound_text(*quantity.in_figures)
        name = quantity.title or limit.name.replace("_", " ")
        return ShownRow(f"{name}{usual}", value, bound, row.room_text, row.where or UNKNOWN, row.state)

    @staticmethod
    def of_end(success: str, labels: Sequence[str], succeeded: Sequence[bool]) -> "ShownRow":
        """Return the row of how runs must end: the load cases that do, and the first that does not."""
        missed = [label for label, good in zip(labels, succeeded, strict=True) if not good]
        runs, where = len(labels), missed[0] if missed else UNKNOWN
        value, bound = f"{runs - len(missed)} of {runs}", f"{runs} of {runs}"
        return ShownRow(success, value, bound, where=where, state="broken" if missed else "kept")


def limit_table(rows: Iterable[ShownRow], several: bool, where: str = "") -> Table:
    """Return the rows as a table; ``several``: whether they are of more than one load case, which each row names;
    ``where``: the single one as a sentence names it, if it is one of several."""
    made = table(f"Limits: what stands in the way{where and f' in {where}'}", ("limit",), ("value", "bound", "room"))
    for heading in ("load case", "") if several else ("",):
        made.add_column(heading)
    for row in rows:
        made.add_row(row.name, row.value, row.bound, row.room, *((row.where,) if several else ()), row.state)
    return made


def run_limit_table(run: Run, constraints: Constraints, number: str = "") -> Table | None:
    """Return a run against its study's limits; None for a run that failed, or without any.

    ``number``: of its scenario among the study's, "" for a single one.
    """
    shown, label = run_rows(run, constraints), run.mechanism.view.label(run.scenario)
    return limit_table(shown, several=False, where=in_sentence(label, number) if number else "") if shown else None


def tightest_text(run: Run, constraints: Constraints) -> str:
    """Return the limit that stands in the way most, in a line; "" for none."""
    shown = run_rows(run, constraints)
    if not shown:
        return ""
    first = shown[0]
    room = "" if first.room == UNKNOWN else f", room {first.room}"
    return f"{first.state}: {first.name} {first.value} ({first.bound}){room}"


def run_rows(run: Run, constraints: Constraints) -> list[ShownRow]:
    """Return the rows of `run_limit_table`."""
    if run.outcome.failed:
        return []
    mechanism, label = run.mechanism, run.mechanism.view.label(run.scenario)
    always = mechanism.always(run.design)
    limits: Limits = constraints.limits.with_always(always)
    values = constraints._replace(limits=limits).values(run) | {IMPACTS: int(run.impact_count)}
    rows = limit_rows((*limits.each, *limits.of_impacts), [values], [label])
    shown = [ShownRow.of(row, constraints.catalogue(mechanism), always) for row in rows]
    success = limits.success(mechanism, run.design)
    if success is not None and (limits.require_success or limits.ends):
        end = ShownRow.of_end(success, [label], [bool(limits.ended(mechanism, int(run.outcome)))])
        # An end that is missed comes first, as broken limits do.
        shown.insert(0 if end.state == "broken" else len(shown), end)
    return shown
