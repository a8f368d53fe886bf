"""Numbers as other libraries hold them: quantities are converted or refused, never stripped; masks count."""

import datetime
import decimal
import fractions
import re

import jax.numpy as jnp
import numpy as np
import pandas as pd
import pint
import pytest
import xarray as xr
from numpy.testing import assert_allclose

import jaxbuffer as jb
from jaxbuffer.experiments.ranges import ranges
from jaxbuffer.run.instants import instants_of
from jaxbuffer.shock.spectrum import spectrum_of_motion
from jaxbuffer.sweeps.grid import grid

Q = pint.UnitRegistry().Quantity
MASKED = np.ma.array([0.1, 0.2, 0.9], mask=[0, 0, 1])
ONE_OF_THREE = "1 of 3 values is masked, and so is no number; leave out what is masked, as x.compressed() does"


class Quantity(np.ndarray):
    """An array with a unit as astropy's: a subclass with ``value`` and ``unit``, which NumPy strips in silence."""

    def __new__(cls, values, unit):
        made = np.asarray(values, float).view(cls)
        made.unit = unit
        return made

    @property
    def value(self):
        return np.asarray(self)


class Plain:
    """A quantity with ``value`` and ``units`` as unyt's, one number."""

    def __init__(self, value, units):
        self.value, self.units = value, units

    def __float__(self):
        return self.value

    def __repr__(self):
        return f"Plain({self.value}, {self.units!r})"


def speed(value):
    return jb.Scenario(approach_speed=value).approach_speed


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (Q(15.0, "cm/s"), 0.15),
        (Q(15, "cm/s"), 0.15),
        (Q(1.0, "knot"), 1852.0 / 3600.0),
        (Q(np.array([15.0, 20.0]), "cm/s"), [0.15, 0.2]),
        (Q(jnp.array([15.0, 20.0]), "cm/s"), [0.15, 0.2]),
        ([Q(15.0, "cm/s"), Q(0.2, "m/s")], [0.15, 0.2]),
        ([Q(15.0, "cm/s"), "0.2 m/s"], [0.15, 0.2]),
        (np.array([Q(15.0, "cm/s"), Q(20.0, "cm/s")], dtype=object), [0.15, 0.2]),
        (Quantity(15.0, "cm / s"), 0.15),
        (Quantity([15.0, 20.0], "cm s-1"), [0.15, 0.2]),
        (Plain(15.0, "cm/s"), 0.15),
        (xr.DataArray([15.0, 20.0], attrs={"units": "cm/s"}), [0.15, 0.2]),
        (np.array(["15 cm/s", "20 cm/s"]), [0.15, 0.2]),
        (np.ma.array([0.15, 0.2]), [0.15, 0.2]),
        (np.ma.array([0.15, 0.2], mask=[0, 0]), [0.15, 0.2]),
        (decimal.Decimal("0.15"), 0.15),
        (fractions.Fraction(3, 20), 0.15),
        (np.array([decimal.Decimal("0.15")], dtype=object), [0.15]),
        (np.longdouble(0.15), 0.15),
    ],
    ids=repr,
)
def test_what_has_a_unit_is_converted(value, expected):
    assert_allclose(speed(value), expected, rtol=1e-14)


@pytest.mark.parametrize(
    ("path", "value", "expected"),
    [
        ("probe.tip_mass", Q(50.0, "g"), 0.05),
        ("buffer.k_T", Q(5.0, "N*m/deg"), 5.0 * 180.0 / np.pi),
        ("buffer.k_T", Quantity(5.0, "N m / rad"), 5.0),
        ("cone.half_angle", Q(40.0, "deg"), np.radians(40.0)),
        ("contact.stiffness", Q(1e6, "N/mm**1.5"), 1e6 * 1000.0**1.5),
        ("contact.restitution", Q(80.0, "percent"), 0.8),
        ("passive.inertia", Quantity(5e6, "g m2"), 5e3),
        ("latch.closing_time", np.timedelta64(15, "ms"), 0.015),
        ("latch.closing_time", datetime.timedelta(milliseconds=15), 0.015),
    ],
    ids=str,
)
def test_every_field_converts_to_its_own_unit(path, value, expected):
    design = jb.replace(jb.table2(), {"latch.stiffness": 1e3, "latch.damping": 5.0})
    assert_allclose(jb.get(jb.replace(design, {path: value}), path), expected, rtol=1e-14)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (Q(15.0, "kg"), r"kg does not fit, expected a number in m/s; allowed: \(0, inf\) m/s"),
        (Quantity([15.0], "kg"), "kg does not fit, expected a number in m/s"),
        (Plain(15.0, "furlong/s"), "the unit furlong is unknown; expected a number in m/s"),
        (Q(-15.0, "cm/s"), r"= -0\.15 m/s is out of range"),
        ([Q(15.0, "cm/s"), 0.2], "0.2 has no unit; give each value one, or none"),
        ([Q(15.0, "kg"), Q(20.0, "kg")], "kg does not fit"),
        (Q(MASKED, "cm/s"), "scenario.approach_speed: 1 of 3 values is masked"),
        (np.timedelta64(15, "ms"), "s does not fit, expected a number in m/s"),
        (np.array([15], "m8[ms]"), "s does not fit, expected a number in m/s"),
        (np.datetime64("2026-01-01"), "is not a number; expected"),
        (MASKED, re.escape(f"scenario.approach_speed: {ONE_OF_THREE}")),
        (np.ma.masked, "1 of 1 values is masked"),
        ([np.ma.masked, 0.2], "is not a number|masked"),
        (np.ma.array([1, 2], mask=True), "2 of 2 values are masked, and so are no numbers"),
        (pd.Series([0.15, None], dtype="Float64"), "nan m/s is out of range"),
        (True, "True is not a number"),
        (np.array([True]), "is not a number"),
        (0.1 + 0j, "is not a number"),
        (np.array([b"0.1"]), "is not a number"),
    ],
    ids=repr,
)
def test_what_cannot_be_converted_is_refused_in_a_line_that_names_the_field(value, message):
    with pytest.raises(jb.InputError, match=message) as error:
        speed(value)
    assert "\n" not in str(error.value)


def test_a_time_of_months_has_no_length():
    with pytest.raises(jb.InputError, match=r"latch\.closing_time = .* has no length in seconds"):
        jb.replace(jb.table2(), {"latch.stiffness": 1e3, "latch.closing_time": np.timedelta64(1, "M")})


def along(values):
    return grid({"scenario.approach_speed": values}, jb.table2(), jb.Scenario()).axes[0].values


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (Q(np.array([15.0, 20.0]), "cm/s"), [0.15, 0.2]),
        ([Q(15.0, "cm/s"), Q(20.0, "cm/s")], [0.15, 0.2]),
        (Quantity([15.0, 20.0], "cm / s"), [0.15, 0.2]),
        ({"from": Q(10.0, "cm/s"), "to": Q(20.0, "cm/s"), "count": 3}, [0.1, 0.15, 0.2]),
        (np.array(["15 cm/s", "20 cm/s"]), [0.15, 0.2]),
        (np.ma.array([0.1, 0.2]), [0.1, 0.2]),
    ],
    ids=repr,
)
def test_values_of_a_sweep_are_converted(values, expected):
    assert_allclose(along(values), expected, rtol=1e-14)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (MASKED, rf"sweep\.scenario\.approach_speed: {ONE_OF_THREE[:24]}"),
        ([0.1, np.ma.masked], "1 of 2 values is masked"),
        (Q(np.array([15.0]), "kg"), "kg does not fit"),
        ([Q(15.0, "kg")], "kg does not fit"),
    ],
    ids=repr,
)
def test_values_of_a_sweep_that_cannot_be_converted_are_refused(values, message):
    with pytest.raises(jb.InputError, match=message):
        along(values)


def test_choices_of_a_sweep_are_not_masked():
    laws = np.ma.array(["hertz", "adams"], mask=[0, 1])
    with pytest.raises(jb.InputError, match=r"sweep\.contact\.law: 1 of 2 values is masked"):
        grid({"contact.law": laws}, jb.table2(), jb.Scenario())


def test_ranges_of_a_sample_are_converted_or_refused():
    def ends(low, high):
        made = ranges({"scenario.approach_speed": (low, high)}, jb.table2(), jb.Scenario())[0]
        return made.low, made.high

    assert_allclose(ends(Q(5.0, "cm/s"), Q(10.0, "cm/s")), (0.05, 0.1), rtol=1e-14)
    for low, high, message in (
        (Q(5.0, "kg"), Q(10.0, "kg"), "kg does not fit"),
        (0.1, np.ma.masked, "1 of 1 values is masked"),
        (Q(5.0, "cm/s"), 0.1, "0.1 has no unit"),
    ):
        with pytest.raises(jb.InputError, match=message):
            ends(low, high)


def stated(**parts):
    usual = {"design": jb.table2(), "scenarios": [jb.Scenario()]}
    return jb.Problem(**{**usual, "variables": [jb.Variable("buffer.k_A", 100.0, 2000.0)], **parts})


@pytest.mark.parametrize("number", [Q(1500.0, "mm"), Quantity(1500.0, "mm"), Plain(1500.0, "mm")], ids=repr)
def test_a_number_is_never_stripped_of_its_unit(number):
    """It is refused, or means 1.5 m: never 1500."""
    for use in (
        lambda: stated(variables=[jb.Variable("buffer.k_A", number, 2000.0)]),
        lambda: stated(variables=[jb.Variable("buffer.k_A", 100.0, number)]),
        lambda: stated(duration=number),
        lambda: stated(objective=jb.Objective({"peak_force": number})),
        lambda: jb.simulate(jb.table2(), jb.Scenario(), number),
        lambda: jb.simulate(jb.table2(), jb.Scenario(), rtol=number),
        lambda: instants_of([number]),
        lambda: spectrum_of_motion(jnp.array([0.0, 0.01]), jnp.array([2.0, 0.0]), number, 0.0),
    ):
        with pytest.raises(jb.InputError):
            use()
    try:
        limits = stated(limits=jb.Limits(at_most={"stroke": number})).limits
    except jb.InputError:
        return
    assert limits.at_most["stroke"] == pytest.approx(1.5, rel=1e-14)


@pytest.mark.parametrize(
    "use",
    [
        lambda it: stated(variables=[jb.Variable("buffer.k_A", it[2:], 2000.0)]),
        lambda it: stated(limits=jb.Limits(at_most={"stroke": it[2:]})),
        lambda it: stated(duration=it[2:]),
        lambda it: jb.sweep(jb.table2(), jb.Scenario(approach_speed=[0.1, 0.2, 0.3]), it),
        lambda it: jb.replace(jb.table2(), {"buffer.spring_curve": np.ma.stack([it, 10.0 * it], axis=1)}),
        instants_of,
    ],
)
def test_a_mask_is_never_ignored(use):
    with pytest.raises(jb.InputError, match=r"1 of [123] values is masked"):
        use(MASKED)
