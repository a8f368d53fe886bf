"""What a page says of a choice: the best combination of parts, what decides it, and the ranking."""

from collections.abc import Mapping, Sequence
from typing import Any

from ..choosing.catalogue import TOTALS
from ..fields import as_typed, unit
from ..labelled.record import Record, heading
from ..mechanisms.limit import IMPACTS, Limit
from ..output.folder import Results
from ..tuning.report.limit_rows import CLOSE, state_of
from ..value_text import percent_text, relative_change, table_text, with_unit
from .limit_check import LimitCheck, required_success
from .limits import CELLS, CHOSEN, HEADINGS, lever_tables, limit_cells
from .page import Cell, PageSection, Table
from .records import display, ended, figure, main_first, sentence, units_of, words

NONE_KEEPS = "no combination keeps every limit"
LISTED = 40  # scenarios; a longer table is folded
Row = list[str | Cell]


def choice(results: Results) -> PageSection | None:
    """Return the best combination against its limits, the ranking, the bound and how many runs it took."""
    record = results.records.get("choice")
    if record is None:
        return None
    best, text = _best(record), [sentence(record["message"])]
    warnings = [sentence(line) for line in record["warnings"]]
    corners = None if best is None else best["corners"]
    lines = [sentence(line) for line in record["lines"]]
    if best is None:
        return PageSection("Choice", [*text, *lines], warnings=warnings)
    if corners is not None and corners["holding"] < corners["run"]:
        warnings.insert(0, f"It {_held(corners)} only.")
    check = choice_check(results)
    tables = [] if check is None else [_limits(record, best, check), *lever_tables(results, record, CHOSEN)]
    tables += [_ranking(results, record), _scenarios(results, check), _catalogues(results, record)]
    caption = "The best combinations: their objective, and what is left of each limit"
    return PageSection(
        "Choice", [*text, _deciding(best), *lines], figure(results, "choice", caption), tables, warnings=warnings
    )


def choice_badges(results: Results) -> list[Cell]:
    """Return what a reader asks first of a choice: which parts, whether limits and corners hold, and the objective."""
    record = results.records.get("choice")
    if record is None:
        return []
    best = _best(record)
    if best is None or not record["feasible"]:
        return [Cell(NONE_KEEPS, "bad")]
    close = any(it["left"] is not None and it["left"] < CLOSE for it in best["margins"])
    cells = [
        Cell(f"chosen: {_named(best)}", "good"),
        Cell("at a limit" if close else "all limits kept", "unsure" if close else "good"),
    ]
    if (corners := best["corners"]) is not None:
        cells.append(Cell(_held(corners), "good" if corners["holding"] == corners["run"] else "bad"))
    return [*cells, Cell(f"{words(record['objective'])}: {_objective(results, record, best['objective'])}")]


def choice_abstract(results: Results, every: Sequence[Results] = ()) -> str:
    """Return the choice in a few sentences; they are the same whatever ``every`` holds."""
    record = results.records.get("choice")
    if record is None:
        return ""
    best, tally = _best(record), record["tally"]
    text = sentence(record["message"])
    if best is not None and record["feasible"]:
        text += f" {_deciding(best)}"
    if best is not None and best["corners"] is not None:
        text += f" Of the tolerances it {_held(best['corners'])}."
    return f"{text} {tally['runs']} of {tally['possible']} {results.mechanism.view.run_name}s were run to find it."


def chosen_by(results: Results) -> Mapping[str, str]:
    """Return what has set each field of a choice's design, by path: "spring S5"; empty for another folder."""
    record = results.records.get("choice")
    best = None if record is None else _best(record)
    if record is None or best is None:
        return {}
    sources = dict(best["set_by"])
    for role, name in best["parts"].items():
        # Names are unique within a catalogue, not among several.
        (part,) = (it for it in record["parts"][role] if it["name"] == name)
        # A rounded number's role is its path; what was tuned after the choice is no longer the part's.
        sources |= {path: f"{role} {name}" for path in part if path != role and sources.get(path) == name}
    return sources


def choice_check(results: Results) -> LimitCheck | None:
    """Return the best combination's runs with the limits that they must keep; None without a combination."""
    record, mechanism = results.records.get("choice"), results.mechanism
    best = None if record is None else _best(record)
    if record is None or best is None:
        return None
    cases = choice_cases(results)
    return LimitCheck(
        mechanism=mechanism,
        source=record,
        source_folder="",
        labels=[case["label"] for case in cases],
        values=cases,
        outcomes=[case["outcome"] for case in cases],
        success=required_success(results, record),
    )


def choice_cases(results: Results) -> list[Record]:
    """Return the scenarios of a choice's best combination; none without one."""
    best = _best(results.records["choice"])
    return [] if best is None else list(best["scenarios"])


def asked_of_choice(results: Results) -> list[list[str]]:
    """Return what a choice is by: its objective, how many parts there are, and limits on their price and mass."""
    record = results.records["choice"]
    rows = [["objective", words(record["objective"]), "as small as possible"]]
    if "then" in record:
        tolerance = percent_text(record["then_tolerance"])
        rows.append(["then", words(record["then"]), f"of those within {tolerance} of the least objective"])
    rows += [["parts", role, f"one of {len(catalogue)}"] for role, catalogue in record["parts"].items()]
    return rows + [
        ["limit", f"{limit.name} of all parts", limit.bound_text(unit)] for limit, unit in _limits_on_sums(record)
    ]


def _limits_on_sums(record: Record) -> list[tuple[Limit, str]]:
    return [(Limit(name, bound), unit) for name, unit, bound in _sums(record["limits_on_sums"])]


def _sums(record: Record) -> list[tuple[str, str, Any]]:
    """Return name, unit and value of price and mass, of those that a record has."""
    return [(name, record.units.get(name, ""), value) for name, value in record.items() if name in TOTALS]


def _best(record: Record) -> Record | None:
    return record["ranking"][0] if record["ranking"] else None


def _named(alternative: Record) -> str:
    """Return the parts of a combination, without the role where a name tells it."""
    return ", ".join(f"{role} {name}" for role, name in alternative["parts"].items())


def _held(corners: Record) -> str:
    searched = " searched for" if corners["searched"] else ""
    return f"holds in {corners['holding']} of {corners['run']} corners{searched}"


def _deciding(best: Record) -> str:
    """Return where the objective is largest, and which limit leaves least."""
    text = f"Its objective is largest at {best['largest_at']}"
    tightest = best["margins"][0] if best["margins"] else None
    if tightest is None or tightest["left"] is None:
        return f"{text}."
    left = f"leaves least, {percent_text(tightest['left'], '.3g')}" if tightest["left"] >= 0.0 else "is farthest broken"
    return f"{text}; of its limits {words(tightest['limit'])} {left}, at {tightest['at']}."


def _objective(results: Results, record: Record, value: float | None) -> str:
    symbol, factor = _in_figures(results, record)
    return "–" if value is None else with_unit(factor * value, symbol, 4)


def _in_figures(results: Results, record: Record, name: str = "objective") -> tuple[str, float]:
    """Return the unit in which people are shown an objective, or ``then``, and how many of those its own unit is."""
    symbol = record[f"{name}_unit"]
    known = results.mechanism.quantities.get(record[name].partition(",")[0])
    return known.in_figures if known is not None and known.unit == symbol else (symbol, 1.0)


def _limits(record: Record, best: Record, check: LimitCheck) -> Table:
    """Return the best combination against every limit, on price and mass too."""
    rows, totals = limit_cells(check), {name: it for name, _, it in _sums(best)}
    for limit, symbol in _limits_on_sums(record):
        value = totals[limit.name]
        share = limit.margin(value)
        text = [
            f"{limit.name} of all parts",
            symbol,
            table_text(value),
            "–",
            limit.bound_text(),
            percent_text(share, ".3g"),
        ]
        rows.append([*text, CELLS[state_of(limit, value, share)]])
    over = "largest over all samples, no bound" if "sample" in record else "worst over all scenarios"
    return Table(f"The best combination, {over}, against the limits of its study", HEADINGS, rows)


def _ranking(results: Results, record: Record) -> Table:
    """Return the best combinations, and the continuous optimum below them."""
    symbol, factor = _in_figures(results, record)
    ranked, roles = record["ranking"], [*record["ranking"][0]["parts"]]
    first, totals = ranked[0], [(name, unit) for name, unit, _ in _sums(ranked[0])]
    then_symbol, then_factor = _in_figures(results, record, "then") if "then" in record else ("", 1.0)
    # Price or mass alone has a column of its own.
    shown = "then" in record and record["then"] not in [name for name, _ in totals]
    then = [heading("then", then_symbol)] if shown else []
    rows: list[Row] = []
    for place, it in enumerate(ranked, 1):
        # Against a combination that breaks limits, and may be low because of that, a difference says nothing.
        change = relative_change(first["objective"], it["objective"]) if place > 1 and it["feasible"] else None
        tightest = it["margins"][0] if it["margins"] else None
        sums = {name: value for name, _, value in _sums(it)}
        row: Row = [
            str(place),
            *it["parts"].values(),
            table_text(None if it["objective"] is None else factor * it["objective"]),
        ]
        row += ["–" if change is None else percent_text(change, ".2g")]
        row += [table_text(then_factor * it["then"]) for _ in then]
        row += [table_text(sums[name]) for name, _ in totals]
        row += [it["largest_at"], "–" if tightest is None else words(tightest["quantity"])]
        left = None if tightest is None else tightest["left"]
        row.append(Cell("–" if left is None else percent_text(left, ".3g"), "" if it["feasible"] else "bad"))
        rows.append(row)
    bounds = {"continuous optimum": record["continuous_optimum"], "before rounding": record["continuous_objective"]}
    for name, value in bounds.items():
        if value is not None:
            change = relative_change(first["objective"], value)
            above = "–" if change is None or not record["feasible"] else percent_text(change, ".2g")
            rows.append(
                [
                    name,
                    *("–" for _ in roles),
                    table_text(factor * value),
                    above,
                    *("–" for _ in (*then, *totals, 1, 2, 3)),
                ]
            )
    headings = ["rank", *roles, heading("objective", symbol), "above the first", *then]
    headings += [heading(*it) for it in totals]
    caption = "Ranking" if record["feasible"] else "Nearest to the limits, none within them"
    return Table(caption, [*headings, "largest at", "tightest limit", "left of it"], rows)


def _scenarios(results: Results, check: LimitCheck | None) -> Table:
    """Return the main quantity and the limited ones of the best combination in each scenario."""
    assert check is not None
    mechanism, own = results.mechanism, check.source.get("quantities", {})
    names = main_first(results, check.values[0], (it.name for it in check.limits))
    shown = {name: display(mechanism, name, own) for name in names if name in check.values[0] and name != IMPACTS}
    rows: list[Row] = []
    for label, case in zip(check.labels, check.values, strict=True):
        row: Row = [label, ended(mechanism, case["outcome"])]
        for name, it in shown.items():
            broken = any(limit.name == name and not limit.keeps(case[name]) for limit in check.limits)
            row.append(Cell(it.text(case[name]), "bad" if broken else ""))
        rows.append(row)
    headings = ("scenario", "outcome", *(it.heading for it in shown.values()))
    return Table("The best combination, scenario by scenario", headings, rows, folded=True)


def _catalogues(results: Results, record: Record) -> Table:
    """Return every part that was chosen from, and what it sets."""
    units = {name: symbol for name, symbol, _ in _sums(record["ranking"][0])}
    units |= {path: unit(results.mechanism.design(), path) for path in record["ranking"][0]["set_by"]}
    typed, rows = units_of(results), list[Row]()
    for role, catalogue in record["parts"].items():
        for part in catalogue:
            fields = {path: value for path, value in part.items() if path != "name"}
            texts = (f"{path} = {_value(it, units.get(path, ''), typed.get(path, ''))}" for path, it in fields.items())
            rows.append([role, part["name"], ", ".join(texts)])
    return Table(f"What was chosen from: {len(rows)} parts", ("for", "part", "sets"), rows, folded=True)


def _value(value: Any, symbol: str, typed: str) -> str:
    """Return a part's number in the unit that it was typed with."""
    if isinstance(value, list):
        return f"curve of {len(value)} points"
    return with_unit(*as_typed(value, symbol, typed), 4) if isinstance(value, (int, float)) else table_text(value)
