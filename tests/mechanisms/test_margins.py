"""How near a capture came to the limits of the law, and how it ends: by hand."""

from types import SimpleNamespace

import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer import replace, table2
from jaxbuffer.mechanisms.probe_cone.law_validity import Validity, validity
from jaxbuffer.mechanisms.probe_cone.margins import throat
from jaxbuffer.mechanisms.probe_cone.parts.hinge_play import pin_in_bush, pin_law


@pytest.mark.quick
def test_beyond_the_limits_of_the_law_and_just_on_them():
    found = Validity(np.array([0.99, 1.0, 1.01]), np.array([1.01, 1.0, 0.99]))
    assert found.too_deep.tolist() == [False, False, True]
    assert found.yields.tolist() == [True, False, False]


@pytest.mark.quick
def test_depth_counts_by_a_tenth_of_the_radius_and_pressure_by_where_yield_begins():
    contact, materials = SimpleNamespace(yield_stress=None), (70e9, 0.3, 70e9, 0.3)
    design = SimpleNamespace(probe=SimpleNamespace(tip_radius=0.02), contact=contact, materials=materials)
    found = validity(design, np.array([1e-3, 3e-3]), np.array([100.0, 200.0]))
    np.testing.assert_allclose(found.depth, [0.5, 1.5], rtol=1e-14)
    np.testing.assert_array_equal(found.pressure, [0.0, 0.0])
    contact.yield_stress = 300e6
    a = (3.0 * 100.0 * 0.02 / (4.0 * 70e9 / (2.0 * (1.0 - 0.3**2)))) ** (1.0 / 3.0)
    expected = 1.5 * 100.0 / (np.pi * a**2) / (1.295 * np.exp(0.736 * 0.3) * 300e6)
    np.testing.assert_allclose(validity(design, 1e-3, 100.0).pressure, expected, rtol=1e-12)


@pytest.mark.parametrize(("share", "told"), [(0.99, 0), (1.01, 1)])
def test_the_pin_may_touch_a_small_area_of_its_bush(share, told):
    """√(R δ) up to √0.1 of the pin's radius, with R = R_pin R_bush/play."""
    design = replace(table2(), {"hinge.play": 2e-4})
    pin, bush = float(design.hinge.pin_radius), float(design.hinge.bush_radius)
    limit = float(pin_law(design).elastic(0.1 * pin * 2e-4 / bush))
    run = SimpleNamespace(mechanism=SimpleNamespace(quantities={}), maxima={"hinge_force": jnp.asarray(share * limit)})
    grows, *beyond = pin_in_bush(design).report.warnings(run)
    assert "errors may grow" in grows and len(beyond) == told
    run.maxima.clear()
    assert pin_in_bush(design).report.warnings(run) == [grows], (
        "where the force is not watched nothing is known of its area"
    )


def test_the_way_beyond_the_capture_plane_goes_on_at_the_last_speed():
    """0.3 m before it, and 0.1 m/s nearer: 4 s later 0.1 m beyond."""
    mechanism = SimpleNamespace(
        parts=SimpleNamespace(scenario=SimpleNamespace(start="contact")),
        all_of=lambda kind: [],
        element=lambda name: SimpleNamespace(holder=None),
    )
    ended = SimpleNamespace(count=jnp.asarray(2), time=jnp.asarray([0.0, 6.0, 1.0]))
    at_end = SimpleNamespace(throat=SimpleNamespace(before=0.3, receding=-0.1))
    before, beyond = throat(mechanism, ended, at_end, None, 10.0)
    assert float(before) == pytest.approx(0.3)
    assert float(beyond) == pytest.approx(0.1)
