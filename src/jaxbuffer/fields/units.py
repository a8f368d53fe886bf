"""Units as text where numbers come in: "0.5 kN/m" becomes 500.0 for a field in N/m.

pint reads the unit, of those in `unit_symbols`.
"""

import contextlib
import datetime
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..errors import (
    InputError,
    OutOfRange,
    as_number,
    check_masks,
    inside,
    masked,
    shown,
    unit_of_library,
)
from ..value_text import interval_text, is_plain
from .unit_symbols import KINDS, instead, parsed, registry, unknown_unit

# The number is taken whole: "0.1" is no 0 of the unit ".1", nor "101" a 10 of "1".
_DIGITS = r"[-+]?(?:\d++\.?\d*+|\.\d++)(?:[eE][-+]?\d++)?+"
_NUMBER, _COMMA = re.compile(_DIGITS), re.compile(r"^([-+]?\d+),(\d+(?:[eE][-+]?\d+)?(?: *[^\d\s,].*)?)$")
_TEXT = re.compile(r"\s*(" + _DIGITS + r")\s*(%|°|[A-Za-zµμ1][^\[\]{}=,;:\"']*)\s*")
_UNIT = re.compile(r"[\w\s*/·.^()°%²³⁻¹-]{1,40}")
_POWERS = re.compile(r"(\^|\*\*)[^*/·\s]*(\^|\*\*)|\d{3}")  # a power of a power, or a long number: none is a unit

POSITIVE: dict[str, Any] = {"low": 0.0, "low_open": True}
NON_NEGATIVE: dict[str, Any] = {"low": 0.0}


def as_unit(value: Any, unit: str) -> Any:
    """Return a value as `as_number` does, and a text with a unit that fits as a number in ``unit``; any other text
    stays as it is, for the check that names its field.

    **Raises:** `InputError` for a list in which some values have a unit and others none.
    """
    if type(value) is float:
        return value
    if isinstance(value, np.ndarray) and (unwrapped := _unwrapped(value)) is not value:
        converted = as_unit(unwrapped, unit)
        return value if isinstance(converted, (list, str)) else converted
    if isinstance(value, str):
        number = _read(value, unit)
        return number if isinstance(number, float) else value
    if unit_of_library(value) is not None:
        converted = _converted(value, unit)
        return value if isinstance(converted, str) else converted
    if isinstance(value, (list, tuple)) and any(isinstance(it, str) or unit_of_library(it) is not None for it in value):
        check_units_agree(shown(value), value)
        value = [as_unit(entry, unit) for entry in value]
    return as_number(value)


def _unwrapped(value: np.ndarray) -> Any:
    """Return an array of texts or objects as a list, one in which nothing is masked without its mask."""
    if isinstance(value, np.ma.MaskedArray):
        return value if masked(value) else value.data
    return value.tolist() if value.dtype.kind in "OU" and unit_of_library(value) is None else value


def in_unit(path: str, value: Any, unit: str, **limits: Any) -> Any:
    """Return the value of a field as `as_unit` does; a text's number must be in its range, which an error tells in the
    text's unit.

    **Arguments:** ``path``: as shown to the user; ``unit``: the field's; ``limits``: its range, as in `check_number`.

    **Raises:** `InputError` for a unit that is unknown or of another dimension, with what would do, and for a list in
    which some values have a unit and others none.
    """
    if type(value) is float:
        return value
    if isinstance(value, np.ndarray):
        value = _unwrapped(value)
    check_masks(path, value)
    if isinstance(value, (list, tuple)):
        check_units_agree(path, value)
    if reason := _misfit(value, unit):
        allowed = interval_text(unit=unit, **limits)
        raise InputError(f"{path} = {shown(value)}: {reason}; allowed: {allowed}")
    # A number out of range is refused here, where its text still tells the unit that was typed.
    number = as_unit(value, unit)
    if isinstance(value, str) and type(number) is float and not inside(number, **limits):
        ends = tuple(limits.get(name, default) for name, default in _RANGE.items())
        raise _in_unit_of(OutOfRange(path, number, unit, ends), typed_unit(value))
    return number


def _misfit(value: Any, unit: str) -> str:
    """Return what is wrong with the unit of a text, or of a quantity of another library, alone or in a list."""
    if isinstance(value, str):
        read = _read(value, unit)
    elif unit_of_library(value) is not None:
        read = _converted(value, unit)
    elif isinstance(value, (list, tuple)):
        return next(filter(None, (_misfit(entry, unit) for entry in value if unit_of_library(entry) is not None)), "")
    else:
        return ""
    return read if isinstance(read, str) else ""


def _converted(value: Any, unit: str) -> Any:
    """Return a quantity of another library as numbers in ``unit``, or what is wrong with its own unit."""
    expected = _expected(unit)
    if isinstance(value, datetime.timedelta | np.timedelta64) or getattr(value, "dtype", np.dtype(float)).kind == "m":
        try:
            seconds = np.asarray(value, "m8") / np.timedelta64(1, "s")
        except TypeError:  # months and years have no fixed length
            return f"{shown(value)} has no length in seconds; expected {expected}"
        return _scaled(float(seconds) if np.ndim(seconds) == 0 else seconds, "s", unit)
    reason = ""
    for quantity in _in_other_units(value):
        numbers: Any = getattr(quantity, "magnitude", None)
        numbers = getattr(quantity, "value", None) if numbers is None else numbers
        numbers = np.asarray(quantity) if numbers is None or callable(numbers) else numbers  # a labelled array
        converted = _scaled(as_number(numbers), _symbol_of(quantity), unit)
        if not isinstance(converted, str):
            return converted
        reason = reason or converted
    return f"{reason}; expected {expected}" if expected not in reason else reason


def _in_other_units(quantity: Any) -> Iterator[Any]:
    """Yield a quantity as it is, then in its library's base units where it has any: their symbols are known here."""
    yield quantity
    for name in ("to_base_units", "decompose", "in_mks"):
        if callable(convert := getattr(quantity, name, None)):
            with contextlib.suppress(Exception):  # of any library
                yield convert()


def _symbol_of(quantity: Any) -> str:
    """Return the unit of a quantity of another library as units are written here."""
    units = getattr(quantity, "units", None)
    try:
        text = f"{units:~D}"  # pint's short symbols
    except (TypeError, ValueError):
        text = unit_of_library(quantity) or ""
    # astropy writes powers behind the symbol: "kg m / s2"
    return re.sub(r"(?<=[A-Za-z])(-?\d)", r"^\1", text) or "-"


def _scaled(numbers: Any, symbol: str, unit: str) -> Any:
    """Return numbers of a unit as those of another one, or what is wrong with it."""
    expected = _expected(unit)
    # The exponent e of such a unit is a number of the design, which is not known here.
    if unit.endswith("^e"):
        return f"the unit depends on the exponent; write {expected} without one"
    try:
        given, target = parsed(symbol), parsed(unit)
    except Exception:  # pint has many
        return f"{unknown_unit(symbol)}; expected {expected}"
    if given.dimensionality != target.dimensionality:
        return f"{symbol} does not fit, expected {expected}{instead(symbol, unit)}"
    # Only the factor comes from pint, so that arrays of any library are scaled by one product.
    return numbers * float(registry().Quantity(1.0, given).to(target).magnitude)


def typed_unit(value: Any) -> str:
    """Return the unit that was typed with a value, or with the first of a list's or a table's that has one; "" for
    none."""
    if isinstance(value, (list, tuple, Mapping)):
        values = value.values() if isinstance(value, Mapping) else value
        return next(filter(None, map(typed_unit, values)), "")
    match = _TEXT.fullmatch(value) if isinstance(value, str) else None
    return match[2].strip() if match else ""


def as_typed(value: float, unit: str, typed: str) -> tuple[float, str]:
    """Return a value in ``unit`` as one in the unit that was ``typed``, and that unit; the same where none was
    typed."""
    if not typed:
        return value, unit
    try:
        return float(registry().Quantity(value, parsed(unit)).to(parsed(typed)).magnitude), typed
    except Exception:  # pint has many: the unit does not fit, which its own error says
        return value, unit


def ends_as_typed(low: float, high: float, unit: str, typed: str) -> tuple[float, float, str]:
    """Return both ends of a range `as_typed`, and their unit."""
    (first, symbol), (last, _) = (as_typed(end, unit, typed) for end in (low, high))
    return first, last, symbol


# In which people are shown numbers that were typed with no unit, and how many of them a number's own is.
DISPLAYED = {"m": ("mm", 1e3), "rad": ("deg", 180.0 / math.pi), "rad/s": ("deg/s", 180.0 / math.pi)}


def display_unit(unit: str) -> tuple[str, float]:
    """Return the unit in which people are shown a number, and how many of it its own unit is."""
    return DISPLAYED.get(unit, (unit, 1.0))


def as_displayed(value: float, unit: str) -> tuple[float, str]:
    """Return a value in the unit in which people are shown it, and that unit."""
    symbol, factor = display_unit(unit)
    return factor * value, symbol


def as_written(value: float, unit: str, typed: str) -> float | str:
    """Return a value as it is written into a study: a text in the unit that was ``typed``, with as few digits as give
    exactly this value when it is read, or the number in ``unit`` where none was typed or no such text is."""
    number, symbol = as_typed(value, unit, typed)
    if typed and symbol == typed and math.isfinite(number):
        # The conversion there and back may round, so that a neighbour of the number is what is read as the value.
        for near in (number, math.nextafter(number, math.inf), math.nextafter(number, -math.inf)):
            for digits in range(1, 18):
                # 16 digits of the rounded number do not show more than it has, nor 50 as 5e+01.
                text = f"{float(f'{near:.{digits}g}'):.{max(digits, 16)}g} {typed}"
                if as_unit(text, unit) == value:
                    return text
    return float(value)


@contextlib.contextmanager
def errors_in_typed_units(units: Mapping[str, str]) -> Iterator[None]:
    """Raise errors of numbers out of range in the ``units`` that were typed, by path."""
    try:
        yield
    except OutOfRange as error:
        raise _in_unit_of(error, units.get(error.path, "")) from None


def _in_unit_of(error: OutOfRange, typed: str) -> OutOfRange:
    """Return the error in the unit that was typed."""
    value, symbol = as_typed(error.value, error.unit, typed)
    low, high = (as_typed(end, error.unit, typed)[0] for end in error.limits[:2])
    limits = (low, high, *error.limits[2:])
    return OutOfRange(error.path, value, symbol, limits, error.before, error.after)


def check_units_agree(where: str, values: Sequence[Any], written: Callable[..., str] | None = None) -> None:
    """Raise `InputError` where some values have a unit and others none: "5" before "20 cm/s" means 5 m/s.

    Zero needs no unit.

    **Arguments:** ``where``: the values' name, as shown to the user; ``values``: as typed, numbers or texts;
    ``written``: the whole as it should be typed, from a text for each value; a list of them by default.
    """
    units = [match[2].strip() for value in values if isinstance(value, str) and (match := _TEXT.fullmatch(value))]
    units += [symbol for value in values if (symbol := unit_of_library(value)) is not None]
    if not units:
        return
    read = [as_number(value) for value in values]
    if bare := [value for value in read if type(value) is float and value != 0.0]:
        each = [f"{value:.12g} {units[0]}" if type(value) is float else str(value).strip() for value in read]
        whole = written(*each) if written else "[" + ", ".join(f'"{text}"' for text in each) + "]"
        raise InputError(f"{where}: {bare[0]:.12g} has no unit; give each value one, or none: {whole}")


def check_unit(path: str, symbol: Any) -> None:
    """Raise `InputError` unless a text is a unit, "-" for none."""
    if not isinstance(symbol, str) or not symbol.strip():
        raise InputError(f"{path} = {shown(symbol)} is not a unit; write 'N m' say, or '-' for none")
    if symbol != "-" and (not _UNIT.fullmatch(symbol) or _POWERS.search(symbol)):
        raise InputError(f"{path} = {shown(symbol)} is not a unit; write 'N m' say, or '-' for none")
    try:
        parsed(symbol)
    except Exception:  # pint has many, and its tokenizer others
        raise InputError(f"{path} = {shown(symbol)}: {unknown_unit(symbol)}") from None


_RANGE = {"low": -math.inf, "high": math.inf, "low_open": False, "high_open": False}


def _read(text: str, unit: str) -> float | str:
    """Return the number in ``unit`` that a text means, or what is wrong with its unit; "" if it is no number at all."""
    if (match := _TEXT.fullmatch(text)) is None:
        return _without_unit(text.strip(), unit)
    number, symbol = float(match[1]), match[2].strip()
    expected = _expected(unit)
    if unit.endswith("^e"):
        return f"the unit depends on the exponent; write {expected} without one"
    if not _UNIT.fullmatch(symbol) or _POWERS.search(symbol):
        return f"{shown(symbol)} is not a unit; expected {expected}"
    units, target = registry(), parsed(unit)
    try:
        given = parsed(symbol)
    except Exception:  # pint has many, and its tokenizer others
        return f"{unknown_unit(symbol)}; expected {expected}"
    if given.dimensionality != target.dimensionality:
        kinds = (f" is {kind}" for known, kind in KINDS.items() if parsed(known).dimensionality == given.dimensionality)
        return f"{symbol}{next(kinds, ' does not fit')}, expected {expected}{instead(symbol, unit)}"
    return float(units.Quantity(number, given).to(target).magnitude)


def _expected(unit: str) -> str:
    """Return what a field of this unit takes."""
    return "a plain number" if is_plain(unit) else f"a number in {unit}"


def _without_unit(text: str, unit: str) -> str:
    """Return what is wrong with a text that has a decimal comma, or with a number alone; "" for any other."""
    pointed = _COMMA.sub(r"\1.\2", text)
    if pointed != text:
        return f"numbers have a decimal point here; write {pointed}"
    if not _NUMBER.fullmatch(text):
        return ""
    symbol = f', or "{text} {unit}"' if not is_plain(unit) and not unit.endswith("^e") else ""
    return f"a text needs a unit; write {text} without quotes{symbol}"
