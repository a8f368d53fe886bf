"""What a page says of a tuning: limits, scenarios before and after, the search."""

from ..fields import unit
from .folder import Record, Results
from .page import Cell, Section, Table, shown
from .records import ROUNDING, by_name, ended, same, scenario_of, words


def limits(found: Results) -> Section | None:
    """The worst value of each limited quantity with its margin."""
    tuned, mechanism = found.tuned, found.mechanism
    if tuned is None:
        return None
    rows: list[list[str | Cell]] = []
    for name, limit in tuned["limits"].items():
        worst = max(by_name(case["after"])[name] for case in tuned["scenarios"])
        symbol, margin = _unit(found, name), f"{100 * (1 - worst / limit):.3g} %"
        rows.append([words(name), symbol, shown(worst), shown(limit), margin, _kept(not _broken(worst, limit))])
    if mechanism.success is not None:
        count = sum(case["after"]["outcome"] == mechanism.success for case in tuned["scenarios"])
        every = len(tuned["scenarios"])
        rows.append([f"scenarios {mechanism.success}", "", str(count), str(every), "", _kept(count == every)])
    table = Table("Worst over all scenarios", ("quantity", "unit", "worst", "limit", "margin", "verdict"), rows)
    said = [f"{line[:1].upper()}{line[1:]}." for line in tuned["outside_validity"]]
    return Section("Limits", [*(f"Broken: {line}." for line in tuned["broken"]), *said], tables=[table])


def scenarios(found: Results) -> Section | None:
    """Each scenario's largest values before and after, against the limits."""
    tuned, mechanism = found.tuned, found.mechanism
    if tuned is None:
        return None
    met = [scenario_of(mechanism, record) for record in tuned["scenarios"]]
    names = ["peak_force", *(name for name in tuned["limits"] if name != "peak_force")]
    rows = []
    for record, scenario in zip(tuned["scenarios"], met, strict=True):
        before, after = by_name(record["before"]), by_name(record["after"])
        row: list[str | Cell] = [mechanism.label(scenario, met)]
        row += [ended(mechanism, values["outcome"]) for values in (before, after)]
        for name in names:
            limit = tuned["limits"].get(name)
            row += [Cell(shown(v[name]), "bad" if _broken(v[name], limit) else "") for v in (before, after)]
        rows.append(row)
    headings = ["scenario", "outcome before", "after"]
    for name in names:
        headings += [f"{words(name)} [{_unit(found, name)}] before", "after"]
    figures = found.figure("force", "Contact force of the worst scenario, before and after")
    return Section("Scenarios", figures=figures, tables=[Table("Before and after tuning", headings, rows)])


def _unit(found: Results, name: str) -> str:
    """Of a limited quantity, the mechanism's or an own one, which the record describes."""
    own = (found.tuned or {}).get("quantities", {})
    return str(own[name]["unit"]) if name in own else found.mechanism.quantities[name].unit


def search(found: Results) -> Section | None:
    """How the design was found, and how good it is."""
    tuned = found.tuned
    if tuned is None:
        return None
    usual, numbers = found.mechanism.design(), ("low", "high", "before", "value")
    rows = [[v["path"], unit(usual, v["path"]), *(shown(v[n]) for n in numbers), _bound(v)] for v in tuned["variables"]]
    table = Table("Variables", ("field", "unit", "low", "high", "before", "tuned", "bound"), rows)
    residual, error = tuned["first_order_residual [-]"], tuned["gradient_error [-]"]
    facts = [
        f"{tuned['message'][:1].upper()}{tuned['message'][1:]}.",
        f"{tuned['captures']} {found.mechanism.run_name}s; first-order residual {residual:.1e} at rtol 1e-9,"
        f" the search's slopes within {error:.1e} of it.",
    ]
    if (above := tuned.get("above_floor [-]")) is not None:
        facts.append(f"The largest force is {100 * above:.3g} % above the first impact's, which no buffer softens.")
    figures = found.figure("tune", "The search: objective, limits and variables over its evaluations")
    return Section("Tuning", facts, figures, [table])


def _bound(variable: Record) -> str:
    low, high, value = (variable[name] for name in ("low", "high", "value"))
    return "at the lower" if same(value, low) else "at the upper" if same(value, high) else ""


def _broken(value: float | None, limit: float | None) -> bool:
    return limit is not None and (value is None or value > limit * (1.0 + ROUNDING))


def _kept(good: bool) -> Cell:
    return Cell("kept", "good") if good else Cell("broken", "bad")
