"""Buildable values: IEC 60063's series and steps."""

import re

import pytest

from jaxbuffer import InputError, Problem, Scenario, table2
from jaxbuffer.choosing.series import SERIES, beside, check_rule, nearest, rounded_catalogues


def test_series_are_those_of_the_standard():
    """IEC 60063:2015, table 1: E6 and E12 are every fourth and second of E24; E48 is every second of E96."""
    assert SERIES["E6"] == (1.0, 1.5, 2.2, 3.3, 4.7, 6.8)
    assert SERIES["E12"] == (1.0, 1.2, 1.5, 1.8, 2.2, 2.7, 3.3, 3.9, 4.7, 5.6, 6.8, 8.2)
    assert len(SERIES["E24"]) == 24 and SERIES["E24"][::2] == SERIES["E12"]
    assert SERIES["E96"][:6] == (1.0, 1.02, 1.05, 1.07, 1.1, 1.13) and SERIES["E96"][-1] == 9.76
    assert SERIES["E48"] == SERIES["E96"][::2]


@pytest.mark.parametrize(
    ("value", "rule", "expected"),
    [
        (520.0, "E12", [390.0, 470.0, 560.0, 680.0]),
        (0.0099, "E6", [0.0047, 0.0068, 0.01, 0.015]),
        (470.0, "E12", [330.0, 390.0, 470.0, 560.0, 680.0]),
        (0.31, 0.1, [0.2, 0.3, 0.4, 0.5]),
        (7.0, 5.0, [5.0, 10.0, 15.0]),  # 0 is left out: nothing is built with it
        (300.0, 5.0, [290.0, 295.0, 300.0, 305.0, 310.0]),
    ],
)
def test_values_beside_a_number(value, rule, expected):
    assert beside(value, rule) == expected


def test_zero_is_a_multiple_of_each_step_and_in_no_series():
    problem = Problem(table2(), [Scenario()], [])
    (catalogue,), (place,) = rounded_catalogues(problem, {"buffer.c_A": 0.0}, {"buffer.c_A": 0.5})
    assert [part.fields["buffer.c_A"] for part in catalogue.parts] == [0.0, 0.5, 1.0] and place == 0
    with pytest.raises(InputError, match=r"no value of E12 lies beside contact\.friction = 0.*allowed: \[0"):
        rounded_catalogues(problem, {"contact.friction": 0.0}, {"contact.friction": "E12"})
    with pytest.raises(InputError, match=r"multiples of 1\.5 lies beside contact\.restitution = 0\.3.*1\]"):
        rounded_catalogues(problem, {"contact.restitution": 0.3}, {"contact.restitution": 1.5})


def test_the_nearest_is_so_by_ratio():
    assert nearest(600.0, [470.0, 560.0, 680.0]) == 1


@pytest.mark.parametrize(
    ("path", "rule", "message"),
    [
        ("buffer.k_A", "E13", "is no series; known: E3, E6, E12, E24, E48, E96"),
        ("buffer.k_A", "5 N", "N is a force, expected a number in N/m"),
        ("buffer.k_A", -5.0, "out of range"),
        ("buffer.k_A", True, "is no rounding"),
        ("contact.law", "E12", "contact.law is a choice; only numbers can be rounded"),
    ],
)
def test_what_is_no_rounding_is_said(path, rule, message):
    with pytest.raises(InputError, match=re.escape(message)):
        check_rule(f"roundings.{path}", path, rule, table2())
