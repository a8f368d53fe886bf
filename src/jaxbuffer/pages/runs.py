"""What a page says of a run, and of what held it back."""

from collections.abc import Mapping, Sequence
from typing import Any

from ..output.folder import Record, Results
from .designs import other_design
from .figures import figure
from .judged import elsewhere
from .page import Section, Table, shown
from .records import by_name, quantity, same, scenario_of, words

MANY = 12  # impacts; a longer table is folded
FIRST = "what to change first"
MARGIN = "_margin"  # how names of margins end
HELPING = 3  # lines of advice that are shown


def run(found: Results, first: Results) -> Section | None:
    """One run's quantities and impacts."""
    record, mechanism = found.records.get("run"), found.mechanism
    if record is None:
        return None
    values, hits = by_name(record), record["impacts"]
    meant = once(mechanism.meant(by_name(record["design"]).get), values)
    tables = [Table("Quantities", ("quantity", "unit", "value"), [quantity(mechanism, n, values) for n in meant])]
    if hits:
        rows = [[shown(value) for value in impact.values()] for impact in hits]
        tables.append(
            Table(
                f"{len(hits)} impact{'s' if len(hits) > 1 else ''}",
                [words(name) for name in hits[0]],
                rows,
                folded=len(hits) > MANY,
            )
        )
    scenario = scenario_of(mechanism, record["scenario"])
    text = [f"{words(record['outcome']).capitalize()}; {mechanism.label(scenario)}."]
    return Section(
        mechanism.run_name.capitalize(),
        [*text, *other_design(found, first, record), *elsewhere(first, record["scenario"])],
        figure(found, mechanism.run_name, f"The {mechanism.run_name} over time"),
        tables,
        found.records.get("motion"),
        forces(found, f"Contact force, {mechanism.label(scenario)}"),
        [f"{line[:1].upper()}{line[1:]}." for line in record["outside_validity"]],
    )


def once(names: Sequence[str], *runs: Mapping[str, Any]) -> list[str]:
    """The names, of several margins of equal value in all ``runs`` the first alone: what is left is then the same."""
    kept: dict[Any, str] = {}
    for name in names:
        values = tuple(run.get(name) for run in runs)
        kept.setdefault((values, None) if name.endswith(MARGIN) else name, name)
    return [*kept.values()]


def forces(found: Results, caption: str) -> list[dict[str, Any]]:
    """The force over time of a folder, to be read off, if it has it."""
    record = found.records.get("force")
    return [] if record is None or not record["curves"] else [{"caption": caption, "curves": record["curves"]}]


def diagnosis(found: Results, every: Sequence[Results]) -> Section | None:
    """Why a run did not end as it should: way and energy left, where the rest went, the impact that turned it.

    **Arguments:** ``every``: all folders of the page; sensitivities of the same run say what to change first.
    """
    record, mechanism = found.records.get("run"), found.mechanism
    if record is None or not record.get("diagnosis"):
        return None
    told = {**record["diagnosis"], FIRST: what_to_change(found, every) or record["diagnosis"].get(FIRST, "–")}
    rows = [[heading, text] for heading, text in told.items()]
    title = f"Why not {mechanism.success}"
    return Section(title, tables=[Table("What held the run back", ("of", "what is known"), rows)])


def what_to_change(found: Results, every: Sequence[Results]) -> str:
    """The numbers whose relative change moves the mechanism's margin most, to first order; "" where no sensitivities of
    the margin at this run are among the folders."""
    for other in every:
        record = other.sensitivity
        if record is not None and record.get("advice") and _same_run(record, found.records["run"]):
            heading, *lines = record["advice"]
            asked = heading.removeprefix("What to change first, ").rstrip(":")
            return f"{'; or '.join(lines[:HELPING])}; {asked}"
    return ""


def _same_run(one: Record, other: Record) -> bool:
    parts = ("design", "scenario")
    return all(same(one[part].get(name), value) for part in parts for name, value in other[part].items())
