"""Timoshenko's ball on a simply supported beam, through the project's own bodies, contacts and time stepping.

The contact's force goes into the beam's modes at its marker. The number of modes stands beside every peak.
"""

import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.contact import BallPair, LankaraniNikravesh, RegularisedCoulomb, Segment
from jaxbuffer.hybrid import Kind
from jaxbuffer.mechanisms.assembled import Assembled, BallContact
from jaxbuffer.multibody import GROUND, Body, FlexibleBody, PointOnLine, Revolute, System
from jaxbuffer.multibody.flexible import Bar, plate_strip
from multibody.test_struck import CASES, Struck
from verification.riding import ride

TOPIC = "Struck plates and beams"
SPEED = 0.01  # m/s
UNTIL = {"A": 0.6e-3, "B": 3.4e-3}  # s
each_case = pytest.mark.parametrize("case", CASES)


def struck(case, count):
    """Beam in its first odd modes, the ball's mass [kg] and the stiffness of the contact [N/m^1.5]."""
    length, radius, *_ = CASES[case]
    beam = plate_strip(Bar.rectangle(length, 0.01, 0.01, 7960.0, 2.16e11), tuple(range(1, 2 * count, 2)))
    return beam, radius, 7960.0 * 4.0 / 3.0 * np.pi * radius**3, 4.0 / 3.0 * (2.16e11 / 0.91 / 2.0) * np.sqrt(radius)


def ball_on_beam(case, count) -> Assembled:
    beam, radius, mass, stiffness = struck(case, count)
    bodies = (Body(mass, 0.4 * mass * radius**2), FlexibleBody(beam.modes))
    span = float(beam.end.x)
    supports = (Revolute(GROUND, 1, (-span, 0.0), beam.start), PointOnLine(GROUND, 1, (0.0, 0.0), beam.end))
    system = System(bodies, supports)
    surface = Segment(-1.0, 0.0, 1.0, 0.0, 2.0)
    pair = BallPair(radius, surface, -1.0, LankaraniNikravesh(stiffness, 1.0), RegularisedCoulomb(0.0, 1e-3))
    q = jnp.zeros(system.coordinates).at[1].set(radius)
    v = jnp.zeros(system.coordinates).at[1].set(-SPEED)
    return Assembled(system, q, v, (BallContact(0, 1, pair, carrier_point=beam.middle),), (True,), size=(1e-6, SPEED))


def contacts(run):
    """Start, end, peak and time of the peak of each contact [s, s, N, s], and the state after the last."""
    starts, ends = run.times(Kind.TOUCHDOWN), run.times(Kind.RELEASE)
    peaks = run.kind == Kind.PEAK
    found = []
    for start, end in zip(starts, ends, strict=True):
        inside = peaks & (run.time > start) & (run.time < end)
        best = np.argmax(np.where(inside, run.force[:, 0], -1.0))
        found.append((start, end, run.force[best, 0], run.time[best]))
    return found, run.v[1]


def by_scipy(case, count):
    """The same by the modes alone, integrated by SciPy."""
    beam, _, mass, stiffness = struck(case, count)
    shapes = np.asarray(beam.middle.displacement_y) / np.sqrt(beam.bar.mass)
    ball = Struck(mass, stiffness, 2.0 * np.pi * np.asarray(beam.modes.frequencies()), shapes)
    time, state, found = 0.0, ball.start(SPEED), []
    for _ in CASES[case][2]:
        contact = ball.contact(time, state, rtol=1e-11)
        found.append((contact.start, contact.end, contact.peak, contact.peak_time))
        touchdown = ball.next_touchdown(contact.state, 3e-3)
        if touchdown is None:
            break
        time, state = contact.end + touchdown[0], touchdown[1]
    return found, -contact.state[1 + shapes.size]


@each_case
def test_a_ball_on_a_beam_of_eight_modes(case, evidence):
    """Our loop against SciPy with the same modes; the peaks of all contacts, with 8 odd modes."""
    found, after = contacts(ride(ball_on_beam(case, 8), UNTIL[case]))
    expected, speed = by_scipy(case, 8)
    assert len(found) == len(expected) == len(CASES[case][2])
    for ours, theirs in zip(found, expected, strict=True):
        told = f"case {case}: {ours[2]:.5f} N"
        claim = "ball on a beam in the loop, 8 modes, peaks, relative"
        evidence(TOPIC, claim, abs(ours[2] / theirs[2] - 1.0), 1e-8, "SciPy with the same modes", detail=told)
        times = max(abs(a - b) for a, b in zip((*ours[:2], ours[3]), (*theirs[:2], theirs[3]), strict=True))
        claim = "ball on a beam in the loop, 8 modes, times"
        evidence(TOPIC, claim, 1e6 * times, 1e-4, "SciPy with the same modes", "µs", told)
    claim = "ball on a beam in the loop, 8 modes, speed after, relative"
    evidence(TOPIC, claim, abs(after / speed - 1.0), 1e-8, "SciPy with the same modes", detail=f"case {case}")


@pytest.mark.slow
@pytest.mark.long
@each_case
def test_a_ball_on_a_beam_as_computed_independently(case, evidence):
    """With the 40 odd modes of the table."""
    found, after = contacts(ride(ball_on_beam(case, 40), UNTIL[case]))
    printed, _, speed = CASES[case][2:]
    source = "an independent program (SciPy)"
    for ours, (start, end, peak, when) in zip(found, printed, strict=True):
        told = f"case {case}: {ours[2]:.5f} N"
        ends = max(abs(1e6 * ours[0] - start), abs(1e6 * ours[1] - end))
        evidence(TOPIC, "ball on a beam in the loop, 40 modes, peaks", abs(ours[2] - peak), 5e-5, source, "N", told)
        evidence(TOPIC, "ball on a beam in the loop, 40 modes, start and end", ends, 0.025, source, "µs", told)
        evidence(
            TOPIC,
            "ball on a beam in the loop, 40 modes, time of peaks",
            abs(1e6 * ours[3] - when),
            0.1,
            source,
            "µs",
            told,
        )
    claim = "ball on a beam in the loop, 40 modes, speed after"
    evidence(TOPIC, claim, abs(-1e3 * after - speed), 5e-4, source, "mm/s", f"case {case}")
