"""What a whole capture may not depend on, and what it may never do, over random designs and scenarios.

Each run is tight (rtol 1e-10), so that what is left is rounding and tolerance as grown over some ten impacts.
"""

import numpy as np
import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st

import jaxbuffer as jb
from properties.captures import TURNS, VECTORS, cases, difference, start_of, watch
from properties.units import in_units

# Without shrinking: a failing example is a capture like any other, and finding a simpler one takes minutes.
some = settings(max_examples=12, deadline=None, derandomize=True, phases=[Phase.explicit, Phase.generate])
TOPIC = "Invariants of whole captures"
SOURCE = "the same capture, unchanged"


def turned(values, angle):
    """Vectors of all bodies turned; a copy."""
    values = np.array(values)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    values[VECTORS] = values[VECTORS] @ turn.T
    return values


@some
@given(cases(), st.floats(-np.pi, np.pi), st.floats(-2, 2), st.floats(-2, 2))
def test_frame_may_be_turned_and_moved(evidence, case, angle, x, y):
    state, closed = start_of(*case)
    moved = np.array(state)
    moved[:12], moved[12:24] = turned(state[:12], angle), turned(state[12:24], angle)
    moved[VECTORS] += [x, y]
    moved[TURNS] += angle
    off = difference(watch(*case, (moved, closed)), watch(*case))
    evidence(TOPIC, "frame turned and moved: every impact, time and maximum is the same", off, 1e-5, SOURCE)


@some
@given(cases(), st.floats(-1, 1), st.floats(-1, 1))
def test_frame_may_travel(evidence, case, u, v):
    state, closed = start_of(*case)
    state[12 + VECTORS] += [u, v]
    off = difference(watch(*case, (state, closed)), watch(*case))
    evidence(TOPIC, "frame travelling at a constant velocity: the same", off, 1e-5, SOURCE)


@some
@given(cases())
def test_mirror_image_swaps_the_flanks(evidence, case):
    state, closed = start_of(*case)
    odd = [k + offset for offset in (0, 12) for body in range(4) for k in (3 * body + 1, 3 * body + 2)]
    state[odd] *= -1.0
    state[-2:] = state[:-3:-1]
    off = difference(watch(*case, (state, closed[::-1])), watch(*case), swapped=True)
    evidence(TOPIC, "mirror image: the flanks swap, all else is the same", off, 1e-5, SOURCE)


SOFT = {"k_A": 200.0, "c_A": 3.004, "k_T": 100.0, "c_T": 7.897788711769318}
AT_REST = (
    jb.replace(
        jb.table2(),
        {f"buffer.{name}": value for name, value in SOFT.items()}
        | {"contact.restitution": 0.7381137044573383, "contact.friction": 0.0, "probe.tip_mass": 0.02},
    ),
    jb.Scenario(approach_speed=0.06, contact_distance=0.036638144011066937),
)

NOISY = (  # nearly lossless and slow: a later start once stood still in free flight, where forces are mere rounding
    jb.replace(
        jb.table2(),
        {
            **{"buffer.k_A": 543.6563656918088, "buffer.c_A": 2.0, "buffer.k_T": 229.76245420179066, "buffer.c_T": 1.0},
            **{"probe.tip_mass": 0.03856924208151567, "contact.restitution": 0.99999},
            "contact.friction": 0.1441524111311495,
        },
    ),
    jb.Scenario(0.16829595965963529, 0.0360745373957578, 0.006443217191555162),
)


@some
@given(cases(), st.floats(0.02, 0.06))
@example(NOISY, 0.02845160926613985)
@example(AT_REST, 0.04)  # where maxima of mere rounding once cost the touchdown
def test_a_later_start_shifts_every_time(evidence, case, delay):
    """The vehicles start apart and meet as the scenario says, ``delay`` later: a touchdown that must be located."""
    _, scenario = case
    state, _ = start_of(*case)
    state[0:9:3] -= scenario.approach_speed * delay
    state[11] -= scenario.passive_rate * delay
    state[-2:] = 1.0
    off = difference(watch(*case, (state, np.zeros(2)), duration=8.0 + delay), watch(*case), delay=delay)
    evidence(TOPIC, "start moved back in time, out of contact: every time shifts by as much", off, 1e-5, SOURCE)


@some
@given(cases(), st.floats(0.2, 5.0), st.floats(0.2, 5.0), st.floats(0.2, 5.0))
def test_units_may_be_changed(evidence, case, length, mass, time):
    """Every number is turned by the unit its field declares, so a wrong declaration fails as well."""
    scales = (length, mass, time)
    design, scenario = (in_units(module, scales) for module in case)
    seen = watch(design, scenario, duration=8.0 * time, stabilisation=20.0 / time)
    off = difference(seen, watch(*case), units=(time, mass * length / time**2, length))
    evidence(TOPIC, "other units of length, mass and time: the whole capture scales", off, 1e-5, SOURCE)


@pytest.mark.parametrize("free_tip", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_what_a_capture_never_does(evidence, free_tip):
    @settings(some, max_examples=25)
    @given(cases(free_tip=free_tip))
    def over(case):
        never(evidence, case)

    over()


def never(evidence, case):
    """At every accepted step of one capture."""
    design, scenario = case
    seen = watch(*case)
    steps, energy = seen.steps, seen.steps.energy
    first = float(energy.total[0])
    law, source = "Laws at every step", "the law itself, at every accepted step of random captures"
    mechanical = energy.kinetic + energy.spring + energy.contact
    growth = np.max(np.diff(mechanical), initial=0.0) / first
    evidence(law, "mechanical energy never grows, relative to the first", growth, 1e-12, source)
    losses = np.stack([energy.axial_damper, energy.torsional_damper, energy.hysteresis, energy.friction])
    gain = max(0.0, -float(np.min(np.diff(losses, axis=1)))) / first
    evidence(law, "no damper, contact or friction gives energy back, relative to the first", gain, 1e-12, source)
    drift = np.max(np.abs(energy.total / first - 1.0))
    evidence(law, "what is stored and what is lost add up to the first energy", drift, 1e-8, source)
    evidence(law, "linear momentum stays, relative to m_S v0", seen.balance.linear_momentum, 1e-11, source)
    evidence(law, "angular momentum stays, relative to m_S v0 · 1 m", seen.balance.angular_momentum, 1e-10, source)
    tension = max(0.0, -float(np.min(steps.contact_force)))
    evidence(law, "surfaces never pull", tension, 0.0, source, "N")
    apart = np.max(np.where(steps.gap > 0.0, steps.contact_force, 0.0))
    evidence(law, "no force across a gap", apart, 0.0, source, "N")
    wrong_way = np.max(steps.friction_force * steps.slip, initial=0.0)
    evidence(law, "friction opposes slip", wrong_way, 0.0, source, "W")
    cone = np.max(np.abs(steps.friction_force) - design.contact.friction * steps.contact_force, initial=0.0)
    evidence(law, "friction stays within Coulomb's cone", cone, 1e-12, source, "N")
    depth = -float(np.min(steps.gap))
    available = 0.5 * reduced_mass(design) * scenario.approach_speed**2
    available += 0.5 * design.passive.inertia * scenario.passive_rate**2
    bound = (2.5 * available / float(design.contact_stiffness)) ** 0.4
    evidence(law, "penetration over what the energy of approach can cause", depth / bound, 1.0, source)


def reduced_mass(design):
    """Of everything that approaches and everything that waits: what of the kinetic energy a collision can take [kg]."""
    moving = design.active.mass + design.buffer.cylinder_mass + design.probe.rod_mass + design.probe.tip_mass
    return moving * design.passive.mass / (moving + design.passive.mass)
