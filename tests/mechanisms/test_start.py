"""Where a capture starts: M62 of docs/model.md, worked out again in plain trigonometry."""

import functools
from typing import NamedTuple

import equinox as eqx
import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

from jaxbuffer import InputError, Problem, Scenario, replace, sensitivity, simulate, sweep, table2
from jaxbuffer.elements.ball_contact import SLOWEST_TOUCHDOWN, BallState
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.probe_cone.assembly import assemble
from jaxbuffer.multibody import Kinematics

LOWER, UPPER = 0, 1
SCENARIOS = {
    "table 2": {},
    "misaligned up": {"misalignment": 0.07},
    "misaligned down": {"misalignment": -0.3, "contact_distance": 0.02},
    "turning towards": {"passive_rate": 0.02, "approach_speed": 0.2},
    "turning away": {"passive_rate": -0.006, "misalignment": 0.1},
}

each_scenario = pytest.mark.parametrize("name", SCENARIOS)
each_tip = pytest.mark.parametrize("free", [False, True], ids=["welded tip", "free tip"])


class Start(NamedTuple):
    """A mechanism and what it knows at its start."""

    mechanism: Assembled
    state: jax.Array
    active: jax.Array
    kin: Kinematics
    ball: BallState
    phi: jax.Array  # of the constraints
    jacobian: jax.Array


@functools.cache
def start(name, free):
    return _start(replace(table2(), {"probe.free_tip": free}), Scenario(**SCENARIOS[name]))


@eqx.filter_jit
def _start(design, scenario):
    mechanism = assemble(design, scenario)
    state, active = mechanism.start()
    at = mechanism.evaluate(state)
    constraints = mechanism.system.constraints(at.kin)
    return Start(mechanism, state, active, at.kin, at.elements[0], constraints.phi, constraints.jacobian)


@pytest.mark.quick
@each_scenario
@each_tip
def test_start_satisfies_the_constraints(name, free):
    it = start(name, free)
    assert_allclose(it.phi, 0.0, atol=2e-16)
    assert_allclose(np.sum(np.asarray(it.jacobian) * np.asarray(it.kin.v), axis=1), 0.0, atol=1e-16)


@pytest.mark.quick
@each_scenario
@each_tip
def test_tip_just_touches_the_lower_flank_at_the_slant_distance(name, free):
    it = start(name, free)
    mechanism, approach = it.mechanism, it.ball.approach
    assert abs(float(approach.gap[LOWER])) < 1e-16
    cone, edge = mechanism.parts.scenario, mechanism.elements[0].pair.shape
    angle = cone.misalignment
    cos, sin = np.cos(angle), np.sin(angle)
    edge_x = cos * edge.start_x - sin * edge.start_y[LOWER]
    edge_y = sin * edge.start_x + cos * edge.start_y[LOWER]
    slant = np.hypot(np.asarray(approach.foot.x)[LOWER] - edge_x, np.asarray(approach.foot.y)[LOWER] - edge_y)
    assert_allclose(slant, cone.contact_distance, rtol=1e-13)
    assert float(approach.gap[UPPER]) > 0.01
    assert_allclose(it.active, [1.0, 0.0])


@each_scenario
def test_tip_lies_where_the_model_says(name):
    """A = E₊ - b t₊ + R (-sin β, cos β), turned by θ_T0 about r_T = (0, 0); β = π/4."""
    it = start(name, False)
    half, s = np.sqrt(0.5), it.mechanism.parts.scenario
    local = np.array([-0.096 - (s.contact_distance + 0.015) * half, -0.015 + (0.015 - s.contact_distance) * half])
    cos, sin = np.cos(s.misalignment), np.sin(s.misalignment)
    ball = it.ball.centre.place
    assert_allclose([ball.x, ball.y], np.array([[cos, -sin], [sin, cos]]) @ local, atol=1e-16)
    assert_allclose(np.asarray(it.kin.q)[9:12], [0.0, 0.0, s.misalignment], atol=0.0)


@each_scenario
@each_tip
def test_spring_is_at_rest_and_everything_behind_the_tip_is_in_line(name, free):
    it = start(name, free)
    q, ball = np.asarray(it.kin.q), it.ball.centre.place
    assert_allclose(it.mechanism.element("buffer").force.state(it.kin).length, 0.1365, rtol=1e-15)
    assert_allclose(q[[1, 4, 7]], float(ball.y), atol=0.0)
    assert_allclose(q[[2, 5, 8]], 0.0, atol=0.0)
    # Tip centre - probe - spring; the cylinder's front, where the hinge is, lies its own length ahead of its rear.
    hinge = float(ball.x) - 0.2 - 0.1365 + 0.1365
    assert_allclose(q[0], hinge - 0.1365, atol=1e-16)


@each_scenario
@each_tip
def test_the_chaser_moves_and_the_target_only_turns(name, free):
    it = start(name, free)
    speed, rate = it.mechanism.parts.scenario.approach_speed, it.mechanism.parts.scenario.passive_rate
    assert_allclose(it.kin.v, [speed, 0, 0] * 3 + [0, 0, rate], atol=0.0)


@each_scenario
@each_tip
def test_memory_holds_the_approach_speed_at_first_contact(name, free):
    """v0 along the flank's normal, less the speed with which the target's turning moves the foot."""
    mechanism, state = start(name, free)[:2]
    s, angle = mechanism.parts.scenario, np.pi / 4 + mechanism.parts.scenario.misalignment
    normal = np.array([-np.sin(angle), np.cos(angle)])
    half = np.sqrt(0.5)
    local = np.array([-0.096 - s.contact_distance * half, -0.015 - s.contact_distance * half])
    cos, sin = np.cos(s.misalignment), np.sin(s.misalignment)
    foot = np.array([[cos, -sin], [sin, cos]]) @ local
    relative = np.array([s.approach_speed, 0.0]) - s.passive_rate * np.array([-foot[1], foot[0]])
    assert_allclose(mechanism.memory(state)[LOWER], -relative @ normal, rtol=1e-14)


def test_memory_has_a_floor():
    """A cone turning away faster than the tip follows: the contact starts open, with δ̇⁻ at its least value."""
    mechanism = assemble(table2(), Scenario(approach_speed=0.01, passive_rate=1.0))
    state, active = mechanism.start()
    assert float(mechanism.evaluate(state).elements[0].approach.approach_speed[LOWER]) < -0.1
    assert float(mechanism.memory(state)[LOWER]) == SLOWEST_TOUCHDOWN
    assert_allclose(active, [0.0, 0.0])


@each_tip
def test_probe_is_the_composite_of_rod_and_ball(free):
    """Mass, centre of mass and inertia by summing rod and ball about the composite's centre."""
    design = replace(table2(), {"probe.free_tip": free, "probe.tip_mass": 0.11})
    probe = assemble(design, Scenario()).parts.probe
    rod, ball, length, radius = design.probe.rod_mass, 0.11, 0.2, 0.015
    centre = (rod * 0.1 + ball * 0.2) / (rod + ball)
    inertia = rod * length**2 / 12 + rod * (centre - 0.1) ** 2 + ball * (0.2 - centre) ** 2
    own = 0.4 * ball * radius**2
    expected = [rod + ball, inertia + (0.0 if free else own), centre, 0.2 - centre, own]
    assert_allclose(probe[:5], expected, rtol=1e-14)
    assert_allclose(rod, 0.139449, rtol=4e-6)  # six digits are given
    assert_allclose(table2().probe.tip_mass, 0.038736, rtol=1.3e-5)  # five digits are given


def test_a_free_tips_spin_adds_its_own_angular_momentum():
    """2/5 m R² ω of a ball."""
    mechanism, state = start("table 2", True)[:2]
    tip, spin = mechanism.parts.design.probe, 3.0
    turned = state.at[2 * mechanism.coordinates].add(spin)
    more = mechanism.momentum(turned)[1] - mechanism.momentum(state)[1]
    assert_allclose(more, 0.4 * tip.tip_mass * tip.tip_radius**2 * spin, rtol=1e-9)


def test_a_free_start_has_no_first_contact_for_published_arms():
    """`contact_distance`, where such arms stay, means nothing at a free start: its default would decide."""
    published, free = replace(table2(), {"contact.arms": "published"}), Scenario(start="free")
    for call in (
        lambda: simulate(published, free),
        lambda: sweep(published, free, 8.0, over={"buffer.k_A": [300.0, 400.0]}),
        lambda: Problem(published, [free], []),
        lambda: sensitivity(published, free, wrt=("buffer.k_A",)),
    ):
        with pytest.raises(InputError, match=r'contact\.arms = "published".*use contact\.arms = "moving"'):
            call()
