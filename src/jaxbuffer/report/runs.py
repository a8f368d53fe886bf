"""What a page says of a run, its sensitivities, a sweep, and where the numbers come from."""

from collections import Counter
from collections.abc import Sequence

from .designs import other_design
from .folder import Results
from .page import Cell, Section, Table, shown
from .records import by_name, ended, quantity, scenario_of, words

MANY = 12  # impacts; a longer table is folded
MARKS = {"trusted": "good", "check": "unsure", "refused": "bad"}


def run(found: Results, first: Results) -> Section | None:
    """One run's quantities and impacts."""
    record, mechanism = found.run, found.mechanism
    if record is None:
        return None
    values, hits = by_name(record), record["impacts"]
    tables = [
        Table("Quantities", ("quantity", "unit", "value"), [quantity(mechanism, n, values) for n in mechanism.swept])
    ]
    if hits:
        rows = [[shown(value) for value in impact.values()] for impact in hits]
        tables.append(Table(f"{len(hits)} impacts", [words(name) for name in hits[0]], rows, folded=len(hits) > MANY))
    scenario = scenario_of(mechanism, record["scenario"])
    text = [f"{record['outcome'].capitalize()}; {mechanism.label(scenario)}.", *other_design(found, first, record)]
    text += [f"{line[:1].upper()}{line[1:]}." for line in record["outside_validity"]]
    figures = found.figure(mechanism.run_name, f"The {mechanism.run_name} over time")
    return Section(mechanism.run_name.capitalize(), text, figures, tables, found.motion)


def sensitivity(found: Results, first: Results) -> Section | None:
    """Elasticities with their verdicts."""
    record = found.sensitivity
    if record is None:
        return None
    of_quantity: dict[str, list[dict]] = {}
    for row in record["derivatives"]:
        of_quantity.setdefault(row["quantity"], []).append(row)
    rows: list[list[str | Cell]] = []
    for name, derivatives in of_quantity.items():
        verdict = derivatives[0]["verdict"] or "not certified"
        errors = [row["estimated_error [-]"] for row in derivatives if row["estimated_error [-]"] is not None]
        worst = f"{max(errors):.1e}" if errors else "–"
        values = [shown(row["elasticity [-]"]) for row in derivatives]
        rows.append([words(name), *values, worst, Cell(verdict, MARKS.get(verdict, ""))])
    parameters = [row["parameter"] for row in next(iter(of_quantity.values()))]
    caption = "Elasticities: by how many per cent a quantity grows for one per cent of a number"
    text, certificate = other_design(found, first, record), record["certificate"]
    if certificate is not None:
        text.append(f"Certificate: {certificate['verdict']}; {certificate['reason']}.")
    table = Table(caption, ("quantity", *parameters, "error at most", "verdict"), rows)
    return Section("Sensitivity", text, tables=[table])


def sweep(found: Results) -> Section | None:
    """What a sweep covers, how its runs ended, and its maps."""
    if found.sweep is None:
        return None
    covered = repr(found.sweep).strip().splitlines()[0]
    counts = Counter(outcome.name for outcome in found.sweep.found.outcomes)
    rows: list[list[str | Cell]] = [[ended(found.mechanism, name), str(count)] for name, count in counts.items()]
    figures = found.figure("sweep", "The sweep's quantities over the swept numbers")
    return Section("Envelope", [covered], figures, [Table("How the runs ended", ("outcome", "runs"), rows)])


def origin(every: Sequence[Results]) -> Section:
    """Where the numbers come from, and how exact the runs were."""
    rows: list[list[str]] = []
    for found in every:
        for record in found.records:
            told = [(words(name), shown(value)) for name, value in record.get("provenance", {}).items()]
            balance = record.get("numerical_balance", {})
            told += [(f"numerical error: {words(n)}", "–" if v is None else f"{v:.1e}") for n, v in balance.items()]
            rows += [[str(found.folder), *pair] for pair in [*told, ("jaxbuffer", record["jaxbuffer"])]]
    text = (
        "Verification: equations, events and gradients are checked against closed forms, published numbers and"
        " independent programs; docs/verification.md of this version has what was measured.",
    )
    unique = [list(row) for row in dict.fromkeys(map(tuple, rows))]
    return Section("Provenance", text, tables=[Table("Origin of the numbers", ("folder", "what", "value"), unique)])
