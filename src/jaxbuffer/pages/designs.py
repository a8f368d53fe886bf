"""The design of a page: every number with its meaning, and where it comes from."""

from typing import Any

from ..fields import as_typed, get, meaning, paths, unit
from ..output.folder import Record, Results
from .figures import figure
from .page import Cell, Section, Table, shown
from .records import by_name, same, units_of


def design(found: Results) -> Section | None:
    """Every number of the design: tuned and given ones first, those at their defaults folded away."""
    if found.design is None:
        return None
    default = found.mechanism.design()
    tuned = {variable["path"] for variable in (found.tuned or {}).get("variables", ())}
    typed = units_of(found)
    special: list[list[str | Cell]] = []
    usual: list[list[str | Cell]] = []
    for path in paths(default):
        before = get(default, path)
        value = get(found.design, path)
        source = "tuned" if path in tuned else "default" if same(value, before) else "given"
        symbol, as_shown = unit(default, path), typed.get(path, "")
        (number, told), (usually, _) = (_shown(it, symbol, as_shown) for it in (value, before))
        row = [path, meaning(default, path), shown(number), told, shown(usually), source]
        (usual if source == "default" else special).append(list(row))
    headings = ("field", "meaning", "value", "unit", "default", "source")
    tables = [Table("What is tuned or given", headings, special)] if special else []
    tables.append(Table(f"{len(usual)} fields at their defaults", headings, usual, folded=True))
    return Section("Design", figures=figure(found, "motion", "The mechanism at telling times, to scale"), tables=tables)


def other_design(found: Results, first: Results, record: Record) -> list[str]:
    """In what a record's design differs from the page's, as a sentence; nothing where it is the same."""
    if first.design is None:
        return []
    usual, one = found.mechanism.design(), by_name(record["design"])
    differ = [path for path in paths(usual) if path in one and not same(one[path], get(first.design, path))]
    if not differ:
        return []
    typed = units_of(found)
    told = [(path, *_shown(one[path], unit(usual, path), typed.get(path, ""))) for path in differ]
    said = ", ".join(f"{path} = {shown(value)} {symbol}".rstrip(" -") for path, value, symbol in told)
    return [f"Of another design than the one above: {said}."]


def _shown(value: Any, unit: str, typed: str) -> tuple[Any, str]:
    """A field's value in the unit that it was typed in, and that unit; what is no number as it is."""
    return as_typed(value, unit, typed) if isinstance(value, float) else (value, unit)
