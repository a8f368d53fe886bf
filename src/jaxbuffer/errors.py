"""Input errors that name the field, the value, the unit and the allowed range."""

import difflib
import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # the command line's own errors need neither: they are imported where a value is looked at
    import numpy as np


class InputError(ValueError):
    """A value, name or file given by the user that can't be used. The message is one line meant for that user."""


def concrete(value: Any) -> "np.ndarray | None":
    """The value as a NumPy array, or None inside a trace, where there is nothing to check yet."""
    import jax
    import numpy as np

    if isinstance(value, jax.core.Tracer):
        return None
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        return None


def inside(
    value: Any, *, low: Any = -math.inf, high: Any = math.inf, low_open: bool = False, high_open: bool = False
) -> Any:
    """Whether numbers are finite and in a range (see `check_number`): NumPy's and JAX's, traced ones too."""
    above = (value > low) if low_open else (value >= low)
    below = (value < high) if high_open else (value <= high)
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
    if type(value) in (float, int) and low < value < high:  # most are: spare them the arrays
        return
    import jax
    import numpy as np

    if isinstance(value, jax.core.Tracer):
        return
    unit = "" if unit == "-" else f" {unit}"
    if isinstance(value, (bool, str)) or value is None or (array := concrete(value)) is None or not array.size:
        raise InputError(f"{path}: {value!r} is not a number; expected {_range(low, high, low_open, high_open)}{unit}")
    bad = ~inside(array, low=low, high=high, low_open=low_open, high_open=high_open)
    if np.any(bad):
        shown = float(array[bad].flat[0]) if array.ndim else float(array)
        raise InputError(
            f"{path} = {shown:g}{unit} is out of range; allowed: {_range(low, high, low_open, high_open)}{unit}"
        )


def _range(low: float, high: float, low_open: bool, high_open: bool) -> str:
    left = "(-inf" if low == -math.inf else ("(" if low_open else "[") + f"{low:g}"
    right = "inf)" if high == math.inf else f"{high:g}" + (")" if high_open else "]")
    return f"{left}, {right}"


def check_choice(path: str, value: Any, choices: Iterable[str]) -> None:
    """Raise `InputError` unless ``value`` is one of ``choices``."""
    options = list(choices)
    if value not in options:
        raise InputError(f"{path} = {value!r} is unknown; choose one of {', '.join(options)}{suggest(value, options)}")


def suggest(name: Any, known: Iterable[str]) -> str:
    """'; did you mean …?' for a mistyped name, or nothing."""
    by_lower = {option.lower(): option for option in known}
    near = difflib.get_close_matches(str(name).lower(), list(by_lower), n=1, cutoff=0.5)
    return f"; did you mean {by_lower[near[0]]}?" if near else ""
