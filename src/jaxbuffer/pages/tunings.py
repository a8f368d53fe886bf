"""What a page says of a tuning: scenarios before and after, the search."""

from ..fields import as_typed, unit
from ..output.folder import Record, Results
from ..tuning.problem import Variable
from .figures import figure
from .judged import case_labels
from .limits import broken
from .page import Cell, Section, Table, shown
from .records import by_name, ended, in_figures
from .runs import forces


def scenarios(found: Results) -> Section | None:
    """Each scenario's largest values before and after, against the limits."""
    tuned, mechanism = found.tuned, found.mechanism
    if tuned is None:
        return None
    lower, own = tuned.get("lower_limits", {}), tuned.get("quantities", {})
    names = list(dict.fromkeys(["peak_force", *tuned["limits"], *lower]))
    rows = []
    for record, label in zip(tuned["scenarios"], case_labels(found), strict=True):
        before, after = by_name(record["before"]), by_name(record["after"])
        row: list[str | Cell] = [label]
        row += [ended(mechanism, values["outcome"]) for values in (before, after)]
        for name in names:
            factor, sides = in_figures(mechanism, name, own)[2], (tuned["limits"].get(name), lower.get(name))
            row += [_value(values[name], factor, *sides) for values in (before, after)]
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


def _value(value: float | None, factor: float, high: float | None, low: float | None) -> Cell:
    beyond = broken(value, high) or broken(value, low, lowest=True)
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
        rows.append([v["path"], told[0][1], *(shown(value) for value, _ in told), _bound(v)])
    table = Table("Variables", ("field", "unit", "low", "high", "before", "tuned", "bound"), rows)
    residual, error = tuned["first_order_residual [-]"], tuned["gradient_error [-]"]
    facts = [
        f"{tuned['message'][:1].upper()}{tuned['message'][1:]}.",
        f"{tuned['captures']} {found.mechanism.run_name}s; {100.0 * residual:.2g} % of the objective left to gain"
        f" by small changes (checked at rtol 1e-9), the search's slopes right to"
        f" {100.0 * error:.2g} %.",
    ]
    if (above := tuned.get("above_floor [-]")) is not None:
        facts.append(f"The largest force is {100 * above:.3g} % above the first impact's, which no buffer softens.")
    figures = figure(found, "tune", "The search: objective, limits and variables over its evaluations")
    return Section("Tuning", facts, figures, [table])


def _bound(variable: Record) -> str:
    it = Variable(variable["path"], variable["low"], variable["high"], variable.get("scale", "log"))
    return it.at_bound(variable["value"])
