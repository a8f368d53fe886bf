"""A CSV file of parts, each cell with the place that a message names."""

import math
import re
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import InputError, shown
from ..files import user_path
from ..labelled.csv_table import CsvTable, read_table

NAMES = ("name", "part")  # headings of the column of names
NUMBER = re.compile(r"[-+]?[\d.,]*\d[\d.,]*")  # what looks like one, with any marks


class CatalogueCell(NamedTuple):
    """A value as typed, and ``where`` it stands, as messages name it."""

    where: str
    value: Any

    def points(self) -> Any:
        """Return the points of a curve, which a file has as text: "[[0.1, 2], [0.2, 5]]"."""
        if not isinstance(self.value, str):
            return self.value
        try:
            return tomllib.loads(f"points = {self.value}")["points"]
        except ValueError:
            raise InputError(f"{self.where} = {shown(self.value)} is no list of points [[0.1, 2.0], …]") from None


def read_csv(path: Path) -> list[tuple[str, dict[str, CatalogueCell]]]:
    """Return each part's name and cells by heading, of a file with commas, semicolons or tabs.

    A unit in a heading, "k_A [kN/m]", is that of the column's plain numbers. Between semicolons or tabs numbers may
    have a decimal comma, all of them; lines that begin with # are left out: as of measured tests.

    **Raises:** `InputError` with the line for a file that is no such table, and for a part that is named twice.
    """
    path = user_path(path)
    table = read_table(path, NAMES)
    if not table.rows:
        raise InputError(f"{path} has no part; write a line of headings, such as name, k_A [N/m], and a line a part")
    names = _headings(table)
    parts: dict[str, tuple[int, dict[str, CatalogueCell]]] = {}
    for line, row in zip(table.lines, table.rows, strict=True):
        plain = [it if known in NAMES else table.with_point(it) for (known, _), it in zip(names, row, strict=True)]
        where, name, cells = f"{path}, line {line}", "", dict[str, CatalogueCell]()
        for (heading, symbol), text in zip(names, plain, strict=True):
            if heading in NAMES and not name:
                name = text
            # An empty cell is left out, so that a curve may stand in another column.
            elif text:
                cells[heading] = CatalogueCell(f"{where}, {heading}", _typed(f"{where}, {heading}", text, symbol))
        if not name:
            raise InputError(f"{where}: the part has no name")
        if name in parts:
            raise InputError(f"{path}, line {line}: {name} stands in line {parts[name][0]} already; keep one")
        parts[name] = line, cells
    return [(name, cells) for name, (_, cells) in parts.items()]


def _headings(table: CsvTable) -> list[tuple[str, str]]:
    """Return name and unit of each column, "" for none; a heading is such as "k_A [kN/m]"."""
    # A curve's point has a bracket too, "force[2]", but no space before it.
    parts = [text.partition(" [") for text in table.headings]
    split = [(name, symbol.removesuffix("]")) for name, _, symbol in parts]
    names, where = [name for name, _ in split], f"{table.file}, line {table.header}"
    for name in names:
        if not name:
            raise InputError(f"{where}: column {names.index('') + 1} has no heading")
        if names.count(name) > 1:
            raise InputError(f"{where}: {name} is the heading of two columns; keep one")
    if not any(name in NAMES for name in names):
        hint = table.in_comment(NAMES) or f"; found {', '.join(table.headings)}"
        raise InputError(f"{where}: no column is called name{hint}")
    return split


def _typed(where: str, text: str, symbol: str) -> Any:
    """Return a cell's number with the unit of its heading, a number, a truth, or the text."""
    try:
        number = float(text)
    except ValueError:
        number = None
    if number is None:
        if NUMBER.fullmatch(text):
            raise InputError(f"{where} = {shown(text)} is no number: a file has one decimal mark, none of thousands")
        if symbol and text[0].isdigit() and not text.startswith("["):
            raise InputError(f"{where} = {shown(text)}: the heading has the unit {symbol} already; write one of them")
        return {"true": True, "false": False}.get(text, text)
    # What is not finite is no number with a unit, and is refused as it is.
    return f"{text} {symbol}" if symbol and symbol != "-" and math.isfinite(number) else number
