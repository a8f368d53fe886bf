"""Values as text: a number with its unit, digits and sign, ranges, changes, and what is not known.

A number comes with the unit in which people are shown it. `jaxbuffer.fields` converts to it: `as_typed` to the unit
that a person typed, `as_displayed` to the one of figures and tables.
"""

import math
from typing import Any

DIGITS = 6  # significant ones, unless a call says otherwise
UNKNOWN = "–"  # in a table, of a value that is not known
ROUNDING = 1e-12  # what is smaller is shown as 0
WHOLE, LARGE = 1.0, 1e6  # between these no number has an exponent: one with too many digits is shown to the unit
MOST = 17  # digits that a number has at most


def is_plain(unit: str) -> bool:
    """Return whether a unit is that of a plain number: "-", or "" for none."""
    return unit in ("", "-")


def unit_text(unit: str, before: str = " ") -> str:
    """Return a unit as it stands behind a number: " mm", "°", "" for a plain number; ``before`` it: a space."""
    return "" if is_plain(unit) else unit if unit == "°" else f"{before}{unit}"


def number_text(value: float, digits: int = DIGITS, sign: bool = False) -> str:
    """Return a number with so many significant ``digits``: "0.1512", "20000"; ``sign``: whether a positive one has its
    sign."""
    plus = "+" if sign else ""
    text = f"{value:{plus}.{digits}g}"
    return f"{value:{plus}.0f}" if "e" in text and WHOLE <= abs(value) < LARGE else text


def with_unit(value: float, unit: str, digits: int = DIGITS, sign: bool = False) -> str:
    """Return a number with its unit: "25 mm"; ``sign``: whether a positive one has its sign."""
    return f"{number_text(value, digits, sign)}{unit_text(unit)}"


def degrees_text(angle: float, digits: int = 4, sign: bool = True) -> str:
    """Return an angle in degrees: "+3°", "-0.5°", "0°"."""
    return "0°" if abs(angle) < ROUNDING else with_unit(angle, "°", digits, sign)


def range_text(low: float, high: float, unit: str, digits: int = DIGITS, to: str = " to ") -> str:
    """Return a range with its unit: "5 to 30 cm/s", "-2° to +3°"."""
    if unit == "°":
        return f"{degrees_text(low, digits)}{to}{degrees_text(high, digits)}"
    return f"{number_text(low, digits)}{to}{with_unit(high, unit, digits)}"


def interval_text(
    low: float = -math.inf, high: float = math.inf, unit: str = "", low_open: bool = False, high_open: bool = False
) -> str:
    """Return a range as an interval: "(0, inf) N"; a round bracket is at an end that is not part of it."""
    left = "(-inf" if low == -math.inf else ("(" if low_open else "[") + f"{low:g}"
    right = "inf)" if high == math.inf else f"{high:g}" + (")" if high_open else "]")
    return f"{left}, {right}{unit_text(unit)}"


def table_text(value: Any) -> str:
    """Return a value as it stands in a table: a number to four digits, a dash for what is not known."""
    if value is None:
        return UNKNOWN
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return str(value).lower() if isinstance(value, bool) else str(value)
    if isinstance(value, int):
        return f"{value:.0f}"
    return "0" if abs(value) < ROUNDING else number_text(value, 4)


def before_and_after(before: float, after: float, digits: int = 4) -> str:
    """Return what became of a number: "253.1 → 148.2"; a dash for one that is NaN, not known."""
    each = (0.0 if abs(value) < ROUNDING else value for value in (before, after))
    return " → ".join(UNKNOWN if math.isnan(value) else number_text(value, digits) for value in each)


def relative_change(before: float | None, after: float | None) -> float | None:
    """Return ``after / before - 1`` [-]: 0 where both are 0, None where it has no meaning.

    It has none where a value is not known or not finite, where the first one alone is 0, and where the sign changes.
    """
    if before is None or after is None or not (math.isfinite(before) and math.isfinite(after)):
        return None
    if before == after:
        return 0.0
    # A change from zero, or through it, is no share of anything.
    if before == 0.0 or before * after < 0.0:
        return None
    change = after / before - 1.0
    return (change if before > 0.0 else -change) if math.isfinite(change) else None


def change_text(before: float | None, after: float | None, spec: str = "+.1f") -> str:
    """Return a `relative_change` in per cent: "+12.5 %"; a dash where it has no meaning."""
    change = relative_change(before, after)
    return UNKNOWN if change is None else percent_text(change, spec)


def percent_text(share: float | None, spec: str = ".2g") -> str:
    """Return a share in per cent: "12 %"; "an unknown share" where it is not known or not finite."""
    return f"{100.0 * share:{spec}} %" if share is not None and math.isfinite(share) else "an unknown share"


def quotient_unit(above: str, below: str) -> str:
    """Return the unit of a quotient: "N/kg", "N/(N/m)"."""
    # A product or quotient below would be read as part of the first quotient.
    return f"{above}/({below})" if {" ", "/"} & set(below) else f"{above}/{below}"


def unit_by_size(largest: float, units: tuple[tuple[str, float], ...], least: float) -> tuple[str, float]:
    """Return the first of ``units``, each with how many of it the number's own unit is, in which a ``largest`` number
    is at least ``least``; the last one for smaller numbers."""
    return next(((unit, many) for unit, many in units if many * largest >= least), units[-1])


def digits_apart(value: float, bound: float, fewest: int = 4) -> int:
    """Return how many digits tell a value from the bound that it breaks, which is written with `DIGITS`."""
    written = float(f"{bound:.{DIGITS}g}")
    for digits in range(fewest, MOST):
        # Rounded, a value may fall on the other side of the bound, and seem to keep it.
        if (rounded := float(f"{value:.{digits}g}")) != written and (rounded > written) == (value > bound):
            return digits
    return MOST
