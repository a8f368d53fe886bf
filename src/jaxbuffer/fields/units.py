"""Units as text where numbers come in: "0.5 kN/m" becomes 500.0 for a field in N/m.

pint (https://pint.readthedocs.io) reads the unit, with the short list of units below instead of its own: a plane angle
is a dimension here, so that Hz is not taken for rad/s, and no two units share a symbol. pint is imported when the first
text with a unit is met.
"""

import contextlib
import datetime
import functools
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
    nearest,
    shown,
    unit_of_library,
)
from ..value_text import interval_text, is_plain

# The number is taken whole: "0.1" is no 0 of the unit ".1", nor "101" a 10 of "1".
_DIGITS = r"[-+]?(?:\d++\.?\d*+|\.\d++)(?:[eE][-+]?\d++)?+"
_NUMBER, _COMMA = re.compile(_DIGITS), re.compile(r"^([-+]?\d+),(\d+(?:[eE][-+]?\d+)?(?: *[^\d\s,].*)?)$")
_TEXT = re.compile(r"\s*(" + _DIGITS + r")\s*(%|°|[A-Za-zµμ1][^\[\]{}=,;:\"']*)\s*")
_UNIT = re.compile(r"[\w\s*/·.^()°%²³⁻¹-]{1,40}")
_WORD = re.compile(r"[^\W\d_]+|°|%")
_POWERS = re.compile(r"(\^|\*\*)[^*/·\s]*(\^|\*\*)|\d{3}")  # a power of a power, or a long number: none is a unit

DEFINITIONS = """\
giga- = 1e9 = G-
mega- = 1e6 = M-
kilo- = 1e3 = k-
centi- = 1e-2 = c-
milli- = 1e-3 = m-
micro- = 1e-6 = µ- = μ- = u-
nano- = 1e-9 = n-
meter = [length] = m = metre
second = [time] = s = sec
gram = [mass] = g
radian = [angle] = rad
percent = 0.01 = %
minute = 60 * second = min
hour = 60 * minute = h
tonne = 1000 * kilogram = t
newton = kilogram * meter / second ** 2 = N
pascal = newton / meter ** 2 = Pa
bar = 1e5 * pascal
joule = newton * meter = J
watt = joule / second = W
hertz = 1 / second = Hz
degree = 0.017453292519943295 * radian = deg = °
turn = 6.283185307179586 * radian = rev = revolution
rpm = turn / minute
inch = 0.0254 * meter = in
foot = 0.3048 * meter = ft
pound = 0.45359237 * kilogram = lb
pound_force = 4.4482216152605 * newton = lbf
"""
SYMBOLS = (
    *("m", "mm", "cm", "km", "µm", "s", "ms", "µs", "min", "h", "kg", "g", "t", "rad", "mrad", "deg", "turn", "rpm"),
    *("N", "kN", "MN", "mN", "Pa", "kPa", "MPa", "GPa", "bar", "J", "mJ", "kJ", "W", "Hz", "kHz"),
    *("in", "ft", "lb", "lbf"),
)
KINDS = {
    **{"m": "a length", "s": "a time", "kg": "a mass", "rad": "an angle", "m/s": "a speed", "N": "a force"},
    **{"rad/s": "a rate of turning", "N/m": "a stiffness", "N s/m": "a damping", "Pa": "a pressure"},
    **{"N m": "a torque or an energy", "1/s": "a frequency", "kg m²": "an inertia", "m²": "an area"},
    **{"N m/rad": "a stiffness about a hinge", "N m s/rad": "a damping about a hinge", "-": "a plain number"},
    **{"m/s²": "an acceleration", "kg/m³": "a density", "N s": "an impulse"},
}


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
        given, target = _parsed(symbol), _parsed(unit)
    except Exception:  # pint has many
        return f"{_unknown(symbol)}; expected {expected}"
    if given.dimensionality != target.dimensionality:
        return f"{symbol} does not fit, expected {expected}{_instead(symbol, unit)}"
    # Only the factor comes from pint, so that arrays of any library are scaled by one product.
    return numbers * float(_registry().Quantity(1.0, given).to(target).magnitude)


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
        return float(_registry().Quantity(value, _parsed(unit)).to(_parsed(typed)).magnitude), typed
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
        _parsed(symbol)
    except Exception:  # pint has many, and its tokenizer others
        raise InputError(f"{path} = {shown(symbol)}: {_unknown(symbol)}") from None


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
    units, target = _registry(), _parsed(unit)
    try:
        given = _parsed(symbol)
    except Exception:  # pint has many, and its tokenizer others
        return f"{_unknown(symbol)}; expected {expected}"
    if given.dimensionality != target.dimensionality:
        kinds = (
            f" is {kind}" for known, kind in KINDS.items() if _parsed(known).dimensionality == given.dimensionality
        )
        return f"{symbol}{next(kinds, ' does not fit')}, expected {expected}{_instead(symbol, unit)}"
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


def _unknown(symbol: str) -> str:
    """Return which word of a unit is unknown, and the unit meant."""
    for word in _WORD.findall(symbol):
        try:
            _parsed(word)
        except Exception:
            near = next((s for s in SYMBOLS if s.lower() == word.lower()), None) or nearest(word, SYMBOLS)
            # A plural is meant before anything that only looks alike.
            if word[-1] == "s" and word[:-1] in SYMBOLS:
                near = word[:-1]
            # Two symbols may be written as one word: "Nm" for "N m".
            elif two := [(word[:k], word[k:]) for k in range(1, len(word)) if {word[:k], word[k:]} <= set(SYMBOLS)]:
                near = " ".join(two[0])
            return f"the unit {word} is unknown" + (f"; did you mean {near}?" if near else "")
    return f"{shown(symbol)} is not a unit"


def _instead(symbol: str, unit: str) -> str:
    if unit == "rad/s" and _parsed(symbol).dimensionality == _parsed("Hz").dimensionality:
        return "; for turns a second write turn/s or rpm"
    if "/rad" in unit and _parsed(symbol).dimensionality == _parsed(unit.replace("/rad", "")).dimensionality:
        return f"; write {symbol}/rad or {symbol}/deg"
    return ""


@functools.cache
def _registry() -> Any:
    # It is needed only where a text has a unit.
    import pint

    registry: Any = pint.UnitRegistry(None)
    registry.load_definitions(DEFINITIONS.splitlines())
    return registry


@functools.cache
def _parsed(symbol: str) -> Any:
    """Return a unit from its symbol; spaces multiply, and what follows a / up to the next one divides, as in tables."""
    plain = "" if symbol == "-" else re.sub(r"^1\s*/", "dimensionless/", symbol.replace("·", " "))
    return _registry().parse_units(plain)
