"""The design of a page: every number with its meaning, and where it comes from."""

import inspect
import re

from ..fields import Part, get, paths, unit
from .folder import Record, Results
from .page import Cell, Section, Table, shown
from .records import by_name, same

FIELD = re.compile(r"^- (``.*?)(?=^- ``|^\s*$|\Z)", re.MULTILINE | re.DOTALL)


def meanings(part: Part, prefix: str = "") -> dict[str, str]:
    """What each field of a design or scenario is, by dotted path, from the docstrings of its parts."""
    found: dict[str, str] = {}
    for line in FIELD.findall(inspect.getdoc(type(part)) or ""):
        names, _, text = line.partition(":")
        meaning = " ".join(text.replace("`", "").split()).rstrip(".;")
        found |= {prefix + name: meaning for name in re.findall(r"``(\w+)``", names)}
    for name in dict.fromkeys(path.split(".")[0] for path in paths(part)):
        inner = getattr(part, name)
        if isinstance(inner, Part):
            found |= meanings(inner, f"{prefix}{name}.")
    return found


def design(found: Results) -> Section | None:
    """Every number of the design: tuned and given ones first, those at their defaults folded away."""
    if found.design is None:
        return None
    record, default = by_name(found.design), found.mechanism.design()
    tuned = {variable["path"] for variable in (found.tuned or {}).get("variables", ())}
    said = meanings(default)
    special: list[list[str | Cell]] = []
    usual: list[list[str | Cell]] = []
    for path in paths(default):
        before = get(default, path)
        value = record.get(path, before)
        source = "tuned" if path in tuned else "default" if same(value, before) else "given"
        row = [path, said.get(path, ""), shown(value), unit(default, path), shown(before), source]
        (usual if source == "default" else special).append(list(row))
    headings = ("field", "meaning", "value", "unit", "default", "source")
    tables = [Table("What is tuned or given", headings, special)] if special else []
    tables.append(Table(f"{len(usual)} fields at their defaults", headings, usual, folded=True))
    return Section("Design", figures=found.figure("motion", "The mechanism at telling times, to scale"), tables=tables)


def other_design(found: Results, first: Results, record: Record) -> list[str]:
    """In what a record's design differs from the page's, as a sentence; nothing where it is the same."""
    if first.design is None:
        return []
    usual, one, two = found.mechanism.design(), by_name(record["design"]), by_name(first.design)
    differ = [path for path in paths(usual) if not same(one.get(path), two.get(path))]
    if not differ:
        return []
    said = ", ".join(f"{path} = {shown(one.get(path))} {unit(usual, path)}".rstrip() for path in differ)
    return [f"Of another design than the one above: {said}."]
