"""Measured curves against SciPy's interpolation of the same points."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import PchipInterpolator

from jaxbuffer.fields import Curve

AXES = (("stroke", "m"), ("force", "N"))
POINTS = {
    "two": [(0.005, 2.0), (0.02, 3.0)],
    "three, steep then flat": [(0.001, 9.0), (0.01, 9.5), (0.02, 9.6)],
    "five": [(0.002, 0.5), (0.005, 2.0), (0.01, 6.0), (0.02, 20.0), (0.03, 60.0)],
}
each_curve = pytest.mark.parametrize("name", POINTS)


@eqx.filter_jit
def cubic_of(points):
    return Curve.of(points, AXES).cubic()


@jax.jit  # once for all curves of as many points and as many places
def along(curve, places):
    """Value, integral and slope of a curve at some places."""
    return tuple(jax.vmap(of)(places) for of in (curve.value, curve.integral, jax.grad(curve.value)))


@jax.jit
def of_points(points, places):
    """Value and integral at some places, of the curve through some points."""
    curve = Curve.of([tuple(point) for point in points], AXES).cubic()
    return jax.vmap(lambda at: jnp.stack([curve.value(at), curve.integral(at)]))(places)


slopes_by_points = jax.jit(jax.jacfwd(of_points))


def pchip(points):
    return PchipInterpolator(*np.array([(0.0, 0.0), *points]).T)


def inside(points):
    """Places between (0, 0) and the last point, the points themselves among them."""
    return np.unique([*np.linspace(0.0, points[-1][0], 101), *(place for place, _ in points)])


@each_curve
def test_value_and_integral_are_scipys(name):
    curve, reference = cubic_of(POINTS[name]), pchip(POINTS[name])
    places = inside(POINTS[name])
    value, integral, _ = along(curve, places)
    assert_allclose(value, reference(places), rtol=1e-13, atol=1e-14)
    assert_allclose(integral, reference.antiderivative()(places), rtol=1e-13, atol=1e-17)


@each_curve
def test_slope_is_scipys(name):
    """At the points too, where one piece hands over to the next."""
    curve, reference = cubic_of(POINTS[name]), pchip(POINTS[name])
    places = inside(POINTS[name])
    steepest = np.max(reference.derivative()(places))
    _, _, slope = along(curve, places)
    assert_allclose(slope, reference.derivative()(places), rtol=1e-11, atol=1e-12 * steepest)


@each_curve
def test_it_goes_on_straight_beyond_both_ends(name):
    curve, reference = cubic_of(POINTS[name]), pchip(POINTS[name])
    last, value = POINTS[name][-1]
    first_slope, last_slope = reference.derivative()(0.0), reference.derivative()(last)
    whole = reference.integrate(0.0, last)
    for beyond in (1e-3, 0.05):
        (after, before), (area_after, area_before), _ = along(curve, np.array([last + beyond, -beyond]))
        assert_allclose(after, value + last_slope * beyond, rtol=1e-13)
        assert_allclose(area_after, whole + beyond * (value + 0.5 * last_slope * beyond), rtol=1e-13)
        assert_allclose(before, -first_slope * beyond, rtol=1e-13)
        assert_allclose(area_before, 0.5 * first_slope * beyond**2, rtol=1e-13)


def test_one_point_is_a_straight_line():
    places = np.array([-0.01, 0.0, 0.013, 0.02, 0.07])
    value, integral, _ = along(cubic_of([(0.02, 10.0)]), places)
    assert_allclose(value, 500.0 * places, rtol=1e-14)
    assert_allclose(integral, 250.0 * places**2, rtol=1e-14)


@each_curve
def test_it_falls_nowhere(name):
    curve = cubic_of(POINTS[name])
    places = np.linspace(-0.01, 2.0 * POINTS[name][-1][0], 1001)
    assert np.all(np.diff(along(curve, places)[0]) > -1e-14 * POINTS[name][-1][1])


@each_curve
@pytest.mark.parametrize("axis", [0, 1], ids=["by places", "by values"])
def test_derivatives_by_its_points_are_differences(name, axis):
    points = np.array(POINTS[name])
    places = np.linspace(-0.21, 1.29, 11) * points[-1, 0]  # at no point: the second derivative jumps there
    ours = np.asarray(slopes_by_points(points, places))[..., axis]
    for k in range(len(points)):
        step = np.zeros_like(points)
        step[k, axis] = 1e-6 * points[k, axis]
        above, below = (np.asarray(of_points(moved, places)) for moved in (points + step, points - step))
        difference = (above - below) / (2.0 * step[k, axis])
        assert_allclose(ours[..., k], difference, rtol=1e-6, atol=1e-7 * np.max(np.abs(difference)))


def test_addresses_name_its_numbers():
    curve = Curve.of(POINTS["two"], AXES)
    assert curve.addresses() == ["stroke[0]", "stroke[1]", "force[0]", "force[1]"]
    assert curve.get("force[1]") == 3.0
    assert curve.replaced({"force[1]": 4.0}).points() == [[0.005, 2.0], [0.02, 4.0]]
    assert curve.points() == [[0.005, 2.0], [0.02, 3.0]]
