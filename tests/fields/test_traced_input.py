"""Numbers that are known only inside compiled code are checked there: out of range, they make the capture fail."""

import itertools
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer import InputError, Outcome
from jaxbuffer.fields import paths, unit
from jaxbuffer.mechanisms.probe_cone.design import check_fit, valid

ORDINARY = (-2.0, -0.8, -0.1, 0.0, 1e-3, 0.015, 0.06, 0.07, 0.1365, 0.49, 0.6, 1.0, 1.5, 2.0)
CANDIDATES = (-math.inf, *ORDINARY, math.inf, math.nan)
NUMBERS = [
    *(path for path in paths(jb.table2()) if unit(jb.table2(), path)),
    *(f"scenario.{path}" for path in paths(jb.Scenario()) if unit(jb.Scenario(), path)),
]
BESIDE = {
    "scenario.thrust": {"scenario.thrust_time": 1.0},
    "scenario.thrust_time": {"scenario.thrust": 1.0},
    "control.stiffness": {"control.limit": 1.0},
}


def given(values):
    """Table 2 with other values at some paths, and what these need beside them."""
    for path in list(values):
        values = BESIDE.get(path, {}) | values
    scenario = {path.removeprefix("scenario."): x for path, x in values.items() if path.startswith("scenario.")}
    design = {path: x for path, x in values.items() if not path.startswith("scenario.")}
    return jb.replace(jb.table2(), design), jb.Scenario(**scenario)


def taken(values) -> bool:
    """Whether the checks outside compiled code let the values pass."""
    try:
        check_fit(*given(values))
    except InputError:
        return False
    return True


@pytest.mark.parametrize("path", NUMBERS)
def test_inside_compiled_code_the_same_numbers_are_in_range(path):
    inside = jax.jit(jax.vmap(lambda value: valid(*given({path: value}))))(jnp.array(CANDIDATES))
    assert inside.tolist() == [taken({path: value}) for value in CANDIDATES]
    assert not inside[-1] and not inside[-2] and not inside[0]


PAIRS = [
    ("probe.tip_radius", "cone.half_angle"),
    ("scenario.contact_distance", "cone.length"),
    ("scenario.misalignment", "cone.half_angle"),
]


@pytest.mark.parametrize("pair", PAIRS)
def test_numbers_that_must_fit_each_other(pair):
    places = np.array(list(itertools.product((0.01, 0.02, 0.06, 0.3, 0.7, 1.2), repeat=2)))
    inside = jax.jit(jax.vmap(lambda a, b: valid(*given({pair[0]: a, pair[1]: b}))))(*places.T)
    expected = [taken({pair[0]: float(a), pair[1]: float(b)}) for a, b in places]
    assert inside.tolist() == expected
    assert 0 < sum(expected) < len(expected)


def test_exponents_belong_to_one_law():
    fits = jax.jit(lambda exponent: valid(*given({"contact.exponent": exponent})))
    assert fits(1.5) and not fits(1.4)
    adams = {"contact.law": "adams", "contact.stiffness": 1e9}
    assert jax.jit(lambda exponent: valid(*given(adams | {"contact.exponent": exponent})))(1.4)


def captured(stiffness, speed, distance, rtol, duration, **options):
    values = {"buffer.k_A": stiffness, "scenario.approach_speed": speed, "scenario.contact_distance": distance}
    return jb.simulate(*given(values | {"probe.tip_radius": 0.035}), duration, rtol=rtol, **options)


GOOD = (500.0, 0.1, 0.04, 1e-8, 0.01)
LANES = [
    GOOD,
    (-5.0, *GOOD[1:]),
    (500.0, math.nan, *GOOD[2:]),
    (500.0, 0.1, 0.08, *GOOD[3:]),
    (500.0, 0.1, 0.01, *GOOD[3:]),  # the tip in the other flank at the start
    (*GOOD[:3], 0.5, GOOD[4]),
    (*GOOD[:4], -1.0),
    (800.0, *GOOD[1:]),
]


@pytest.mark.long
def test_numbers_out_of_range_fail_and_leave_other_lanes_alone():
    batch = jax.jit(jax.vmap(captured))(*map(jnp.array, zip(*LANES, strict=True)))
    outcomes = [Outcome(int(code)) for code in batch.code]
    assert outcomes == [Outcome.timeout, *[Outcome.failed_input] * 6, Outcome.timeout]
    assert Outcome.failed_input.failed and "out of its allowed range" in Outcome.failed_input.reason
    bad = np.array(outcomes) == Outcome.failed_input
    for name in ("peak_force", "stroke", "end_time", "capture_margin"):
        assert np.isnan(np.asarray(getattr(batch, name))).tolist() == bad.tolist()
    assert np.all(np.asarray(batch.attempts)[bad] == 0), "costs no step"
    for lane in np.flatnonzero(~bad):
        alone = captured(*LANES[lane])
        np.testing.assert_allclose(batch.peak_force[lane], alone.peak_force, rtol=1e-6)
        np.testing.assert_allclose(batch.stroke[lane], alone.stroke, rtol=1e-6)


@pytest.mark.long
def test_a_failed_capture_has_no_derivative():
    """Whether a number is out of range or the run out of steps."""
    peak = jax.jit(jax.value_and_grad(lambda *x: captured(*x, max_steps=20).peak_force))
    for stiffness in (-5.0, 500.0):
        value, slope = peak(stiffness, *GOOD[1:4], 8.0)
        assert np.isnan(value) and np.isnan(slope)


def test_known_numbers_are_still_refused_at_once():
    with pytest.raises(InputError, match=r"buffer\.k_A = -5 N/m is out of range; allowed: \(0, inf\) N/m"):
        captured(-5.0, *GOOD[1:])
    with pytest.raises(InputError, match=r"rtol = 0.5 is out of range"):
        jax.jit(lambda stiffness: captured(stiffness, 0.1, 0.04, 0.5, 0.01).peak_force)(500.0)
