"""Reading a measured test from a table: commas, semicolons or tabs, decimal commas, units in the headings."""

import csv
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError, shown, suggest
from ..fields import Part, in_unit
from ..files import user_path
from ..value_text import is_plain
from .recording import Bounds, Channel, Recording

UNIT = re.compile(r"\[([^\[\]]*)\]")
OTHER_UNIT = re.compile(
    r"\(([^()]*)\)|/(.*)"
)  # of a heading without brackets: "gap (mm) left", "gap / mm", "a / m/s^2"
MARKED = re.compile(r"[-+]?\d*([.,])\d*(?:[eE][-+]?\d+)?")  # a number with a decimal mark
DIGIT = re.compile(r"(?<=[A-Za-zµ])(\d)")  # of a power, as in m/s2


class CsvTable(NamedTuple):
    """A table as text: ``file``; ``headings``; ``rows`` of cells with the ``lines`` that they stand in; the line of the
    ``header``; the decimal ``mark`` of its numbers."""

    file: str
    headings: list[str]
    rows: list[list[str]]
    lines: list[int]
    header: int
    mark: str = "."

    def with_mark(self, delimiter: str) -> "CsvTable":
        """Return the table with the decimal mark that the first number with one has, in any column. Between commas it
        is a point.

        **Raises:** `InputError` that names line and column of a number with the other mark: one of both is then a
        mark of thousands, and nothing says which.
        """
        first: tuple[str, str] | None = (".", "commas between the cells") if delimiter == "," else None
        for name in self.headings:
            for k, cell in enumerate(self.column(name)):
                match = MARKED.fullmatch(cell.strip())
                if match is None:
                    continue
                here = f'line {self.lines[k]}, column "{name}": {cell.strip()}'
                if first is not None and match[1] != first[0]:
                    raise InputError(
                        f"{self.file}, {here} beside {first[1]}: a file has one decimal mark, and no mark of thousands"
                    )
                first = first or (match[1], here)
        return self if first is None else self._replace(mark=first[0])

    def column(self, name: str) -> list[str]:
        """Return the cells of a column. **Raises:** `InputError` for one that is not there."""
        if name not in self.headings:
            have = ", ".join(f'"{it}"' for it in self.headings)
            hint = suggest(name, self.headings)
            raise InputError(
                f'{self.file}, line {self.header}: there is no column "{name}"{hint or f"; it has {have}"}'
            )
        place = self.headings.index(name)
        return [row[place] for row in self.rows]

    def numbers(self, name: str, factor: float) -> np.ndarray:
        """Return a column as numbers, each times a ``factor``. **Raises:** `InputError` that names the line."""
        return factor * np.array([self._number(name, k, cell) for k, cell in enumerate(self.column(name))])

    def _number(self, name: str, k: int, cell: str) -> float:
        text = cell.strip().replace(",", ".") if self.mark == "," else cell.strip()
        try:
            number = float(text)
        except ValueError:
            number = float("nan")
        if not np.isfinite(number):
            what = "is empty" if not text else f"has {shown(cell.strip())}, which is not a finite number"
            raise InputError(f'{self.file}, line {self.lines[k]}: column "{name}" {what}')
        return number


def read_recording(
    file: str | Path,
    channels: Mapping[str, Channel],
    *,
    time: str = "time [s]",
    scenario: Part | None = None,
    time_shift: Bounds = 0.0,
    units: Mapping[str, str],
) -> Recording:
    """Read a measured test from a table in a file.

    Columns may stand in any order, between commas, semicolons or tabs; with the latter two numbers may have a decimal
    comma, all of them. A heading's unit stands in brackets, "stroke [mm]", "stroke (mm)", or behind a slash, "stroke /
    mm"; without one it is the quantity's. Lines that begin with # are comments.

    **Arguments:**

    - ``file``: its path.
    - ``channels``: by the heading of the column that each recorded.
    - ``time``: heading of the times.
    - ``scenario``, ``time_shift``: as of `Recording`.
    - ``units``: of the quantities, by their names: `jb.recorded_quantities` of a design.

    **Raises:** `InputError` with file, line and column for columns that are missing or there twice, rows that are too
    short, texts and NaN in place of numbers, times that do not rise, and units that do not fit.

    **Example:**

    >>> import pathlib, tempfile
    >>> units = jb.recorded_quantities(jb.BarDrop())
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder) / "drop.csv"
    ...     _ = file.write_text("time [ms];gap [mm]" + chr(10) + "0;194,0" + chr(10) + "50;181,7" + chr(10))
    ...     test = jb.read_recording(file, {"gap [mm]": jb.Channel("gap_plate")}, time="time [ms]", units=units)
    >>> test.times, test.values["gap [mm]"]
    (array([0.  , 0.05]), array([0.194 , 0.1817]))
    """
    path = user_path(file)
    table = _table(path)
    times = table.numbers(time, _factor(table, time, "s"))
    for k, step in enumerate(np.diff(times), 1):
        if step <= 0.0:
            what = "is there twice" if step == 0.0 else "is earlier than that of the line before"
            raise InputError(
                f'{table.file}, line {table.lines[k]}: column "{time}" has {table.rows[k][table.headings.index(time)]},'
                f" which {what}; times must rise"
            )
    values = {}
    for name, channel in channels.items():
        if channel.quantity not in units:
            known = suggest(channel.quantity, units)
            raise InputError(f'{table.file}: column "{name}": quantity {channel.quantity} is unknown{known}')
        unit = units[channel.quantity]
        values[name] = table.numbers(name, _factor(table, name, unit))
        for what, typed in (("noise", channel.noise), ("offset", channel.offset)):
            ends = typed if isinstance(typed, (list, tuple)) else [typed]
            bare = [it for it in ends if isinstance(it, (int, float)) and not isinstance(it, bool) and it != 0.0]
            if bare and not is_plain(unit) and _factor(table, name, unit) != 1.0:
                given = _unit(table, name)
                raise InputError(
                    f'{table.file}: column "{name}" is in {given}, and {what} = {bare[0]} has no unit: write'
                    f' {what} = "{bare[0]} {given}" or in {unit}, "{bare[0]} {unit}"'
                )
    return Recording(path.name, times, values, channels, scenario, time_shift, lines=tuple(table.lines))


def _table(path: Path) -> CsvTable:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except UnicodeDecodeError:
        raise InputError(f"{path} is not text in UTF-8") from None
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    # Comments stay as empty lines, so that messages name the file's own lines.
    lines = ["" if line.lstrip().startswith("#") else line for line in text.splitlines()]
    head = next((line for line in lines if line.strip()), "")
    # A comma may also be a decimal one where tabs or semicolons part the cells, so it is the last to be tried.
    delimiter = "\t" if "\t" in head else ";" if ";" in head else ","
    numbered = list(_cells(str(path), "\n".join(lines), delimiter))
    if len(numbered) < 3:
        raise InputError(f"{path} needs a line of headings and two rows or more")
    (first, headings), *rows = numbered
    for name in headings:
        if headings.count(name) > 1:
            raise InputError(f'{path}, line {first}: column "{name}" is there twice; keep one')
    for line, row in rows:
        if len(row) != len(headings):
            raise InputError(
                f"{path}, line {line} has {len(row)} cells, and line {first} names {len(headings)} columns"
            )
    table = CsvTable(str(path), headings, [row for _, row in rows], [line for line, _ in rows], first)
    return table.with_mark(delimiter)


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


def _unit(table: CsvTable, name: str) -> str:
    """Return the unit in a heading, "" for none. **Raises:** `InputError` for several."""
    units: Sequence[Any] = UNIT.findall(name)
    if len(units) > 1:
        raise InputError(f'{table.file}, line {table.header}: column "{name}" has two units; keep one')
    if not units and (other := OTHER_UNIT.search(name)):
        units = [(other[1] or other[2] or "").strip(" ()")]
    return DIGIT.sub(r"^\1", units[0].strip()) if units else ""


def _factor(table: CsvTable, name: str, unit: str) -> float:
    """Return how many of a quantity's unit one of the heading's is."""
    given = _unit(table, name)
    if not given or is_plain(given) or given == unit:
        return 1.0
    where = f'{table.file}, line {table.header}: column "{name}"'
    if given in ("g", "G") and unit == "m/s²":
        raise InputError(f"{where}: g is a gram; multiply the column by 9.80665 and write [m/s^2]")
    return float(in_unit(where, f"1 {given}", unit))
