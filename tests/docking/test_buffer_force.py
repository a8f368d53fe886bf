"""The real buffer's forces, energies and losses by its formulas, and what it conserves."""

import equinox as eqx
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.interpolate import PchipInterpolator

from docking.states import CURVES, REAL_BUFFER, mechanism, moving
from in_short import quick
from jaxbuffer import InputError, replace, table2
from jaxbuffer.elements import BufferForce

STROKES = (-0.003, -2e-5, 0.0, 1e-5, 3e-4, 0.004, 0.025)
SPEEDS = (-0.3, -0.02, -4e-4, 0.0, 4e-4, 0.02, 0.3)
CURVE = PchipInterpolator([0.0, 0.005, 0.01, 0.02], [0.0, 2.0, 6.0, 20.0])
DAMPER = PchipInterpolator([0.0, 0.02, 0.05, 0.2], [0.0, 0.2, 0.4, 0.9])


@eqx.filter_jit  # once for all strokes of a buffer
def spring_of(buffer, stroke):
    """Force and energy of the spring."""
    return buffer.spring_force(stroke), buffer.spring_energy(stroke)


@eqx.filter_jit
def damper_of(buffer, speed):
    """Forces of the damper and of the friction."""
    return buffer.damper_force(speed), buffer.friction_force(speed)


@eqx.filter_jit
def axial_motion(assembled, state):
    """Stroke and speed of the buffer, its tension and what it dissipates."""
    buffer, kin = assembled.element("buffer").force, assembled.kinematics(state)
    return *buffer.stroke(kin), buffer.tension(kin), buffer.dissipation(kin)


@eqx.filter_jit
def rebound(assembled, state, active):
    """Force and energy of the rebound stop."""
    at, stop = assembled.evaluate(state), assembled.element("rebound")
    force = stop.force(assembled.evaluated(at, "rebound"), assembled.closed_switches(active, "rebound"))
    return force, assembled.stored(at, active)["rebound"]


@eqx.filter_jit
def gaps(assembled, state):
    return assembled.gaps_at(assembled.evaluate(state))


def straight(curve, at):
    """SciPy's curve, straight before and after its points."""
    first, last = curve.x[0], curve.x[-1]
    inside = np.clip(at, first, last)
    return curve(inside) + curve.derivative()(inside) * (at - inside)


def spring(stroke, curve=False):
    force = straight(CURVE, stroke) if curve else 500.0 * stroke
    return force + 1.5 * stroke / np.sqrt(stroke**2 + 1e-4**2)


def damper(speed, curve=False):
    size = abs(speed)
    force = straight(DAMPER, size) if curve else 5.0 * size + 20.0 * size**2
    return np.sign(speed) * force * (3.0 if speed < 0.0 else 1.0)


def element(curves=False):
    values = {name: value for name, value in REAL_BUFFER.items() if not (curves and name == "buffer.c_A2")}
    found = mechanism(values | (CURVES if curves else {})).element("buffer").force
    assert isinstance(found, BufferForce)
    return found


@pytest.mark.parametrize("curves", [False, True], ids=["numbers", "curves"])
def test_forces_are_those_of_the_formulas(curves):
    buffer = element(curves)
    for stroke in STROKES:
        assert_allclose(spring_of(buffer, np.asarray(stroke))[0], spring(stroke, curves), rtol=1e-13, atol=1e-15)
    for speed in SPEEDS:
        force, friction = damper_of(buffer, np.asarray(speed))
        assert_allclose(force, damper(speed, curves), rtol=1e-13, atol=1e-15)
        assert_allclose(friction, 0.2 * np.tanh(speed / 1e-3), rtol=1e-13)


@pytest.mark.parametrize("curves", [False, True], ids=["numbers", "curves"])
def test_the_springs_energy_is_the_integral_of_its_force(curves):
    buffer = element(curves)
    for stroke in STROKES:
        points = [0.0, *(p for p in (0.005, 0.01, 0.02) if p < stroke)]
        whole = sum(
            quad(spring, a, b, (curves,), epsabs=1e-15)[0] for a, b in zip(points, [*points[1:], stroke], strict=True)
        )
        assert_allclose(spring_of(buffer, np.asarray(stroke))[1], whole, rtol=1e-9, atol=1e-14)


def force_of(values=None):
    return mechanism(values).element("buffer").force


def test_each_number_by_itself():
    assert_allclose(force_of({"buffer.preload": 2.0}).spring_force(3e-4), 0.15 + 2.0 * 3.0 / np.sqrt(10.0))
    assert_allclose(force_of({"buffer.c_A2": 10.0}).damper_force(-0.2), -1.4)
    assert_allclose(force_of({"buffer.rebound_factor": 4.0}).damper_force(-0.2), -4.0)
    assert_allclose(force_of({"buffer.rebound_factor": 4.0}).damper_force(0.2), 1.0)
    assert_allclose(force_of({"buffer.friction": 0.3}).friction_force(1e-3), 0.3 * np.tanh(1.0))


def test_without_them_it_is_the_papers_spring_and_damper():
    assert not isinstance(force_of(), BufferForce)
    assert mechanism().contact_names == ("lower", "upper")


@pytest.mark.parametrize("stroke_rate", quick([-0.06, 0.06], 0.06), ids=["out", "in"])
@pytest.mark.parametrize("values", [REAL_BUFFER, CURVES], ids=["numbers", "curves"])
def test_it_acts_between_cylinder_and_probe_and_its_losses_are_its_powers(values, stroke_rate):
    instant = moving(mechanism(values), stroke=0.004, stroke_rate=stroke_rate)
    buffer = instant.mechanism.element("buffer").force
    stroke, speed, tension, dissipation = axial_motion(instant.mechanism, instant.state)
    assert_allclose([stroke, speed], [0.004, stroke_rate], rtol=1e-12)
    dissipative = sum(map(float, damper_of(buffer, speed)))
    assert_allclose(tension, -(float(spring_of(buffer, stroke)[0]) + dissipative), rtol=1e-12)
    assert_allclose(dissipation, dissipative * float(speed), rtol=1e-12)
    linear, angular = instant.momentum_rates()
    assert_allclose([*linear, angular], 0.0, atol=1e-10)
    rest, flow = instant.energy_rate()
    assert flow > 1e-3
    assert abs(rest) < 1e-12 * flow


def test_the_rebound_stop_pulls_in_beyond_its_gap():
    assembled = mechanism(REAL_BUFFER)
    beyond = moving(assembled, stroke=-0.0015, stroke_rate=-0.03, closed=("rebound",))
    force = 2e4 * (0.0015 - 5e-4) + 20.0 * 0.03
    found, stored = rebound(*beyond)
    assert_allclose(found, force, rtol=1e-10)
    assert_allclose(stored, 0.5 * 2e4 * 1e-3**2, rtol=1e-9)
    rest, flow = beyond.energy_rate()
    assert abs(rest) < 1e-12 * flow
    returning = moving(assembled, stroke=-0.0006, stroke_rate=0.3, closed=("rebound",))  # c ṡ is more than k (s + g)
    assert float(rebound(*returning)[0]) == 0.0
    within = moving(assembled, stroke=-0.0004)
    gap, closing = np.asarray(gaps(assembled, within.state))
    assert_allclose([gap[2], closing[2]], [1e-4, 0.06], rtol=1e-9)


def test_a_curve_and_the_number_it_stands_for_are_given_together():
    with pytest.raises(InputError, match=r"buffer.spring_curve and buffer.k_A are given together"):
        replace(table2(), {**CURVES, "buffer.k_A": 400.0})
