"""A CSV file of parts, each cell with the place that a message names."""

import csv
import io
import math
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import InputError, shown
from ..files import user_path
from ..labelled.record import parts as name_and_unit

NAMES = ("name", "part")  # headings of the column of names
DELIMITERS = ",;\t"


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

    A unit in a heading, "k_A [kN/m]", is that of the column's plain numbers. Lines that begin with # are left out.

    **Raises:** `InputError` with the line for a file that is no such table, and for a part that is named twice.
    """
    path = user_path(path)
    try:
        # Spreadsheets put a byte-order mark before UTF-8, which would otherwise become part of the first heading.
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"{path}: {(error.strerror or str(error)).lower()}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path} is no text in UTF-8; save it as CSV, UTF-8") from None
    first = next((line for line in text.splitlines() if line.strip() and not line.startswith("#")), "")
    # The headings alone tell the delimiter, because the points of a curve, in the rows, have commas of their own.
    delimiter = max(DELIMITERS, key=first.count)
    # Lines that are left out stay as empty ones, so that the numbers of the others are the file's.
    lines = ["" if line.startswith("#") else line for line in text.splitlines()]
    reader = csv.reader(io.StringIO("\n".join(lines)), delimiter=delimiter, skipinitialspace=True)
    rows = [(reader.line_num, [cell.strip() for cell in row]) for row in reader if any(cell.strip() for cell in row)]
    if len(rows) < 2:
        raise InputError(f"{path} has no part; write a line of headings, such as name, k_A [N/m], and a line a part")
    (line, header), *body = rows
    names = _headings(path, line, header)
    parts: dict[str, tuple[int, dict[str, CatalogueCell]]] = {}
    for line, row in body:
        if len(row) != len(header):
            raise InputError(f"{path}, line {line}: {len(row)} cells, where the headings are {len(header)}")
        name, cells = _row(f"{path}, line {line}", names, row)
        if name in parts:
            raise InputError(f"{path}, line {line}: {name} stands in line {parts[name][0]} already; keep one")
        parts[name] = line, cells
    return [(name, cells) for name, (_, cells) in parts.items()]


def _headings(path: Path, line: int, header: list[str]) -> list[tuple[str, str]]:
    """Return name and unit of each column."""
    split = [name_and_unit(text) for text in header]
    names = [name for name, _ in split]
    for name in names:
        if not name:
            raise InputError(f"{path}, line {line}: column {names.index('') + 1} has no heading")
        if names.count(name) > 1:
            raise InputError(f"{path}, line {line}: {name} is the heading of two columns; keep one")
    if not any(name in NAMES for name in names):
        raise InputError(f"{path}, line {line}: no column is called name; found {', '.join(header)}")
    return split


def _row(where: str, headings: list[tuple[str, str]], row: list[str]) -> tuple[str, dict[str, CatalogueCell]]:
    """Return a part's name and its cells; an empty cell is left out, so that a curve may stand in another column."""
    cells, name = dict[str, CatalogueCell](), ""
    for (heading, symbol), text in zip(headings, row, strict=True):
        if heading in NAMES and not name:
            name = text
        elif text:
            cells[heading] = CatalogueCell(f"{where}, {heading}", _typed(f"{where}, {heading}", text, symbol))
    if not name:
        raise InputError(f"{where}: the part has no name")
    return name, cells


def _typed(where: str, text: str, symbol: str) -> Any:
    """Return a cell's number with the unit of its heading, a number, a truth, or the text."""
    try:
        number = float(text)
    except ValueError:
        number = None
    if number is None:
        if symbol and text[0].isdigit() and not text.startswith("["):
            raise InputError(f"{where} = {shown(text)}: the heading has the unit {symbol} already; write one of them")
        return {"true": True, "false": False}.get(text, text)
    # What is not finite is no number with a unit, and is refused as it is.
    return f"{text} {symbol}" if symbol and symbol != "-" and math.isfinite(number) else number
