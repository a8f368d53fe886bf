"""Input errors that name the field, the value, the unit and the allowed range, and the checks that raise them."""

import math
from collections.abc import Iterable
from decimal import Decimal
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any

from .suggestions import Meaning, same_as
from .suggestions import nearest as nearest
from .suggestions import suggest as suggest
from .value_text import interval_text, unit_text, with_unit

if TYPE_CHECKING:  # the command line's own errors need neither: they are imported where a value is looked at
    import numpy as np

# what may be meant by a number of this unit above this size: a unit, and how many of the first one it is
MEANT = {
    "rad": (0.0, "deg", math.pi / 180.0),
    "rad/s": (2.0, "deg/s", math.pi / 180.0),
    "m": (1.0, "mm", 1e-3),
    "-": (2.0, "%", 0.01),
}
LONGEST = 60  # characters of a value that a message shows


class InputError(ValueError):
    """A value, name or file given by the user that can't be used. The message is one line meant for that user.

    **Arguments:**

    - ``message``: names the field, the value, the unit and what is allowed; line breaks become spaces.

    **Example:**

    >>> try:
    ...     jb.Scenario(approach_speed=-0.1)
    ... except jb.InputError as error:
    ...     print(error)
    scenario.approach_speed = -0.1 m/s is out of range; allowed: (0, inf) m/s
    """

    def __init__(self, message: object) -> None:
        super().__init__(" ".join(str(message).split()))

    def between(self, before: str = "", after: str = "") -> "InputError":
        """Return the same error with words before and after its own."""
        return InputError(f"{before}{self}{after}")


class OutOfRange(InputError):
    """A number outside of its range, told in the unit of its field, or in one that a person has typed.

    **Arguments:**

    - ``path``, ``value``, ``unit``: as of `check_number`.
    - ``limits``: low and high end [``unit``], and whether each is open.
    - ``before``, ``after``: further words.
    """

    def __init__(
        self,
        path: str,
        value: float,
        unit: str,
        limits: tuple[float, float, bool, bool],
        before: str = "",
        after: str = "",
    ) -> None:
        low, high, low_open, high_open = limits
        allowed = interval_text(low, high, unit, low_open, high_open)
        hint = meant(value, unit, **dict(zip(("low", "high", "low_open", "high_open"), limits, strict=True)))
        super().__init__(f"{before}{path} = {with_unit(value, unit)} is out of range; allowed: {allowed}{hint}{after}")
        self.path, self.value, self.unit, self.limits, self.before, self.after = (
            path,
            value,
            unit,
            limits,
            before,
            after,
        )

    def between(self, before: str = "", after: str = "") -> "OutOfRange":
        """See `InputError.between`."""
        return OutOfRange(
            self.path, self.value, self.unit, self.limits, f"{before}{self.before}", f"{self.after}{after}"
        )

    # Python pickles an exception with the message alone, from which one of this class could not be made.
    def __reduce__(self) -> tuple[type[InputError], tuple[str]]:
        return InputError, (str(self),)


def shown(value: Any) -> str:
    """Return a value as a message shows it: on one line, cut where it is long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"


def as_number(value: Any) -> Any:
    """Return a single number as a float, and a list or tuple of numbers as an array; anything else stays as it is."""
    if type(value) is float:
        return value
    # True and False are integers to Python, and so is a time span of NumPy, which would lose its unit.
    if isinstance(value, (Real, Decimal)) and not isinstance(value, bool) and unit_of_library(value) is None:
        try:
            return float(value)
        except OverflowError:  # an integer of more than 308 digits
            return math.inf if value > 0 else -math.inf  # type: ignore[operator]
    if isinstance(value, (list, tuple)) and value:
        import jax
        import numpy as np

        if all(isinstance(entry, (jax.Array, Real)) for entry in value) and any(
            isinstance(entry, jax.Array) for entry in value
        ):
            return jax.numpy.stack(list(value))
        numbers = [as_number(entry) for entry in value]
        return np.array(numbers) if all(type(number) is float for number in numbers) else value
    return value


def unit_of_library(value: Any) -> str | None:
    """Return the unit of a quantity of another library (pint, astropy, unyt, xarray), or of a time span, as that
    library writes it; None for what has no unit of its own."""
    if isinstance(value, (float, int, str, list, tuple, dict)) or value is None:
        return None
    import datetime

    import numpy as np

    spans = isinstance(value, (np.timedelta64, datetime.timedelta))
    if spans or getattr(getattr(value, "dtype", None), "kind", "") == "m":
        return "s"
    for number, unit in (("magnitude", "units"), ("value", "unit"), ("value", "units")):
        if hasattr(value, number) and (symbol := getattr(value, unit, None)) is not None:
            return str(symbol)
    attributes = getattr(value, "attrs", None)  # of labelled arrays
    symbol = attributes.get("units") if isinstance(attributes, dict) else None
    return None if symbol is None else str(symbol)


def masked(value: Any) -> int:
    """Return how many entries of an array are masked as no measurement."""
    import numpy as np

    if isinstance(value, (list, tuple)):
        return sum(map(masked, value))
    return int(np.ma.count_masked(value)) if isinstance(value, np.ma.MaskedArray) else 0


def check_masks(path: str, value: Any) -> None:
    """Raise `InputError` for an array in which entries are masked as no measurement."""
    if count := masked(value):
        import numpy as np

        what = "is masked, and so is no number" if count == 1 else "are masked, and so are no numbers"
        remedy = "leave out what is masked, as x.compressed() does"
        size = sum(map(np.size, value)) if isinstance(value, (list, tuple)) else np.size(value)
        raise InputError(f"{path}: {count} of {size} values {what}; {remedy}")


def check_plain(path: str, value: Any, unit: str) -> None:
    """Raise `InputError` for numbers that would lose what they say of themselves: masks, and units of another
    library."""
    if type(value) is float:
        return
    check_masks(path, value)
    entries = value if isinstance(value, (list, tuple)) else [value]
    if (symbol := next(filter(None, map(unit_of_library, entries)), None)) is not None:
        in_unit = unit_text(unit, before=" in ")
        raise InputError(f"{path} = {shown(value)} is a quantity in {symbol}; give its plain number{in_unit}")


def concrete(value: Any) -> "np.ndarray | None":
    """Return the value as a NumPy array, or None where it is not made of real numbers or is traced and not known
    yet."""
    import jax
    import numpy as np

    if isinstance(value, jax.core.Tracer) or masked(value) or unit_of_library(value) is not None:
        return None
    try:
        array = np.asarray(as_number(value))
    except (TypeError, ValueError):
        return None
    return array.astype(float) if array.dtype.kind in "iuf" else None


def inside(
    value: Any, *, low: Any = -math.inf, high: Any = math.inf, low_open: bool = False, high_open: bool = False
) -> Any:
    """Return whether numbers are finite and in a range (see `check_number`): NumPy's and JAX's, traced ones too."""
    above = (value > low) if low_open else (value >= low)
    below = (value < high) if high_open else (value <= high)
    # NaN fails every comparison, and so is in no range.
    return above & below & (abs(value) < math.inf)


def check_number(
    path: str,
    value: Any,
    unit: str,
    *,
    low: float = -math.inf,
    high: float = math.inf,
    low_open: bool = False,
    high_open: bool = False,
) -> None:
    """Raise `InputError` unless ``value`` (a number or an array of them) is finite and inside the range.

    **Arguments:** ``path``: dotted name shown to the user; ``unit``: as shown, '-' for none; ``low``, ``high``: the
    range, its ends included unless ``low_open`` or ``high_open``. Traced values pass: they have no value yet.
    """
    if type(value) is float and (
        low < value < high or (value == low > -math.inf and not low_open)
    ):  # spare most the arrays
        return
    import jax

    if isinstance(value, jax.core.Tracer):
        return
    check_plain(path, value, unit)
    limits: dict[str, Any] = {"low": low, "high": high, "low_open": low_open, "high_open": high_open}
    allowed = interval_text(unit=unit, **limits)
    if (array := concrete(value)) is None or not array.size:
        raise InputError(f"{path}: {shown(value)} is not a number; expected {allowed}")
    bad = ~inside(array, **limits)
    if bad.any():
        first = float(array[bad].flat[0])
        raise OutOfRange(path, first, unit, (low, high, low_open, high_open))


def meant(value: float, unit: str, **limits: Any) -> str:
    """Return a hint at the smaller unit (degrees, millimetres, per cent) in which a number is in its range; "" for
    none."""
    least, smaller, factor = MEANT.get(unit, (math.inf, "", 1.0))
    return (
        f'; "{with_unit(value, smaller)}" if that is meant'
        if abs(value) > least and inside(value * factor, **limits)
        else ""
    )


def check_entries(
    path: str,
    value: Any,
    unit: str,
    low: Any,
    high: Any,
    *,
    too_low: str = "",
    too_high: str = "",
    high_open: bool = True,
) -> None:
    """Raise `InputError` unless each entry is inside its own range, open below (see `check_number`); ``too_low`` and
    ``too_high`` say what is wrong below and above it, and which other numbers end the range."""
    # Most values are plain numbers within their range, which need no arrays.
    if type(value) is float and isinstance(low, float) and isinstance(high, float) and low < value < high:
        return
    check_plain(path, value, unit)
    known = [concrete(x) for x in (value, low, high)]
    if any(x is None for x in known):  # traced
        return
    numbers, least, most = same_shape(path, known)
    bad = ~inside(numbers, low=least, high=most, low_open=True, high_open=high_open)
    if bad.any():
        number, floor, top = (float(array[bad][0]) for array in (numbers, least, most))
        try:
            check_number(path, number, unit, low=floor, high=top, low_open=True, high_open=high_open)
        except InputError as error:
            raise error.between(after=too_low if 0.0 < number <= floor else too_high if number >= top else "") from None


def same_shape(path: str, known: "Iterable[np.ndarray | None]") -> "list[np.ndarray]":
    """Return arrays broadcast against each other. **Raises:** `InputError` where their lengths differ."""
    import numpy as np

    arrays = [array for array in known if array is not None]
    try:
        return list(np.broadcast_arrays(*arrays))
    except ValueError:
        shapes = " and ".join(sorted({str(array.shape) for array in arrays if array.ndim}))
        raise InputError(f"{path}: arrays of unequal shapes {shapes}; all must have one shape (n,)") from None


def check_single(path: str, value: Any, unit: str, instead: str, **limits: Any) -> None:
    """Raise `InputError` unless ``value`` is one number inside its range (see `check_number`); ``instead`` says what
    takes an array of them."""
    check_number(path, value, unit, **limits)
    if (array := concrete(value)) is not None and array.ndim:
        raise InputError(f"{path} has shape {array.shape}, but it must be one number: {instead}")


def check_whole(path: str, value: Any, least: int, most: int | None = None) -> None:
    """Raise `InputError` unless ``value`` is a whole number of at least ``least`` and at most ``most``, if given."""
    # True is an integer to Python, and no count.
    whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not whole or value < least or (most is not None and value > most):
        allowed = f"of at least {least}" if most is None else f"from {least} to {most}"
        raise InputError(f"{path} = {shown(value)} must be a whole number {allowed}")


def check_flag(path: str, value: Any) -> None:
    """Raise `InputError` unless ``value`` is True or False."""
    if not isinstance(value, bool):
        raise InputError(f"{path} = {shown(value)} must be true or false")


def check_choice(path: str, value: Any, choices: Iterable[str]) -> None:
    """Raise `InputError` unless ``value`` is one of ``choices``."""
    options = list(choices)
    if not isinstance(value, str) or value not in options:
        near = same_as(value, options) or nearest(value, options)
        hint = f"; did you mean {near}?" if near else ""
        raise InputError(f"{path} = {shown(value)} is unknown; choose one of {', '.join(options)}{hint}")


def check_type(path: str, value: Any, kind: type, instead: str) -> None:
    """Raise `InputError` unless ``value`` is a ``kind``; ``instead`` shows what to write."""
    if not isinstance(value, kind):
        article = "an" if kind.__name__[0] in "AEIO" else "a"
        raise InputError(f"{path} = {shown(value)} is not {article} {kind.__name__}; write {instead}")


def check_names(path: str, names: Any, example: str) -> tuple[str, ...]:
    """Return the names as a tuple. **Raises:** `InputError` unless they are a list of words, none of them twice."""
    if isinstance(names, str):
        raise InputError(f"{path} = {shown(names)} is one name, not a list of them; write {path}=({names!r},)")
    # What is no list at all is refused by the next check.
    given = tuple(names) if isinstance(names, Iterable) and not isinstance(names, bytes) else (None,)
    if not all(isinstance(name, str) for name in given):
        raise InputError(f"{path} = {shown(names)} is not a list of names; write {path}=({example!r},)")
    if not given:
        raise InputError(f"{path} is empty; name at least one, {example} say")
    for name in given:
        if given.count(name) > 1:
            raise InputError(f"{path} names {name} twice")
    return given


def check_known(names: Iterable[str], known: Iterable[str], where: str, meaning: Meaning | None = None) -> None:
    """Raise `InputError` for a name that is unknown ``where`` it stands, with what may be meant (see `suggest`)."""
    options = list(known)
    for name in names:
        if name not in options:
            raise InputError(f"{where}.{name} is unknown{suggest(name, options, meaning)}")
