"""Measured curves against SciPy's interpolation of the same points."""

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


def pchip(points):
    return PchipInterpolator(*np.array([(0.0, 0.0), *points]).T)


def inside(points):
    """Places between (0, 0) and the last point, the points themselves among them."""
    return np.unique([*np.linspace(0.0, points[-1][0], 101), *(place for place, _ in points)])


@each_curve
def test_value_and_integral_are_scipys(name):
    curve, reference = Curve.of(POINTS[name], AXES).cubic(), pchip(POINTS[name])
    places = inside(POINTS[name])
    assert_allclose(jax.vmap(curve.value)(places), reference(places), rtol=1e-13, atol=1e-14)
    assert_allclose(jax.vmap(curve.integral)(places), reference.antiderivative()(places), rtol=1e-13, atol=1e-17)


@each_curve
def test_slope_is_scipys(name):
    """At the points too, where one piece hands over to the next."""
    curve, reference = Curve.of(POINTS[name], AXES).cubic(), pchip(POINTS[name])
    places = inside(POINTS[name])
    steepest = np.max(reference.derivative()(places))
    ours = jax.vmap(jax.grad(curve.value))(places)
    assert_allclose(ours, reference.derivative()(places), rtol=1e-11, atol=1e-12 * steepest)


@each_curve
def test_it_goes_on_straight_beyond_both_ends(name):
    curve, reference = Curve.of(POINTS[name], AXES).cubic(), pchip(POINTS[name])
    last, value = POINTS[name][-1]
    first_slope, last_slope = reference.derivative()(0.0), reference.derivative()(last)
    whole = reference.integrate(0.0, last)
    for beyond in (1e-3, 0.05):
        assert_allclose(curve.value(last + beyond), value + last_slope * beyond, rtol=1e-13)
        assert_allclose(curve.integral(last + beyond), whole + beyond * (value + 0.5 * last_slope * beyond), rtol=1e-13)
        assert_allclose(curve.value(-beyond), -first_slope * beyond, rtol=1e-13)
        assert_allclose(curve.integral(-beyond), 0.5 * first_slope * beyond**2, rtol=1e-13)


def test_one_point_is_a_straight_line():
    curve = Curve.of([(0.02, 10.0)], AXES).cubic()
    for place in (-0.01, 0.0, 0.013, 0.02, 0.07):
        assert_allclose(curve.value(place), 500.0 * place, rtol=1e-14)
        assert_allclose(curve.integral(place), 250.0 * place**2, rtol=1e-14)


@each_curve
def test_it_falls_nowhere(name):
    curve = Curve.of(POINTS[name], AXES).cubic()
    places = np.linspace(-0.01, 2.0 * POINTS[name][-1][0], 1001)
    assert np.all(np.diff(jax.vmap(curve.value)(places)) > -1e-14 * POINTS[name][-1][1])


@each_curve
@pytest.mark.parametrize("axis", [0, 1], ids=["by places", "by values"])
def test_derivatives_by_its_points_are_differences(name, axis):
    points = np.array(POINTS[name])
    places = np.linspace(-0.21, 1.29, 11) * points[-1, 0]  # at no point: the second derivative jumps there

    @jax.jit
    def values(points):
        curve = Curve.of([tuple(point) for point in points], AXES).cubic()
        return jax.vmap(lambda at: jnp.stack([curve.value(at), curve.integral(at)]))(places)

    ours = jax.jacfwd(values)(jnp.asarray(points))[..., axis]
    for k in range(len(points)):
        step = np.zeros_like(points)
        step[k, axis] = 1e-6 * points[k, axis]
        difference = (values(points + step) - values(points - step)) / (2.0 * step[k, axis])
        assert_allclose(ours[..., k], difference, rtol=1e-6, atol=1e-7 * np.max(np.abs(difference)))


def test_addresses_name_its_numbers():
    curve = Curve.of(POINTS["two"], AXES)
    assert curve.addresses() == ["stroke[0]", "stroke[1]", "force[0]", "force[1]"]
    assert curve.get("force[1]") == 3.0
    assert curve.replaced({"force[1]": 4.0}).points() == [[0.005, 2.0], [0.02, 4.0]]
    assert curve.points() == [[0.005, 2.0], [0.02, 3.0]]
