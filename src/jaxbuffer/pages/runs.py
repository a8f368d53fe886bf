"""What a page says of a run, of what held it back, and of a tuning."""

from collections.abc import Mapping, Sequence
from typing import Any

from ..fields import as_typed, unit
from ..output.folder import Results
from ..tuning.problem import Variable
from .designs import other_design
from .limits import Limit, case_labels, elsewhere
from .page import Cell, Section, Table, shown
from .records import by_name, ended, figure, in_figures, quantity, same, scenario_of, words

MANY = 12  # impacts; a longer table is folded
FIRST = "what to change first"
FORCE = "force [N]"  # of contacts
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
        caption = f"{len(hits)} impact{'s' if len(hits) > 1 else ''}"
        tables.append(Table(caption, [words(name) for name in hits[0]], rows, folded=len(hits) > MANY))
    scenario = scenario_of(mechanism, record["scenario"])
    text = [f"{words(record['outcome']).capitalize()}; {mechanism.view.label(scenario)}."]
    return Section(
        mechanism.view.run_name.capitalize(),
        [*text, *other_design(found, first, record), *elsewhere(first, record["scenario"])],
        figure(found, mechanism.view.run_name, f"The {mechanism.view.run_name} over time"),
        tables,
        found.records.get("motion"),
        forces(found, f"Contact force, {mechanism.view.label(scenario)}"),
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
    if record is None or not record["curves"]:
        return []
    return [{"caption": caption, "axis": FORCE, "curves": record["curves"]}, *record.get("more", ())]


def diagnosis(found: Results, every: Sequence[Results]) -> Section | None:
    """Why a run did not end as it should: way and energy left, where the rest went, the impact that turned it.

    **Arguments:** ``every``: all folders of the page; sensitivities of the same run say what to change first.
    """
    record = found.records.get("run")
    if record is None or not record.get("diagnosis"):
        return None
    told = {**record["diagnosis"], FIRST: what_to_change(found, every) or record["diagnosis"].get(FIRST, "–")}
    rows = [[heading, text] for heading, text in told.items()]
    title = f"Why not {found.success}"
    return Section(title, tables=[Table("What held the run back", ("of", "what is known"), rows)])


def what_to_change(found: Results, every: Sequence[Results]) -> str:
    """The numbers whose relative change moves the mechanism's margin most, to first order; "" where no sensitivities of
    the margin at this run are among the folders."""
    run = {part: found.records["run"][part] for part in ("design", "scenario")}
    for other in every:
        record = other.sensitivity
        if record is None or not record.get("advice"):
            continue
        if all(same(record[part].get(name), value) for part, known in run.items() for name, value in known.items()):
            heading, *lines = record["advice"]
            asked = heading.removeprefix("What to change first, ").rstrip(":")
            return f"{'; or '.join(lines[:HELPING])}; {asked}"
    return ""


def scenarios(found: Results) -> Section | None:
    """Each scenario's largest values before and after, against the limits."""
    tuned, mechanism = found.tuned, found.mechanism
    if tuned is None:
        return None
    lower, own = tuned.get("lower_limits", {}), tuned.get("quantities", {})
    known = by_name(tuned["scenarios"][0]["after"])
    left = [name for name in mechanism.tuning.left_open(by_name(tuned["design"]).get) if name in known]
    names = list(dict.fromkeys(["peak_force", *tuned["limits"], *lower, *left]))
    rows = []
    for record, label in zip(tuned["scenarios"], case_labels(found), strict=True):
        before, after = by_name(record["before"]), by_name(record["after"])
        row: list[str | Cell] = [label]
        row += [ended(mechanism, values["outcome"]) for values in (before, after)]
        for name in names:
            factor, upper = in_figures(mechanism, name, own)[2], tuned["limits"]
            sides = [Limit(name, upper[name])] if name in upper else []
            sides += [Limit(name, lower[name], True)] if name in lower else []
            row += [_value(values[name], factor, sides) for values in (before, after)]
        rows.append(row)
    headings = ["scenario", "outcome\nbefore", "\nafter"]
    for name in names:
        title, symbol, _ = in_figures(mechanism, name, own)
        headings += [f"{title}\n[{symbol}] before", "\nafter"]
    worst = found.records.get("force", {}).get("scenario", "")
    curves = forces(found, f"Contact force of the worst scenario ({worst}), before and after tuning")
    tables, corners = [Table("Before and after tuning", headings, rows)], tuned.get("corners")
    if corners is None:
        return Section("Scenarios", curves=curves, tables=tables)
    said = [f"{line[:1].upper()}{line[1:]}." for line in corners["said"]]
    holds = corners["holding"] == corners["run"]
    text = [f"The scenarios are {tuned['sample']['count']} samples of what scatters, which are no bound.", said[-1]]
    found_there = said[:-1]
    text, warnings = ([text[0], *found_there, text[1]], []) if holds else (text, found_there)
    return Section("Scenarios", text, curves=curves, tables=tables, warnings=warnings)


def _value(value: float | None, factor: float, sides: Sequence[Limit]) -> Cell:
    beyond = any(limit.broken_by(value) for limit in sides)
    return Cell(shown(None if value is None else factor * value), "bad" if beyond else "")


def search(found: Results) -> Section | None:
    """How the design was found, and how good it is."""
    tuned = found.tuned
    if tuned is None:
        return None
    usual, numbers = found.mechanism.design(), ("low", "high", "before", "value")
    rows = []
    for v in tuned["variables"]:
        told = [as_typed(v[name], unit(usual, v["path"]), v.get("shown_in", "")) for name in numbers]
        bound = Variable(v["path"], v["low"], v["high"], v.get("scale", "log")).at_bound(v["value"])
        rows.append([v["path"], told[0][1], *(shown(value) for value, _ in told), bound])
    table = Table("Variables", ("field", "unit", "low", "high", "before", "tuned", "bound"), rows)
    residual, error = tuned["first_order_residual [-]"], tuned["gradient_error [-]"]
    facts = [
        f"{tuned['message'][:1].upper()}{tuned['message'][1:]}.",
        f"{tuned['captures']} {found.mechanism.view.run_name}s; {100.0 * residual:.2g} % of the objective left to gain"
        f" by small changes (checked at rtol {tuned.get('rtol_of_check [-]', 1e-9):g}), the search's slopes right to"
        f" {100.0 * error:.2g} %.",
    ]
    if (above := tuned.get("above_floor [-]")) is not None:
        facts.append(f"The largest force is {100 * above:.3g} % above the first impact's, which no buffer softens.")
    figures = figure(found, "tune", "The search: objective, limits and variables over its evaluations")
    return Section("Tuning", facts, figures, [table])
