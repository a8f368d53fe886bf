"""Reading a measured test from a table: commas, semicolons or tabs, decimal commas, units in the headings."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, shown, suggest
from ..fields import Part, in_unit
from ..files import user_path
from ..labelled.csv_table import CsvTable, read_table
from ..value_text import is_plain
from .recording import Bounds, Channel, Recording

UNIT = re.compile(r"\[([^\[\]]*)\]")
OTHER_UNIT = re.compile(
    r"\(([^()]*)\)|/(.*)"
)  # of a heading without brackets: "gap (mm) left", "gap / mm", "a / m/s^2"
DIGIT = re.compile(r"(?<=[A-Za-zµ])(\d)")  # of a power, as in m/s2


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
    times = _numbers(table, time, _factor(table, time, "s"))
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
        values[name] = _numbers(table, name, _factor(table, name, unit))
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
    table = read_table(path)
    if len(table.rows) < 2:
        raise InputError(f"{path} needs a line of headings and two rows or more")
    for name in table.headings:
        if table.headings.count(name) > 1:
            raise InputError(f'{path}, line {table.header}: column "{name}" is there twice; keep one')
    return table


def _numbers(table: CsvTable, name: str, factor: float) -> np.ndarray:
    """Return a column as numbers, each times a ``factor``. **Raises:** `InputError` that names the line."""
    return factor * np.array([_number(table, name, k, cell) for k, cell in enumerate(table.column(name))])


def _number(table: CsvTable, name: str, k: int, cell: str) -> float:
    try:
        number = float(table.with_point(cell))
    except ValueError:
        number = float("nan")
    if not np.isfinite(number):
        what = "is empty" if not cell else f"has {shown(cell)}, which is not a finite number"
        raise InputError(f'{table.file}, line {table.lines[k]}: column "{name}" {what}')
    return number


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
