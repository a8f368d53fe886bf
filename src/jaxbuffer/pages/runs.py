"""What a page says of a run, of what held it back, and of a tuning."""

from collections.abc import Mapping, Sequence
from typing import Any

from ..fields import as_typed, unit
from ..labelled.record import Record, headings
from ..mechanisms.limit import Limit, both_sides
from ..output.folder import Results
from ..output.page_data import FORCE, chart
from ..tuning.problem.variable import Variable
from ..value_text import percent_text, table_text
from .designs import other_design
from .limit_check import end_count
from .limits import corners_verdict
from .page import Cell, PageSection, Table
from .records import Display, case_labels, display, elsewhere, ended, figure, main_first, run_in_sentence, same, words

MANY = 12  # impacts; a longer table is folded
LISTED = 40  # scenarios; a longer table is folded
FIRST = "what to change first"
MARGIN = "_margin"  # how names of margins end
HELPING = 3  # lines of advice that are shown


def run(results: Results, first: Results) -> PageSection | None:
    """Return one run's quantities and impacts."""
    record, mechanism = results.records.get("run"), results.mechanism
    if record is None:
        return None
    hits = record["impacts"]
    shown = {name: display(mechanism, name) for name in once(mechanism.meant(record["design"].get), record)}
    rows = [[it.title, it.unit, it.text(record.get(name))] for name, it in shown.items()]
    tables = [Table("Quantities", ("quantity", "unit", "value"), rows)]
    if hits:
        rows = [[table_text(value) for value in impact.values()] for impact in hits]
        caption = f"{len(hits)} impact{'s' if len(hits) > 1 else ''}"
        columns = headings({words(name): hits[0].units.get(name, "") for name in hits[0]})
        tables.append(Table(caption, columns, rows, folded=len(hits) > MANY))
    where = run_in_sentence(mechanism, record)
    text = [f"{words(record['outcome']).capitalize()}; {where}."]
    return PageSection(
        mechanism.view.run_name.capitalize(),
        [*text, *other_design(results, first, record), *elsewhere(first, record["scenario"])],
        figure(results, mechanism.view.run_name, f"The {mechanism.view.run_name} over time"),
        tables,
        results.records.get("motion"),
        forces(results, f"Contact force, {where}"),
        [f"{line[:1].upper()}{line[1:]}." for line in [*record.get("cautions", ()), *record["outside_validity"]]],
    )


def once(names: Sequence[str], *runs: Mapping[str, Any]) -> list[str]:
    """Return the names; of several margins of equal value in all ``runs`` only the first, because they say the same."""
    names_by_value: dict[Any, str] = {}
    for name in names:
        values = tuple(run.get(name) for run in runs)
        # Margins are told apart by their values, all other quantities by their names.
        names_by_value.setdefault((values, None) if name.endswith(MARGIN) else name, name)
    return [*names_by_value.values()]


def forces(results: Results, caption: str) -> list[dict[str, Any]]:
    """Return the force over time of a folder, to be read off, if it has it."""
    record = results.records.get("force")
    # A tuning has no curves where its worst scenario could not be run again.
    if record is None or not record["curves"]:
        return []
    return [chart(caption, FORCE, record["curves"]), *record.get("more", ())]


def diagnosis(results: Results, every: Sequence[Results]) -> PageSection | None:
    """Return why a run did not end as it should: way and energy left, where the rest went, the impact that turned it.

    **Arguments:** ``every``: all folders of the page; sensitivities of the same run say what to change first.
    """
    record = results.records.get("run")
    if record is None or not record.get("diagnosis"):
        return None
    rows_by_heading = {
        **record["diagnosis"],
        FIRST: what_to_change(results, every) or record["diagnosis"].get(FIRST, "–"),
    }
    rows = [[heading, text] for heading, text in rows_by_heading.items()]
    title = f"Why not {results.success}"
    return PageSection(title, tables=[Table("What held the run back", ("of", "what is known"), rows)])


def what_to_change(results: Results, every: Sequence[Results]) -> str:
    """Return the numbers whose relative change moves the mechanism's margin most, to first order.

    The text is "" where no folder has sensitivities of the margin at this run.
    """
    run = {part: results.records["run"][part] for part in ("design", "scenario")}
    for other in every:
        record = other.sensitivity
        if record is None or not record.get("advice"):
            continue
        # Derivatives hold where they were taken: advice counts for this very run alone.
        if all(same(record[part].get(name), value) for part, known in run.items() for name, value in known.items()):
            heading, *lines = record["advice"]
            question = heading.removeprefix("What to change first, ").rstrip(":")
            return f"{'; or '.join(lines[:HELPING])}; {question}"
    return ""


def scenarios(results: Results) -> PageSection | None:
    """Return each scenario's largest values before and after, against the limits."""
    tuned, mechanism = results.tuned, results.mechanism
    if tuned is None:
        return None
    lower, own = tuned.get("lower_limits", {}), tuned.get("quantities", {})
    known = tuned["scenarios"][0]["after"]
    left = [name for name in mechanism.tuning.left_open(tuned["design"].get) if name in known]
    names = main_first(results, known, [*tuned["limits"], *lower, *left])
    shown = {name: display(mechanism, name, own) for name in names}
    rows = []
    for record, label in zip(tuned["scenarios"], case_labels(results), strict=True):
        before, after = record["before"], record["after"]
        row: list[str | Cell] = [label]
        row += [ended(mechanism, values["outcome"]) for values in (before, after)]
        for name, it in shown.items():
            sides = [limit for limit in both_sides(tuned["limits"], lower) if limit.name == name]
            row += [_value(values[name], it, sides) for values in (before, after)]
        rows.append(row)
    headings = ["scenario", "outcome\nbefore", "\nafter"]
    for it in shown.values():
        headings += [f"{it.title}\n[{it.unit}] before", "\nafter"]
    worst = results.records.get("force", Record()).get("scenario", "")
    which = "sample with the largest force" if "sample" in tuned else "worst scenario"
    curves = forces(results, f"Contact force of the {which} ({worst}), before and after tuning")
    tables, corners = [Table("Before and after tuning", headings, rows, len(rows) > LISTED)], tuned.get("corners")
    counts = [end_count(results, side) for side in ("before", "after")]
    reached = [f"Before tuning {counts[0]} scenarios, after it {counts[1]}."] if counts[1] else []
    if corners is None or "sample" not in tuned:
        return PageSection("Scenarios", reached, curves=curves, tables=tables)
    lines = [f"{line[:1].upper()}{line[1:]}." for line in corners["lines"]]
    holds = not corners_verdict(tuned)
    text = [f"The scenarios are {tuned['sample']['count']} samples of what scatters, which are no bound.", lines[-1]]
    of_corners = lines[:-1]
    # Corners that hold are a fact among others; those that do not are a warning.
    text, warnings = ([text[0], *of_corners, text[1]], []) if holds else (text, of_corners)
    return PageSection("Scenarios", [*reached, *text], curves=curves, tables=tables, warnings=warnings)


def _value(value: float | None, shown: Display, sides: Sequence[Limit]) -> Cell:
    beyond = any(not limit.keeps(value) for limit in sides)
    return Cell(shown.text(value), "bad" if beyond else "")


def search(results: Results) -> PageSection | None:
    """Return how the design was found, and how good it is."""
    tuned = results.tuned
    if tuned is None:
        return None
    usual, numbers = results.mechanism.design(), ("low", "high", "before", "value")
    rows = []
    for v in tuned["variables"]:
        values = [as_typed(v[name], unit(usual, v["path"]), v.get("display_unit", "")) for name in numbers]
        bound = Variable(v["path"], v["low"], v["high"], v.get("scale", "log")).at_bound(v["value"])
        rows.append([v["path"], values[0][1], *(table_text(value) for value, _ in values), bound])
    table = Table("Variables", ("field", "unit", "low", "high", "before", "tuned", "bound"), rows)
    residual, error = tuned["first_order_residual"], tuned["gradient_error"]
    facts = [
        f"{tuned['message'][:1].upper()}{tuned['message'][1:]}.",
        f"{tuned['captures']} {results.mechanism.view.run_name}s; {percent_text(residual)} of the objective left to"
        f" gain by small changes (checked at rtol {tuned.get('rtol_of_check', 1e-9):g}), the search's slopes right"
        f" to {percent_text(error)}.",
    ]
    if (above := tuned.get("above_lower_bound")) is not None:
        more = percent_text(above, ".3g")
        facts.append(f"The largest force is {more} above the first impact's, which no buffer softens.")
    if levers := "; ".join(tuned.get("first_impact_levers", [])):
        facts.append(f"{levers[:1].upper()}{levers[1:]}.")
    figures = figure(results, "tune", "The search: objective, limits and variables over its evaluations")
    return PageSection("Tuning", facts, figures, [table])
