"""The start in space: on the joints, the tip where the scenario puts it."""

import jax.numpy as jnp
import numpy as np
import pytest

from docking3d.reference import CASES
from jaxbuffer import InputError, Scenario, Scenario3D, docking3d, replace, simulate, table2
from jaxbuffer.mechanisms.docking3d.bodies import assemble_system
from jaxbuffer.mechanisms.docking3d.design import valid
from jaxbuffer.mechanisms.docking3d.start import start_motion
from jaxbuffer.mechanisms.probe_cone import bodies, start
from jaxbuffer.mechanisms.probe_cone.bodies import B, P, S, T, probe_masses

PLANAR_START = {"start": "free", "offset": -0.02, "active_angle": 0.03, "active_rate": -0.02, "lateral_speed": 0.004}
ANGLES = ("passive_yaw", "passive_pitch", "active_yaw", "active_pitch")
SAME_IN_SPACE = {
    "start": "free",
    "offset_y": -0.02,
    "active_yaw": 0.03,
    "active_rate_z": -0.02,
    "lateral_speed_y": 0.004,
}


def begun(design, scenario):
    """The system and its kinematics at t = 0."""
    masses = probe_masses(design)
    system = assemble_system(design, masses, 20.0)
    return system, system.kinematics(*start_motion(design, scenario, masses)), masses


def rotation(yaw, pitch):
    """The matrix of a yaw after a pitch."""
    cz, sz, cy, sy = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch)
    return np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]]) @ np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])


@pytest.mark.parametrize("name", CASES)
def test_joints_hold_and_the_tip_is_where_the_scenario_puts_it(name):
    design, scenario = CASES[name].design, CASES[name].scenario
    system, kin, masses = begun(design, scenario)
    constraints = system.constraints(kin)
    assert jnp.max(jnp.abs(constraints.phi)) < 1e-15
    assert jnp.max(jnp.abs(constraints.jacobian @ kin.v)) < 1e-15
    tip = np.array(kin.point(P, masses.tip_centre).place, float)
    x, y, z = rotation(float(scenario.passive_yaw), float(scenario.passive_pitch)).T @ tip
    cone, radius = design.cone, design.probe.tip_radius
    cos, sin = np.cos(cone.half_angle), np.sin(cone.half_angle)
    if scenario.start == "free":
        mouth = -cone.offset - cone.length * cos
        assert (x, y, z) == pytest.approx((mouth - radius - scenario.standoff, scenario.offset_y, scenario.offset_z))
        return
    # The distance from the flank's line in the half plane of the tip, and how far along it the foot is.
    off_x, off_rho = x + cone.offset, np.hypot(y, z) - cone.throat_radius
    assert off_rho * cos + off_x * sin == pytest.approx(-radius, abs=1e-15)
    assert off_rho * sin - off_x * cos == pytest.approx(scenario.contact_distance)
    azimuth = scenario.azimuth - np.pi / 2
    assert (y, z) == pytest.approx((np.hypot(y, z) * np.sin(azimuth), np.hypot(y, z) * np.cos(azimuth)), abs=1e-15)


def test_a_probe_points_towards_the_cone_up_to_a_quarter_turn():
    for angles in np.random.default_rng(1).uniform(-1.5, 1.5, (50, 4)):
        scenario = Scenario3D(start="free", **dict(zip(ANGLES, angles, strict=True)))
        along = rotation(*angles[:2])[:, 0] @ rotation(*angles[2:])[:, 0]
        assert float(scenario.towards(np)) == pytest.approx(along, abs=1e-14)
        assert bool(valid(docking3d(), scenario)) == (along > 0.0)


def test_active_side_turns_as_one_body():
    case = CASES["free start, all rates"]
    _, kin, _ = begun(case.design, case.scenario)
    frames = [kin.frame(body) for body in (S, B, P)]
    spin = np.array([case.scenario.active_rate_x, case.scenario.active_rate_y, case.scenario.active_rate_z])
    axis = rotation(case.scenario.active_yaw, case.scenario.active_pitch)[:, 0]
    for frame in frames:
        assert np.array(frame.spin, float) == pytest.approx(spin)
        assert np.array(frame.axes[0], float) == pytest.approx(axis)
        off = np.array(frame.origin, float) - np.array(frames[0].origin, float)
        assert off == pytest.approx(np.linalg.norm(off) * axis)
        moves = np.array(frame.velocity, float) - np.array(frames[0].velocity, float)
        assert moves == pytest.approx(np.cross(spin, off), abs=1e-17)


@pytest.mark.parametrize(
    ("planar", "spatial"),
    [
        ({"misalignment": 0.05, "passive_rate": 0.01}, {"passive_yaw": 0.05, "passive_rate_z": 0.01}),
        (PLANAR_START, SAME_IN_SPACE),
    ],
    ids=["contact", "free"],
)
def test_a_start_in_the_plane_is_the_plane_s(planar, spatial):
    design = docking3d()
    masses = probe_masses(table2())
    system = bodies.assemble_system(table2(), masses, 20.0)
    flat = system.kinematics(*start.start_motion(table2(), Scenario(**planar), masses))
    _, kin, _ = begun(design, Scenario3D(**spatial))
    for body in (S, B, P, T):
        one, other = kin.frame(body), flat.frame(body)
        assert [float(x) for x in one.origin] == pytest.approx([*map(float, other.origin), 0.0], abs=1e-15)
        assert [float(x) for x in one.velocity] == pytest.approx([*map(float, other.velocity), 0.0], abs=1e-15)
        assert [float(x) for x in one.spin] == pytest.approx([0.0, 0.0, float(other.spin)], abs=1e-15)
        assert [float(x) for x in one.axes[0]] == pytest.approx([float(other.cos), float(other.sin), 0.0], abs=1e-15)


@pytest.mark.parametrize(
    ("design", "scenario", "words"),
    [
        ({"active.roll_inertia": 0.9}, {}, "no body has more than twice its active.inertia"),
        ({"contact.arms": "published"}, {}, "is of the plane"),
        ({}, {"passive_yaw": 0.6, "passive_pitch": 0.6}, "the tip must face the flank"),
        (
            {},
            {"start": "free", "passive_yaw": 1.0, "active_yaw": -1.0, "active_pitch": 0.0},
            r"active_pitch = 0 rad turn the probe by 2 rad from the cone's axis; allowed: \[0, 1.5708\) rad",
        ),
        ({}, {"offset_z": 0.01}, 'belongs to scenario.start = "free"'),
        ({}, {"start": "free", "azimuth": 0.1}, 'belongs to scenario.start = "contact"'),
        ({}, {"contact_distance": 0.08}, "the flank ends at cone.length"),
    ],
)
def test_what_cannot_be_is_refused(design, scenario, words):
    with pytest.raises(InputError, match=words):
        simulate(replace(docking3d(), design), Scenario3D(**scenario))
