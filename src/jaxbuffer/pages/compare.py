"""Several folders of results side by side, tunings scenario by scenario."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from ..errors import InputError
from ..fields import get, paths, unit
from ..labelled.record import Record
from ..mechanisms.limit import Limit
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.quantity import PEAK_TIME
from ..output.folder import Results
from ..output.page_data import FORCE, chart
from ..tuning.problem.cases import numbered
from ..value_text import percent_text, relative_change, table_text
from .abstract import abstract
from .badges import badges
from .limit_check import end_count, limit_check, limits_of
from .limits import limits
from .origin import origin
from .page import Cell, Page, PageSection, Table
from .records import (
    ROUNDING,
    Display,
    case_numbers,
    case_texts,
    display,
    ended,
    figure,
    main_quantity,
    same,
    scenario_of,
    words,
)
from .review import distinct
from .runs import once

CONTENTS = {"run": "a run", "tuned": "a tuning", "sensitivity": "derivatives", "sample": "a sample", "front": "a front"}
CONTENTS |= {"choice": "a choice", "fit": "a fit"}
MULTIPLE = 10.0  # from which a ratio is told instead of a percentage
Known = tuple[float | None, bool, bool]  # a value, whether it breaks its limit, whether its run keeps all limits
UNKNOWN: Known = (None, False, False)
COLOURS = "Red: a limit is broken. Green: the lowest of a scenario, where its run keeps all limits."


def comparison(every: Sequence[Results]) -> Page:
    """Return a page with a column for each folder.

    **Raises:** `InputError` for folders of different mechanisms, or where there is nothing to compare.
    """
    # Quantities and fields of different mechanisms cannot stand in one row.
    kinds = {results.mechanism.name for results in every}
    if len(kinds) > 1:
        raise InputError(f"the folders hold results of different mechanisms: {', '.join(sorted(kinds))}")
    _check_comparable(every)
    tables = compared(every)
    names = ", ".join(str(results.folder) for results in every)
    pills = [
        Cell(f"{results.folder}: {badge.text}", badge.mark) for results in every for badge in badges([results], every)
    ]
    parts = [PageSection(table.caption, tables=[table]) for table in tables]
    if all(results.tuned is not None for results in every):
        every_limit = [tables[-1], *limited_by_scenario(every)]
        # Tables of other limited quantities are folded below that of the main one, and share its key to the colours.
        parts[-1] = dataclasses.replace(parts[-1], text=[COLOURS], tables=every_limit)
    sections = distinct(_limits(every))
    if sections and (differences := differing(every)):
        against = f"The folders are held against different limits: {'; '.join(differences)}."
        sections[0] = dataclasses.replace(sections[0], warnings=[against, *sections[0].warnings])
    parts += sections
    if curves := _forces(every):
        caption = "Contact force over time, each curve by its folder"
        parts.append(PageSection("Forces", curves=[chart(caption, FORCE, curves)]))
    run = every[0].mechanism.view.run_name
    drawn = [(results, stem, words) for results in every for stem, words in ((run, run), ("tune", "the search"))]
    if figures := [it for results, stem, words in drawn for it in figure(results, stem, f"{results.folder}: {words}")]:
        parts.append(PageSection("Figures", figures=figures))
    return Page(
        f"{every[0].mechanism.view.title}: designs compared", names, pills, [*parts, origin(every)], abstract(every)
    )


def _check_comparable(every: Sequence[Results]) -> None:
    """Raise `InputError` unless all folders hold a run, or all a tuning; it says what each holds, and what to run."""
    if any(all(name in results.records for results in every) for name in ("run", "tuned")):
        return
    contents = ", ".join(f"{results.folder} holds {_contents(results)}" for results in every)
    runs = [
        f"jaxbuffer simulate {results.folder / 'design.toml' if results.tuned else 'STUDY.toml'} --output FOLDER"
        for results in every
        if "run" not in results.records
    ]
    raise InputError(
        f"nothing to compare: {contents}; compare runs with runs or tunings with tunings;"
        f" a run is made by {' and '.join(dict.fromkeys(runs))}"
    )


def _contents(results: Results) -> str:
    contents = [words for name, words in CONTENTS.items() if name in results.records]
    contents += ["a sweep"] if results.sweep is not None else []
    return " and ".join(contents) or "a design alone"


def _limits(every: Sequence[Results]) -> list[tuple[Results, PageSection]]:
    """Return a section for each folder that says which limits it keeps, its own or those of the first folder that has
    some."""
    return [(results, section) for results in every if (section := limits(results, every, named=True)) is not None]


def limit_tables(every: Sequence[Results]) -> list[Table]:
    """Return tables of which limits each folder keeps."""
    return [table for _, section in _limits(every) for table in section.tables if not table.folded]


def _forces(every: Sequence[Results]) -> list[dict[str, Any]]:
    """Return the force of each folder's run, or of its tuning's worst scenario with the tuned design."""
    records = [(results, results.records["force"]) for results in every if "force" in results.records]
    # The last curve is that of the tuned design, and of a run the only one; there is none without a contact, and where
    # a tuning's worst scenario could not be run again.
    named = [(results, record["scenario"], record["curves"][-1]) for results, record in records if record["curves"]]
    return [{**curve, "name": f"{results.folder} ({scenario})"} for results, scenario, curve in named]


def compared(every: Sequence[Results]) -> list[Table]:
    """Return where the designs differ, and what their runs or tunings found, with a column for each folder."""
    folders = [str(results.folder) for results in every]
    tables = [_designs(every, folders)] if all(results.design is not None for results in every) else []
    if all("run" in results.records for results in every):
        tables += _runs(every, folders)
    if all(results.tuned is not None for results in every):
        tables += _ends(every, folders)
        tables.append(by_scenario(every, folders, _main_quantity(every)))
    return tables[1:] and tables


def _ends(every: Sequence[Results], folders: Sequence[str]) -> list[Table]:
    """Return in how many scenarios of each tuning the strictest end was reached that its design can have, before and
    after."""
    counts = [[end_count(results, side) for side in ("before", "after")] for results in every]
    if not any(after for _, after in counts):
        return []
    sides = ("before tuning", "after tuning")
    rows: list[list[str | Cell]] = [
        [side, *(Cell(str(pair[k] or "–")) for pair in counts)] for k, side in enumerate(sides)
    ]
    return [Table("How many scenarios end so", ("of", *folders), rows)]


def _designs(every: Sequence[Results], folders: Sequence[str]) -> Table:
    usual = every[0].mechanism.design()
    designs = [results.design for results in every if results.design is not None]
    first = designs[0]
    differ = [path for path in paths(usual) if any(not same(get(d, path), get(first, path)) for d in designs[1:])]
    rows: list[list[str | Cell]] = [
        [path, unit(usual, path), *_beside([get(d, path) for d in designs])] for path in differ
    ]
    return Table("Designs where they differ" if rows else "The designs are the same", ("field", "unit", *folders), rows)


def _runs(every: Sequence[Results], folders: Sequence[str]) -> list[Table]:
    mechanism = every[0].mechanism
    records = [results.records["run"] for results in every]
    met = [scenario_of(mechanism, record["scenario"]) for record in records]
    # Runs of different scenarios differ whatever their designs are: no difference is a merit then.
    alike = all(scenario == met[0] for scenario in met)
    labels = [mechanism.view.label(scenario, met) for scenario in met]
    # Each column has the number of its own folder's study.
    numbers = [record.get("scenario_number", "") for record in records]
    marks = ["" if it == labels[0] else "changed" for it in labels]
    shown = [numbered(*pair) for pair in zip(labels, numbers, strict=True)]
    ends: list[list[Any]] = [["scenario", *map(Cell, shown, marks)]]
    ends.append(["outcome", *(ended(mechanism, record["outcome"]) for record in records)])
    rows: list[list[Any]] = []
    meant = mechanism.meant(lambda path: any(record["design"].get(path) for record in records))
    for name in once(meant, *records):
        title, symbol, factor = display(mechanism, name)
        # Neither an earlier nor a later peak is better.
        values = [record.get(name) for record in records]
        in_unit = [None if value is None else factor * value for value in values]
        rows.append([title, symbol, *_beside(in_unit, merit=alike and name != mechanism.name_of(PEAK_TIME))])
    rows.append(["impacts", "-", *_beside([len(record["impacts"]) for record in records], merit=alike)])
    caption = (
        "Runs" if alike else "Runs of different scenarios, which tell little of the designs: simulate the same one"
    )
    return [Table("How they ended", ("of", *folders), ends), Table(caption, ("quantity", "unit", *folders), rows)]


def _beside(values: Sequence[Any], merit: bool = True) -> list[Cell]:
    """Return the cells of a row of values, in which those that differ from the first are marked.

    Numbers of ``merit`` have the relative difference behind them.
    """
    first, cells = values[0], [Cell(table_text(values[0]))]
    for value in values[1:]:
        # Two values that read as zero differ by rounding only.
        if same(value, first) or table_text(value) == table_text(first) == "0":
            cells.append(Cell(table_text(value)))
            continue
        numbers = all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in (value, first))
        # A relative difference from zero has no meaning.
        change = relative_change(first, value) if numbers and merit and abs(first) > ROUNDING else None
        text = table_text(value)
        if change is not None:
            # From ten times on a multiple says more than per cent.
            text += f" (× {value / first:.3g})" if value / first >= MULTIPLE else f" ({percent_text(change, '+.3g')})"
        cells.append(Cell(text, "changed"))
    return cells


def differing(every: Sequence[Results]) -> list[str]:
    """Return a text for each quantity on which the folders' limits differ: "buffer stroke: before ≤ 30 mm, after ≤ 25
    mm"."""
    by_folder = [_limits_of(results, every) for results in every]
    texts = []
    for key in dict.fromkeys(key for known in by_folder for key in known):
        if len({known.get(key) for known in by_folder}) > 1:
            title, symbol, factor = _display(every, key[0])
            bounds = [known.get(key) for known in by_folder]
            bounds_in_words = ["not limited" if limit is None else limit.bound_text(symbol, factor) for limit in bounds]
            sides = ", ".join(f"{results.folder} {text}" for results, text in zip(every, bounds_in_words, strict=True))
            texts.append(f"{title}: {sides}")
    return texts


def _limits_of(results: Results, every: Sequence[Results]) -> dict[tuple[str, bool], Limit]:
    """Return the limits that a folder is checked against, by the quantity's name and whether it is a lower limit."""
    check = limit_check(results, every)
    if check is None:
        return {}
    return {(it.name, it.lowest): it for it in limits_of(results.mechanism, check.source)}


def _display(every: Sequence[Results], name: str) -> Display:
    """Return how people are shown a quantity; one that a study has made may be known to one folder only."""
    own: dict[str, Any] = {}
    for results in every:
        own |= (results.tuned or results.records.get("run") or Record()).get("quantities", {})
    return display(every[0].mechanism, name, own)


def _main_quantity(every: Sequence[Results]) -> str:
    """Return the quantity that stands for the tunings' runs: an own one where the first has none of the mechanism's."""
    values = _cases(every[0])[0]["after"]
    own = (every[0].tuned or Record()).get("quantities", {})
    return main_quantity(every[0], values) or next(iter(own))


def limited_by_scenario(every: Sequence[Results]) -> list[Table]:
    """Return a folded table for each quantity that any of the folders limits, except the main one."""
    names = dict.fromkeys(name for results in every for name, _ in _limits_of(results, every))
    folders = [str(results.folder) for results in every]
    return [by_scenario(every, folders, name, folded=True) for name in names if name != _main_quantity(every)]


def by_scenario(every: Sequence[Results], folders: Sequence[str], name: str, folded: bool = False) -> Table:
    """Return a table of a quantity in each scenario that any folder has met.

    A value that breaks its limit is red; the lowest of a row is green if its run keeps all limits.
    """
    columns = [_cells(it, every, name) for it in every]
    met = _numbered_scenarios(every, folders)
    shown = _display(every, name)
    rows: list[list[str | Cell]] = []
    for case, label in met.items():
        known = [value for values in columns if (value := values.get(case, UNKNOWN)[0]) is not None]
        # A value that stands alone in its row is not the lowest of anything.
        least = min(known) if len(known) > 1 else None
        rows.append([label, *(_cell(values.get(case, UNKNOWN), least, shown) for values in columns)])
    caption = f"{shown.heading[:1].upper()}{shown.heading[1:]} after tuning, by scenario"
    return Table(caption, ("scenario", *folders), rows, folded)


def _numbered_scenarios(every: Sequence[Results], folders: Sequence[str]) -> dict[str, str]:
    """Return the label of each scenario that any folder has met, by the text that tells it apart.

    Its number stands before it; where folders number their scenarios differently, the number of each with its name.
    """
    # The labels tell all folders' scenarios apart.
    among = [scenario_of(it.mechanism, record) for it in every for record in _cases(it)]
    labels, numbers = dict[str, str](), dict[str, dict[str, str]]()
    for it, folder in zip(every, folders, strict=True):
        for record, text, number in zip(_cases(it), case_texts(it, among), case_numbers(it), strict=True):
            case = _case(it.mechanism, record)
            labels[case] = text
            numbers.setdefault(case, {})[folder] = number
    pairs = {(case, number) for case, by_folder in numbers.items() for number in by_folder.values()}
    # One number for each scenario, and one scenario for each number: then a number needs no folder.
    alike = len(pairs) == len(numbers) == len({number for _, number in pairs})

    def shown(by_folder: Mapping[str, str]) -> str:
        if alike:
            return next(iter(by_folder.values()))
        return ", ".join(f"{number} in {folder}" for folder, number in by_folder.items() if number)

    return {case: numbered(labels[case], shown(by_folder)) for case, by_folder in numbers.items()}


def _cell(known: Known, least: float | None, shown: Display) -> Cell:
    value, beyond, safe = known
    mark = "" if value is None else "bad" if beyond else "good" if safe and value == least else ""
    return Cell(shown.text(value), mark)


def _cells(results: Results, every: Sequence[Results], name: str) -> Mapping[str, Known]:
    """Return by scenario the value, whether it breaks its limit, and whether the run keeps all limits."""
    check, limits = limit_check(results, every), _limits_of(results, every)
    cases = _cases(results)
    safe = [True] * len(cases) if check is None else check.keeping
    sides = [limit for (limited, _), limit in limits.items() if limited == name]
    # A quantity that only another folder limits may not be among this one's.
    values = [case["after"].get(name) for case in cases]
    beyond = [any(not it.keeps(value) for it in sides) for value in values]
    names = [_case(results.mechanism, case) for case in cases]
    return dict(zip(names, zip(values, beyond, safe, strict=True), strict=True))


def _cases(results: Results) -> list[Record]:
    return [] if results.tuned is None else list(results.tuned["scenarios"])


def _case(mechanism: Mechanism, record: Record) -> str:
    """Return a text that is the same for the same case: all fields of a scenario, and where the built mechanism differs
    from the drawn one."""
    scenario = scenario_of(mechanism, record)
    fields = [f"{words(name)} {table_text(getattr(scenario, name))} {unit(scenario, name)}" for name in paths(scenario)]
    built = [(kind, *it) for kind in ("factors", "shifts", "values") for it in record.get(kind, {}).items()]
    return ", ".join([*fields, *(f"{kind} {path} {value}" for kind, path, value in built)])
