"""Steps whose equations Newton's method solves wrongly say nothing of where an event is (hybrid/loop/decision.py)."""

import pytest

import jaxbuffer as jb

# A draw of a campaign. In free flight its implicit steps of about 0.15 s are solved wrongly at one length in ten or so,
# and where is a matter of rounding.
DESIGN = {
    "active.mass": 412.8,
    "active.inertia": 3.076,
    "passive.mass": 201.2,
    "passive.inertia": 914.2,
    "buffer.k_A": 126.4,
    "buffer.c_A": 0.5884,
    "buffer.k_T": 1549.0,
    "buffer.c_T": 0.2239,
    "buffer.cylinder_mass": 1.503,
    "buffer.max_stroke": 0.02406,
    "buffer.stop_stiffness": 7060.0,
    "buffer.stop_damping": 6.255,
    "buffer.c_A2": 125.4,
    "buffer.friction": 0.3094,
    "probe.rod_mass": 0.5286,
    "probe.tip_mass": 0.08773,
    "probe.bending_stiffness": 49.24,
    "probe.bending_damping": 1.367e-5,
    "cone.half_angle": 0.7597,
    "contact.law": "herbert-mcwhannell",
    "contact.restitution": 0.3682,
    "contact.friction": 0.3465,
    "contact.slip_speed": 1.817e-3,
    "latch.stiffness": 1270.0,
    "latch.damping": 58.86,
    "latch.turn_stiffness": 3.659,
    "latch.turn_damping": 11.4,
    "latch.closing_time": 7.849e-3,
    "lockout.stiffness": 5.01e4,
    "lockout.damping": 29.19,
    "shock.active_1": 34.17,
    "shock.passive_1": 247.9,
}
SCENARIO = jb.Scenario(
    approach_speed=0.02014221201998543,
    contact_distance=0.0435,
    misalignment=0.08621259880493545,
    passive_rate=0.018549280028783866,
    start="free",
    offset=-0.03603270228003077,
    standoff=1.5826092883665312e-4,
    active_angle=-0.018262116768719583,
    active_rate=-0.0012998303984268177,
    lateral_speed=-0.0028179071248114205,
)


@pytest.mark.slow
def test_a_touchdown_is_found_whatever_rounding_does_on_the_way():
    """Of 40 designs that differ by rounding, five began their impact deep in the cone, with up to 5 % of the energy."""
    for k in range(40):
        design = jb.replace(jb.table2(), DESIGN | {"buffer.k_A": DESIGN["buffer.k_A"] * (1.0 + 1e-13 * k)})
        assert abs(float(jb.simulate(design, SCENARIO, duration=2.0).balance.energy)) < 1e-6
