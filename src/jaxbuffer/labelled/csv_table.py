"""Tables of a user's own in text files: commas, semicolons or tabs, decimal commas, quotes, comments; errors have the
line and the column."""

import csv
import io
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from ..errors import InputError, suggest

# A number with a decimal mark, alone or before a unit: "9,50 EUR".
MARKED = re.compile(r"[-+]?\d*([.,])\d*(?:[eE][-+]?\d+)?(?:\s*[A-Za-zµ°%€$][^\d,;]*)?")
COMMA = re.compile(r"^([-+]?\d*),(\d*)")  # the decimal comma of a number that a cell begins with


class CsvTable(NamedTuple):
    """A table as text: ``file``; ``headings``; ``rows`` of cells with the ``lines`` that they stand in; the line of the
    ``header``; ``comments``, lines with #, each with its line; the decimal ``mark`` of the numbers."""

    file: str
    headings: list[str]
    rows: list[list[str]]
    lines: list[int]
    header: int
    comments: list[tuple[int, str]]
    mark: str = "."

    def column(self, name: str) -> list[str]:
        """Return the cells of a column. **Raises:** `InputError` for one that is not there."""
        if name not in self.headings:
            have = ", ".join(f'"{it}"' for it in self.headings)
            hint = self.in_comment([name]) or suggest(name, self.headings) or f"; it has {have}"
            raise InputError(f'{self.file}, line {self.header}: there is no column "{name}"{hint}')
        place = self.headings.index(name)
        return [row[place] for row in self.rows]

    def with_point(self, cell: str) -> str:
        """Return a cell, the number that it begins with written with a decimal point."""
        return COMMA.sub(r"\1.\2", cell) if self.mark == "," else cell

    def in_comment(self, names: Iterable[str]) -> str:
        """Return a hint at a comment that is the line of headings, having one of these names; "" for none."""
        for line, text in self.comments:
            cells = {cell.strip(' "') for cell in re.split("[,;\t]", text)}
            if cells & set(names):
                return f"; line {line} has it behind a #, as a comment: take the # away"
        return ""


def read_table(path: Path, texts: Iterable[str] = ()) -> CsvTable:
    """Read a table from a file, empty lines and comments left out.

    Tabs stand between its cells where the line of headings has any, else semicolons, else commas. The decimal mark is
    that of the first number with one, in any column but those of ``texts``; between commas it is a point.

    **Raises:** `InputError` with file, line and column for what is no such table.
    """
    text = _text(path)
    # Comments stay as empty lines, so that messages name the file's own lines.
    lines = ["" if line.lstrip().startswith("#") else line for line in text.splitlines()]
    numbered = enumerate(text.splitlines(), 1)
    comments = [(k, line.strip().lstrip("#")) for k, line in numbered if line.lstrip().startswith("#")]
    head = next((line for line in lines if line.strip()), "")
    # A comma may also be a decimal one where tabs or semicolons part the cells, so it is the last to be tried.
    delimiter = "\t" if "\t" in head else ";" if ";" in head else ","
    cells = list(_cells(str(path), "\n".join(lines), delimiter))
    if not cells:
        return CsvTable(str(path), [], [], [], 0, comments)
    (first, headings), *rows = cells
    table = CsvTable(str(path), headings, [row for _, row in rows], [line for line, _ in rows], first, comments)
    _check_headings(table)
    for line, row in rows:
        if len(row) != len(headings):
            commas = (
                "; numbers with decimal commas need semicolons or tabs between the cells" if delimiter == "," else ""
            )
            raise InputError(
                f"{path}, line {line} has {len(row)} cells, and line {first} names {len(headings)} columns{commas}"
            )
    return _with_mark(table, delimiter, texts)


def _text(path: Path) -> str:
    try:
        # Spreadsheets put a byte-order mark before UTF-8, which would otherwise become part of the first heading.
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except UnicodeDecodeError:
        raise InputError(f"{path} is not text in UTF-8; save it as CSV, UTF-8") from None
    except OSError as error:
        raise InputError(f"{path}: {(error.strerror or str(error)).lower()}") from None


def _cells(file: str, text: str, delimiter: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the first line and the cells of each row that is not empty; a quoted cell may have line breaks."""
    reader, line = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, skipinitialspace=True), 1
    try:
        for row in reader:
            cells = [cell.strip() for cell in row]
            if any(cells):
                yield line, cells
            line = reader.line_num + 1
    except csv.Error as error:
        raise InputError(f"{file}, line {line}: {error}") from None


def _check_headings(table: CsvTable) -> None:
    """Raise `InputError` where the first line has numbers: its headings are missing, or a comment."""
    for heading in table.headings:
        try:
            float(heading.replace(",", "."))
        except ValueError:
            return
    near = next((line for line, text in reversed(table.comments) if line < table.header and text.strip()), None)
    hint = f"; if line {near} has them, take the # away, which makes it a comment" if near else ""
    raise InputError(f"{table.file}, line {table.header}: numbers in place of headings, {table.headings[0]} say{hint}")


def _with_mark(table: CsvTable, delimiter: str, texts: Iterable[str]) -> CsvTable:
    """Return the table with its decimal mark.

    **Raises:** `InputError` that names line and column of a number with the other mark: one of both is then a mark of
    thousands, and nothing says which.
    """
    first: tuple[str, str] | None = (".", "commas between the cells") if delimiter == "," else None
    for place, name in enumerate(table.headings):
        if name in texts:
            continue
        for line, row in zip(table.lines, table.rows, strict=True):
            match = MARKED.fullmatch(row[place])
            if match is None:
                continue
            here = f'line {line}, column "{name}": {row[place]}'
            if first is not None and match[1] != first[0]:
                raise InputError(
                    f"{table.file}, {here} beside {first[1]}: a file has one decimal mark, and no mark of thousands"
                )
            first = first or (match[1], here)
    return table if first is None else table._replace(mark=first[0])
