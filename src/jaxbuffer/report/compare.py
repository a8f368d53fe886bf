"""Several folders of results side by side."""

from collections.abc import Sequence
from typing import Any

from ..errors import InputError
from ..fields import paths, unit
from .folder import Record, Results
from .page import Cell, Page, Section, Table, shown
from .records import by_name, ended, same, scenario_of
from .review import verdicts
from .runs import origin


def comparison(every: Sequence[Results]) -> Page:
    """A page with a column for each folder. **Raises:** `InputError` for folders of different mechanisms, or where
    there is nothing to compare."""
    kinds = {found.mechanism.name for found in every}
    if len(kinds) > 1:
        raise InputError(f"the folders hold results of different mechanisms: {', '.join(sorted(kinds))}")
    tables = compared(every)
    if not tables:
        raise InputError("nothing to compare: the folders need results of simulate or of tune, all of the same command")
    names = ", ".join(str(found.folder) for found in every)
    told = [
        Cell(f"{found.folder.name}: {verdict.text}", verdict.mark) for found in every for verdict in verdicts([found])
    ]
    figures = [
        figure
        for found in every
        for stem in (found.mechanism.run_name, "tune")
        for figure in found.figure(stem, f"{found.folder}: {'the search' if stem == 'tune' else stem}")
    ]
    parts = [Section(table.caption, tables=[table]) for table in tables]
    parts += [Section("Figures", figures=figures)] if figures else []
    return Page(f"{every[0].mechanism.title}: designs compared", names, told, [*parts, origin(every)])


def compared(every: Sequence[Results]) -> list[Table]:
    """Where the designs differ, and what their runs or tunings found, with a column for each folder."""
    folders = [str(found.folder) for found in every]
    tables = [_designs(every, folders)] if all(found.records for found in every) else []
    if all(found.run is not None for found in every):
        tables.append(_runs(every, folders))
    if all(found.tuned is not None for found in every):
        tables.append(_scenarios(every, folders))
    return tables[1:] and tables


def _designs(every: Sequence[Results], folders: Sequence[str]) -> Table:
    usual = every[0].mechanism.design()
    records = [by_name(found.design or {}) for found in every]
    differ = [path for path in paths(usual) if any(not same(r.get(path), records[0].get(path)) for r in records[1:])]
    rows = [[path, unit(usual, path), *(shown(record.get(path)) for record in records)] for path in differ]
    return Table("Designs where they differ" if rows else "The designs are the same", ("field", "unit", *folders), rows)


def _runs(every: Sequence[Results], folders: Sequence[str]) -> Table:
    mechanism = every[0].mechanism
    records = [found.run for found in every if found.run is not None]
    rows: list[list[Any]] = [["outcome", "", *(ended(mechanism, record["outcome"]) for record in records)]]
    for name in mechanism.swept:
        symbol = mechanism.quantities[name].unit
        values = [record.get(f"{name} [{symbol}]") for record in records]
        rows.append([name.replace("_", " "), symbol, *map(shown, values)])
    rows.append(["impacts", "-", *(str(len(record["impacts"])) for record in records)])
    return Table("Runs", ("quantity", "unit", *folders), rows)


def _scenarios(every: Sequence[Results], folders: Sequence[str]) -> Table:
    """The largest force of each scenario, the lowest one of a row marked."""
    mechanism = every[0].mechanism
    met = [scenario_of(mechanism, case) for case in _cases(every[0])]
    rows: list[list[Any]] = [
        [mechanism.label(scenario, met), *(_force(found, k) for found in every)] for k, scenario in enumerate(met)
    ]
    for row in rows:
        values = [value for value in row[1:] if value is not None]
        row[1:] = [Cell(shown(x), "good" if values and x == min(values) else "") for x in row[1:]]
    return Table("Peak force [N] after tuning, by scenario", ("scenario", *folders), rows)


def _cases(found: Results) -> list[Record]:
    return [] if found.tuned is None else list(found.tuned["scenarios"])


def _force(found: Results, k: int) -> float | None:
    cases = _cases(found)
    return cases[k]["after"]["peak_force [N]"] if k < len(cases) else None
