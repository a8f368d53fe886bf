"""Values as text: units, signs, ranges, changes, digits that tell a value from a bound, and what is not known."""

import math

import numpy as np
import pytest

from jaxbuffer import value_text as text
from jaxbuffer.fields import as_displayed, as_typed, ends_as_typed
from jaxbuffer.fields.shown import field_text


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        (text.with_unit(25.0, "mm"), "25 mm"),
        (text.with_unit(253.13152, "N", 4), "253.1 N"),
        (text.with_unit(0.5, "-"), "0.5"),
        (text.with_unit(0.5, ""), "0.5"),
        (text.with_unit(0.1728, "N/(N/m)", sign=True), "+0.1728 N/(N/m)"),
        (text.with_unit(3.0, "°"), "3°"),
        (text.with_unit(math.nan, "N"), "nan N"),
        (text.degrees_text(3.0), "+3°"),
        (text.degrees_text(-1e-15), "0°"),
        (text.degrees_text(-0.5, sign=False), "-0.5°"),
        (text.range_text(5.0, 30.0, "cm/s"), "5 to 30 cm/s"),
        (text.range_text(-2.0, 3.0, "°"), "-2° to +3°"),
        (text.range_text(1.0, 2.0, "-", to=" … "), "1 … 2"),
        (text.interval_text(low=0.0, low_open=True, unit="N"), "(0, inf) N"),
        (text.interval_text(1.0, 25.0, "mm"), "[1, 25] mm"),
        (text.interval_text(), "(-inf, inf)"),
        (text.before_and_after(253.13, math.nan), "253.1 → –"),
        (text.percent_text(0.125, "+.3g"), "+12.5 %"),
        (text.percent_text(None), "an unknown share"),
        (text.percent_text(math.inf), "an unknown share"),
        (text.quotient_unit("N", "N/m"), "N/(N/m)"),
        (text.quotient_unit("N", "kg"), "N/kg"),
    ],
)
def test_values_as_text(said, expected):
    assert said == expected


def test_a_value_stands_in_the_unit_that_was_typed_or_else_in_that_of_figures():
    assert text.with_unit(*as_typed(0.2, "m/s", "cm/s")) == "20 cm/s"
    assert text.with_unit(*as_typed(0.2, "m/s", "")) == "0.2 m/s"
    assert text.range_text(*ends_as_typed(0.05, 0.3, "m/s", "cm/s")) == "5 to 30 cm/s"
    assert text.with_unit(*as_displayed(0.0071, "m")) == "7.1 mm"


@pytest.mark.parametrize(
    ("value", "unit", "expected"),
    [(None, "N", "not set"), (True, "", "true"), (500.0, "N/m", "500 N/m"), ("hertz", "", "hertz"), (3, "", "3")],
)
def test_a_field_as_text(value, unit, expected):
    assert field_text(value, unit) == expected


def test_a_number_in_a_table_is_shown_to_the_unit_from_ten_thousand_on():
    assert [text.table_text(x) for x in (9999.6, 12345.6, 2.5e6)] == ["10000", "12346", "2.5e+06"]


def test_what_has_more_digits_than_are_shown_is_shown_to_the_unit_and_not_with_an_exponent():
    assert text.with_unit(2e4, "N", 4) == "20000 N" and text.with_unit(-19572.4, "N", 4, sign=True) == "-19572 N"
    assert text.with_unit(1e5, "N m/rad", 5) == "100000 N m/rad" and text.with_unit(2.5e6, "N", 4) == "2.5e+06 N"
    assert text.range_text(2000.0, 1e5, "N", 4) == "2000 to 100000 N"
    assert text.with_unit(2.5e-7, "m", 4) == "2.5e-07 m"
    # Rounding leaves 6e-16 m of an extension: it has none.
    assert text.before_and_after(0.883, 6.106e-13) == "0.883 → 0"


@pytest.mark.parametrize(("value", "bound", "digits"), [(26.0, 25.0, 4), (25.0002, 25.0, 6), (24.9999999, 25.0, 9)])
def test_digits_tell_a_value_from_the_bound_that_it_breaks(value, bound, digits):
    assert text.digits_apart(value, bound) == digits


def test_a_unit_is_chosen_by_size():
    units = (("kN", 1e-3), ("N", 1.0))
    assert text.unit_by_size(np.float64(12e3), units, 10.0) == units[0]
    assert text.unit_by_size(9e3, units, 10.0) == units[1] == text.unit_by_size(0.0, units, 10.0)
