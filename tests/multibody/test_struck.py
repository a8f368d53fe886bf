"""A ball on a plate and on a beam: the modes, in studies that need no multibody code.

SciPy's DOP853 integrates ball and modes; contacts start and end at its located events.
"""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from jaxbuffer.multibody.flexible import Bar, RectangularPlate, plate_strip

TOPIC = "Struck plates and beams"
INDEPENDENT = "an independent program (SciPy)"
ZENER = {  # λ: e, F_max T/(m v0), duration/T
    0.05: (0.917772, 1.086603, 3.247087),
    0.1: (0.843339, 1.035546, 3.278495),
    0.2: (0.714045, 0.945715, 3.348658),
    0.3: (0.605947, 0.870536, 3.429108),
    0.4: (0.514639, 0.806020, 3.520670),
    0.5: (0.436895, 0.750222, 3.624441),
    0.75: (0.287390, 0.639033, 3.947241),
    1.0: (0.184123, 0.556021, 4.387612),
    1.5: (0.066404, 0.440830, 5.836250),
    2.0: (0.020683, 0.364643, 8.483224),
    3.0: (0.002795, 0.270309, 16.934),
}


class Contact(NamedTuple):
    """Of a contact: start, end and time of the peak [s], peak [N], and the state at its end."""

    start: float
    end: float
    peak_time: float
    peak: float
    state: np.ndarray


class Struck(NamedTuple):
    """A ball and the modes that it strikes: mass [kg], Hertz's stiffness [N/m^1.5], circular frequencies [rad/s] and
    mass-normalised shapes [1/√kg] under the ball. The state is ball, modes, their velocities."""

    mass: float
    stiffness: float
    frequencies: np.ndarray
    shapes: np.ndarray

    def start(self, speed):
        state = np.zeros(2 * (1 + self.shapes.size))
        state[1 + self.shapes.size] = speed
        return state

    def force(self, state):
        return self.stiffness * max(self.penetration(state), 0.0) ** 1.5

    def penetration(self, state):
        return state[0] - self.shapes @ state[1 : 1 + self.shapes.size]

    def rate(self, time, state):
        moved, moving = np.split(state, 2)
        force = self.force(state)
        accelerations = self.shapes * force - self.frequencies**2 * moved[1:]
        return np.concatenate([moving, [-force / self.mass], accelerations])

    def contact(self, start, state, rtol=1e-9):
        """One contact from a touchdown on."""

        def release(time, state):
            return self.penetration(state) if time > start else 1.0

        def peak(time, state):
            return state[1 + self.shapes.size] - self.shapes @ state[2 + self.shapes.size :]

        release.terminal, release.direction, peak.direction = True, -1, -1
        scale = np.abs(state[1 + self.shapes.size]) * 1e-6
        sizes = np.concatenate([[1.0], np.sqrt(self.mass) * np.ones(self.shapes.size)])
        atol = rtol * scale * np.concatenate([sizes, sizes * 1e5])
        done = solve_ivp(self.rate, (start, start + 1.0), state, "DOP853", events=[release, peak], rtol=rtol, atol=atol)
        forces = [self.force(y) for y in done.y_events[1]]
        best = int(np.argmax(forces))
        return Contact(start, done.t[-1], done.t_events[1][best], forces[best], done.y[:, -1])

    def flight(self, state, times):
        """States at times after a release, exactly."""
        moved, moving = np.split(state, 2)
        ball = moved[0] + moving[0] * times
        phase = self.frequencies[:, None] * times[None, :]
        modes = moved[1:, None] * np.cos(phase) + (moving[1:] / self.frequencies)[:, None] * np.sin(phase)
        rates = moving[1:, None] * np.cos(phase) - (moved[1:] * self.frequencies)[:, None] * np.sin(phase)
        return np.concatenate([ball[None, :], modes, np.full_like(times, moving[0])[None, :], rates])

    def deflection(self, state):
        return self.shapes @ state[1 : 1 + self.shapes.size]

    def largest_deflection(self, contact):
        """Under the ball within 2 ms after a contact, and when."""

        def rate(time):
            return self.shapes @ self.flight(contact.state, np.array([time]))[2 + self.shapes.size :, 0]

        times = np.linspace(0.0, 2e-3, 4001)
        sizes = self.shapes @ self.flight(contact.state, times)[1 : 1 + self.shapes.size]
        best = int(np.argmax(sizes[1:-1])) + 1
        after = brentq(rate, times[best - 1], times[best + 1]) if sizes[best] > sizes[best - 1] else times[best]
        return self.deflection(self.flight(contact.state, np.array([after]))[:, 0]), contact.end + after

    def next_touchdown(self, state, until):
        """Time from a release until the next touchdown, and the state there; None if there is none so soon."""
        times = np.linspace(0.0, until, 40001)[1:]
        open_gap = -np.array([self.penetration(y) for y in self.flight(state, times).T])
        closing = np.flatnonzero((open_gap[:-1] > 0.0) & (open_gap[1:] <= 0.0))
        if not closing.size:
            return None
        first = closing[0]
        after = brentq(lambda t: self.penetration(self.flight(state, np.array([t]))[:, 0]), *times[first : first + 2])
        return after, self.flight(state, np.array([after]))[:, 0]


@pytest.mark.parametrize("loss", ZENER)
def test_zeners_infinite_plate(loss, evidence):
    """σ'' + (1 + λ d/dτ) σ^1.5 = 0: the ball on a plate whose speed is its mobility times the force.

    The table's peaks are the largest of samples: up to 3.5e-4 below the located ones here, never above. Those are
    checked by the phase plane, v dv/dσ = -σ^1.5 - 1.5 λ √σ v, which is integrated from touchdown to where v = 0.
    """

    def rate(time, state):
        depth = max(state[0], 0.0)
        return [state[1], -(depth**1.5) - 1.5 * loss * np.sqrt(depth) * state[1], depth**1.5]

    def peak(time, state):
        return state[1]

    def release(time, state):
        return state[0] if time > 0.1 else 1.0

    release.terminal, release.direction, peak.direction = True, -1, -1
    done = solve_ivp(rate, (0.0, 50.0), [0.0, 1.0, 0.0], "DOP853", events=[release, peak], rtol=1e-11, atol=1e-13)
    restitution, found, duration = ZENER[loss]
    digit = 5e-4 if loss == 3.0 else 1e-6  # to which the duration is printed
    largest = done.y_events[1][0][0] ** 1.5
    told = f"λ = {loss}"
    evidence(TOPIC, "infinite plate, e", abs(done.y[2, -1] - 1.0 - restitution), 1e-6, INDEPENDENT, detail=told)
    evidence(TOPIC, "infinite plate, duration/T", abs(done.t[-1] - duration), digit, INDEPENDENT, detail=told)
    evidence(TOPIC, "infinite plate, sampled peak below ours", largest - found + 5e-7, 4e-4, INDEPENDENT, detail=told)
    evidence(TOPIC, "infinite plate, located peak", abs(largest / _phase_plane(loss) - 1.0), 1e-8, "the phase plane")


def _phase_plane(loss):
    """The largest σ^1.5, with the speed v as the variable: dσ/dv = -v/(σ^1.5 + 1.5 λ √σ v) from v = 1 to 0; the first
    piece, where that is singular, over σ."""
    begun = solve_ivp(
        lambda depth, v: -(depth**1.5) / v - 1.5 * loss * np.sqrt(depth),
        (0.0, 0.1),
        [1.0],
        "Radau",
        rtol=1e-11,
        atol=1e-13,
    )
    rest = solve_ivp(
        lambda v, depth: -v / (depth**1.5 + 1.5 * loss * np.sqrt(depth) * v),
        (begun.y[0, -1], 0.0),
        [0.1],
        "DOP853",
        rtol=1e-12,
        atol=1e-14,
    )
    return rest.y[0, -1] ** 1.5


def ball_on_plate(waves):
    """A steel ball of 5 mm radius over the middle of a steel plate 0.6 × 0.6 m, 5 mm thick."""
    plate = RectangularPlate(0.6, 0.6, 0.005, 7800.0, 2.1e11, 0.3)
    mass = 7800.0 * 4.0 / 3.0 * np.pi * 0.005**3
    stiffness = 4.0 / 3.0 * (2.1e11 / 0.91 / 2.0) * np.sqrt(0.005)
    frequencies = 2.0 * np.pi * np.asarray(plate.frequencies(waves)).ravel()
    return plate, Struck(mass, stiffness, frequencies, np.asarray(plate.shapes(0.3, 0.3, waves)).ravel())


def test_the_plates_mobility_gives_zeners_parameter(evidence):
    plate, ball = ball_on_plate((1,))
    time = (ball.mass / ball.stiffness) ** 0.4
    loss = float(plate.mobility) * ball.mass / time
    evidence(TOPIC, "λ of the worked case", abs(loss - 0.155671449), 1e-9, INDEPENDENT)


@pytest.mark.parametrize(("count", "restitution", "peak"), [(50, 0.76794, 375.99), (100, 0.76830, 375.35)])
def test_a_modal_plate_tends_to_zeners(count, restitution, peak, evidence):
    """Before the first wave returns from the edges. 50² and 100² odd modes; the infinite plate: 0.768427, 375.03 N."""
    _, ball = ball_on_plate(tuple(range(1, 2 * count, 2)))
    contact = ball.contact(0.0, ball.start(1.0), rtol=1e-8)
    found = -contact.state[1 + ball.shapes.size]
    evidence(TOPIC, f"modal plate, restitution with {count}² odd modes", abs(found - restitution), 1e-5, INDEPENDENT)
    evidence(TOPIC, f"modal plate, peak with {count}² odd modes", abs(contact.peak - peak), 0.01, INDEPENDENT, "N")


def timoshenko(length, radius):
    """Timoshenko's ball and beam, 1 × 1 cm of steel on simple supports, struck at mid-span; 40 odd modes."""
    odd = tuple(range(1, 80, 2))
    beam = plate_strip(Bar.rectangle(length, 0.01, 0.01, 7960.0, 2.16e11), odd)
    shapes = np.asarray(beam.middle.displacement_y) / np.sqrt(beam.bar.mass)
    stiffness = 4.0 / 3.0 * (2.16e11 / 0.91 / 2.0) * np.sqrt(radius)
    omega = 2.0 * np.pi * np.asarray(beam.modes.frequencies())
    return beam, Struck(7960.0 * 4.0 / 3.0 * np.pi * radius**3, stiffness, omega, shapes)


@pytest.mark.parametrize(
    ("length", "radius", "period", "ratio"), [(0.1535, 0.01, 997.51, 0.27289), (0.307, 0.02, 3990.04, 1.09154)]
)
def test_timoshenkos_beams(length, radius, period, ratio, evidence):
    beam, ball = timoshenko(length, radius)
    measured = abs(1e6 / float(beam.modes.frequencies()[0]) - period)
    evidence(TOPIC, "period of Timoshenko's beams", measured, 0.005, INDEPENDENT, "µs")
    evidence(TOPIC, "mass ratio of Timoshenko's beams", abs(ball.mass / beam.bar.mass - ratio), 5e-6, INDEPENDENT)


CASES = {  # length, radius; start, end, peak force, its time, of each contact; deflection, its time; speed after
    "A": (0.1535, 0.01, [(0.0, 156.32, 4.9796, 72.52)], (1.124096, 323.6), -3.023),
    "B": (
        0.307,
        0.02,
        [(0.0, 434.29, 9.0126, 91.25), (1336.04, 1781.04, 10.3053, 1626.67), (2796.78, 3219.89, 5.6069, 2880.4)],
        (8.70397, 2118.8),
        -9.712,
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_timoshenkos_ball_on_a_beam(case, evidence):
    """With 40 odd modes. The table's times are those of samples: ends of contacts lie up to 0.02 µs before ours, and
    flat maxima up to a tenth beside them; forces, deflections and speeds have all their digits."""
    length, radius, printed, (deflection, when), after = CASES[case]
    _, ball = timoshenko(length, radius)
    time, state, largest = 0.0, ball.start(0.01), (0.0, 0.0)
    for start, end, peak, peak_time in printed:
        contact = ball.contact(time, state)
        ends = max(abs(1e6 * contact.start - start), abs(1e6 * contact.end - end))
        maximum = abs(1e6 * contact.peak_time - peak_time)
        evidence(TOPIC, "ball on a beam, peak force", abs(contact.peak - peak), 5e-5, INDEPENDENT, "N", f"case {case}")
        evidence(TOPIC, "ball on a beam, start and end of contacts", ends, 0.025, INDEPENDENT, "µs", f"case {case}")
        evidence(TOPIC, "ball on a beam, time of peaks", maximum, 0.1, INDEPENDENT, "µs", f"case {case}")
        largest = max(largest, ball.largest_deflection(contact))
        touchdown = ball.next_touchdown(contact.state, 3e-3)
        if touchdown is None:
            break
        time, state = contact.end + touchdown[0], touchdown[1]
    assert contact.start * 1e6 == pytest.approx(printed[-1][0], abs=0.05) and touchdown is None
    speed = 1e3 * contact.state[1 + ball.shapes.size]
    evidence(TOPIC, "ball on a beam, speed of the ball after", abs(speed - after), 5e-4, INDEPENDENT, "mm/s")
    evidence(TOPIC, "ball on a beam, deflection", abs(1e6 * largest[0] - deflection), 5e-6, INDEPENDENT, "µm")
    evidence(
        TOPIC, "ball on a beam, time of the largest deflection", abs(1e6 * largest[1] - when), 0.1, INDEPENDENT, "µs"
    )
