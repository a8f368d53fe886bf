"""What is asked, the design with every number's meaning and source, and what the model leaves out."""

from collections.abc import Mapping, Sequence
from typing import Any

from ..fields import Part, as_typed, ends_as_typed, get, meaning, paths, unit
from ..labelled.record import Record
from ..mechanisms.mechanism import Mechanism
from ..output.folder import Results
from ..output.words import value_in_words
from ..value_text import range_text, table_text, unit_text, with_unit
from .choice import asked_of_choice, choice_cases, chosen_by
from .limit_check import limits_of, required_success, source_of_limits
from .page import Cell, PageSection, Table
from .records import display, field_name, figure, same, scenario_of, units_of, words

TITLE = "What is asked"
Rows = list[list[str]]


def requirements(first: Results, every: Sequence[Results]) -> PageSection | None:
    """Return a section on what the page's tuning, or else its choice or its run, must do.

    Limits come from the first folder that has some.
    """
    mechanism, tuned = first.mechanism, first.tuned
    run = first.records.get("run")
    choice = first.records.get("choice") if tuned is None else None
    rows = _limits(first, choice or source_of_limits([first, *every]))
    if choice is not None:
        rows, cases = [*asked_of_choice(first), *rows], choice_cases(first)
        rows += _scenarios(mechanism, cases, units_of(first), bool(choice.get("tolerances"))) if cases else []
        rows += _tolerances(choice)
    elif tuned is not None:
        rows = [["objective", words(tuned["objective"]), "as small as possible"], *rows]
        rows += _scenarios(mechanism, tuned["scenarios"], units_of(first), bool(tuned.get("tolerances")))
        rows += _variables(mechanism, tuned["variables"])
        rows += _tolerances(tuned)
    elif run is not None:
        rows += _scenarios(mechanism, [run["scenario"]], units_of(first))
    drawn = mechanism.design() if first.design is None else first.design
    left_out = mechanism.view.left_out(lambda path: get(drawn, path))
    text = [f"What the model leaves out: {' '.join(left_out)}"] if left_out else []
    if not rows and not text:
        return None
    return PageSection(TITLE, text, tables=[Table(TITLE, ("what", "of", "asked"), rows)] if rows else [])


def _tolerances(record: Record) -> Rows:
    return [["tolerance", path, it["in_words"]] for path, it in record.get("tolerances", {}).items()]


def _limits(first: Results, source: Record | None) -> Rows:
    """Return how runs must end, and what is limited."""
    if source is None:
        return []
    mechanism, success = first.mechanism, required_success(first, source)
    rows = [] if success is None else [["end", f"each {mechanism.view.run_name}", words(success)]]
    for limit in limits_of(mechanism, source):
        title, symbol, factor = display(mechanism, limit.name, source.get("quantities", {}))
        rows.append(["limit", title, limit.bound_text(symbol, factor)])
    if (most := source.get("most_impacts")) is not None:
        rows.append(["limit", "impacts", f"≤ {most}"])
    return rows


def _scenarios(
    mechanism: Mechanism, cases: Sequence[Record], units: Mapping[str, str], toleranced: bool = False
) -> Rows:
    """Return how many there are, and the range of each field; ranges of what is built otherwise than drawn. Corners of
    tolerances are none of them."""
    corners = [toleranced and bool(case.get("factors") or case.get("shifts")) for case in cases]
    cases = [case for case, corner in zip(cases, corners, strict=True) if not corner] or cases
    met, usual = [scenario_of(mechanism, case) for case in cases], mechanism.scenario()
    name = "scenario" if len(met) == 1 else f"{len(met)} scenarios"
    meant = [path for path in paths(usual) if any(path not in one.without_effect for one in met)]
    rows = [[name, *_range(met, usual, path, units.get(f"scenario.{path}", ""))] for path in meant]
    # A grid may give values to numbers of the design too.
    drawn = mechanism.design()
    for path in dict.fromkeys(path for case in cases for path in case.get("values", {})):
        values = [case.get("values", {})[path] for case in cases if path in case.get("values", {})]
        low, high, symbol = ends_as_typed(min(values), max(values), unit(drawn, path), units.get(path, ""))
        rows.append([name, path, range_text(low, high, symbol, 4) if low < high else with_unit(low, symbol, 4)])
    # Those of tolerances are listed by themselves.
    built = dict.fromkeys(path for case in cases for path in case.get("factors", {}) if not toleranced)
    for path in built:
        # A case that does not mention a number has it as drawn.
        factors = [case.get("factors", {}).get(path, 1.0) for case in cases]
        rows.append(["as built, of the drawn", path, f"{min(factors):.4g} to {max(factors):.4g}"])
    return rows


def _range(met: Sequence[Any], usual: Part, path: str, typed: str) -> list[str]:
    """Return a field's name, and its values from the lowest to the highest; ``typed``: the unit that they were typed
    in."""
    values, symbol = [get(one, path) for one in met], unit(usual, path)
    if not symbol or any(value is None for value in values):
        return [field_name(path), ", ".join(dict.fromkeys(map(table_text, values)))]
    # Angles are in degrees on a page, whatever they were typed in.
    ends = (as_typed(float(end), symbol, "" if symbol == "rad" else typed) for end in (min(values), max(values)))
    low, high = (value_in_words(*end) for end in ends)
    return [field_name(path), low if low == high else f"{low} to {high}"]


def _variables(mechanism: Mechanism, variables: Sequence[Record]) -> Rows:
    usual, rows = mechanism.design(), list[list[str]]()
    for it in variables:
        typed = it.get("display_unit", "")
        low, high, symbol = ends_as_typed(it["low"], it["high"], unit(usual, it["path"]), typed)
        rows.append(["variable", it["path"], f"{table_text(low)} to {table_text(high)}{unit_text(symbol)}"])
    return rows


def design(results: Results) -> PageSection | None:
    """Return every number of the design: tuned and given ones first, those at their defaults folded away."""
    if results.design is None:
        return None
    default = results.mechanism.design()
    tuned = {variable["path"] for variable in (results.tuned or Record()).get("variables", ())}
    sources = {
        **dict.fromkeys(results.records.get("fit", Record()).get("parameters", ()), "fitted"),
        **chosen_by(results),
        # Last, because what was tuned after a choice is no longer the part's.
        **dict.fromkeys(tuned, "tuned"),
    }
    typed = units_of(results)
    special: list[list[str | Cell]] = []
    usual: list[list[str | Cell]] = []
    for path in paths(default):
        before = get(default, path)
        value = get(results.design, path)
        # A design does not say which of its numbers were typed: what equals the default counts as default.
        source = sources.get(path) or ("default" if same(value, before) else "given")
        symbol, as_shown = unit(default, path), typed.get(path, "")
        (number, symbol_shown), (usually, _) = (_shown(it, symbol, as_shown) for it in (value, before))
        row = [path, meaning(default, path), table_text(number), symbol_shown, table_text(usually), source]
        (usual if source == "default" else special).append(list(row))
    headings = ("field", "meaning", "value", "unit", "default", "source")
    tables = [Table("What is not left at its default", headings, special)] if special else []
    tables.append(Table(f"{len(usual)} fields at their defaults", headings, usual, folded=True))
    return PageSection(
        "Design", figures=figure(results, "motion", "The mechanism at telling times, to scale"), tables=tables
    )


def other_design(results: Results, first: Results, record: Record) -> list[str]:
    """Return in what a record's design differs from the page's, as a sentence; nothing where it is the same."""
    if first.design is None:
        return []
    usual, one = results.mechanism.design(), record["design"]
    differ = [path for path in paths(usual) if path in one and not same(one[path], get(first.design, path))]
    if not differ:
        return []
    typed = units_of(results)
    values = [(path, *_shown(one[path], unit(usual, path), typed.get(path, ""))) for path in differ]
    values_in_words = ", ".join(f"{path} = {table_text(value)}{unit_text(symbol)}" for path, value, symbol in values)
    return [f"Of another design than the one above: {values_in_words}."]


def _shown(value: Any, unit: str, typed: str) -> tuple[Any, str]:
    """Return a field's value in the unit that it was typed in, and that unit; what is no number stays as it is."""
    return as_typed(value, unit, typed) if isinstance(value, float) else (value, unit)
