"""What a page says of a run, of what held it back, and of its sensitivities."""

from collections.abc import Mapping, Sequence
from typing import Any

from ..output.folder import Record, Results
from .designs import other_design
from .figures import figure
from .judged import elsewhere
from .page import Cell, Section, Table, shown
from .records import by_name, in_figures, quantity, same, scenario_of, words

MANY = 12  # impacts; a longer table is folded
MARKS = {"trusted": "good", "check": "unsure", "refused": "bad"}
FIRST = "what to change first"
MARGIN = "_margin"  # how names of margins end
HELPING = 3  # lines of advice that are shown


def run(found: Results, first: Results) -> Section | None:
    """One run's quantities and impacts."""
    record, mechanism = found.records.get("run"), found.mechanism
    if record is None:
        return None
    values, hits = by_name(record), record["impacts"]
    meant = _once(mechanism.meant(by_name(record["design"]).get), values)
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


def _once(names: Sequence[str], values: Mapping[str, Any]) -> list[str]:
    """The names, of several margins of equal value the first alone: what is left is then the same."""
    margins = [values.get(name) for name in names if name.endswith(MARGIN)]
    twice = [name for name in names if name.endswith(MARGIN) and margins.count(values.get(name)) > 1]
    return [name for name in names if name not in twice[1:]]


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


def sensitivity(found: Results, first: Results) -> Section | None:
    """Elasticities with their verdicts."""
    record = found.sensitivity
    if record is None:
        return None
    of_quantity: dict[str, list[Record]] = {}
    for row in record["derivatives"]:
        of_quantity.setdefault(row["quantity"], []).append(row)
    rows: list[list[str | Cell]] = []
    for name, derivatives in of_quantity.items():
        if _signed(derivatives):
            continue
        verdict = derivatives[0]["verdict"] or "not certified"
        errors = [row["estimated_error [-]"] for row in derivatives if row["estimated_error [-]"] is not None]
        worst = f"{max(errors):.1e}" if errors else "–"
        values = [shown(row["elasticity [-]"]) for row in derivatives]
        rows.append([_title(found, name), *values, worst, Cell(verdict, MARKS.get(verdict, ""))])
    parameters = [row["parameter"] for row in next(iter(of_quantity.values()))]
    caption = "Elasticities: by how many per cent a quantity grows for one per cent of a number"
    text, certificate = other_design(found, first, record), record["certificate"]
    text += elsewhere(first, record["scenario"])
    if certificate is not None:
        text.append(f"Certificate: {certificate['verdict']}; {certificate['reason']}.")
    tables = [Table(caption, ("quantity", *parameters, "error at most", "verdict"), rows)] if rows else []
    signed = {_title(found, name): derivatives for name, derivatives in of_quantity.items() if _signed(derivatives)}
    return Section("Sensitivity", text, tables=[*tables, *_slopes(signed)])


def _title(found: Results, name: str) -> str:
    """A quantity's title, or what one of an impact is called."""
    return in_figures(found.mechanism, name)[0] if name in found.mechanism.quantities else words(name)


def _signed(rows: Sequence[Record]) -> bool:
    """Whether a quantity has no elasticities, as it can change sign."""
    return all(row["elasticity [-]"] is None for row in rows)


def _slopes(signed: Mapping[str, Sequence[Record]]) -> list[Table]:
    """Derivatives of quantities that have no elasticities."""
    rows = [
        [title, row["parameter"], shown(row["gradient"]), row["gradient_unit"], row["verdict"] or "not certified"]
        for title, derivatives in signed.items()
        for row in derivatives
    ]
    headings = ("quantity", "by", "derivative", "unit", "verdict")
    return [Table("Derivatives of what can change sign", headings, rows)] if rows else []
