"""The bouncing elastic bar of Doyen, Ern and Piperno: exact and periodic, with two phases of contact."""

import numpy as np
import pytest
from bars import Bar, follow, system

from jaxbuffer.structures.contact import METHODS, NodeContact, RigidPlane

TOPIC = "Finite elements, liquid and contact"
LENGTH, YOUNG, DENSITY, GRAVITY, HEIGHT = 10.0, 900.0, 1.0, 10.0, 5.0
WAVE = 30.0  # m/s
CROSSING, PERIOD = LENGTH / WAVE, 16.0 * LENGTH / WAVE
TABLE = {  # time: displacement of the lower end, the middle, the upper end
    0.5: (3.75, 3.75, 3.75),
    1.0: (0.0, 0.0, 0.0),
    1.2: (0.0, -1.861111, -2.2),
    4.0 / 3.0: (0.0, -2.083333, -3.888889),
    1.5: (0.0, -2.361111, -2.638889),
    5.0 / 3.0: (0.0, -0.833333, -1.111111),
    2.0: (1.666667, 1.944444, 2.777778),
    8.0 / 3.0: (3.888889, 4.166667, 5.0),
    3.0: (4.444444, 3.611111, 3.333333),
    11.0 / 3.0: (0.0, -0.833333, -1.111111),
    4.0: (0.0, -2.083333, -3.888889),
    13.0 / 3.0: (0.0, 0.0, 0.0),
    5.0: (4.444444, 4.444444, 4.444444),
}


def exact(x, time):
    """Displacements at distances x from the lower end (NLstep, bouncing-bar example, (28) to (31)): fall, contact and
    flight; the second half of a period is the first run backwards. The sums are Bernoulli polynomials."""
    time = time % PERIOD
    time = min(time, PERIOD - time)
    if time <= 1.0:
        return HEIGHT - 0.5 * GRAVITY * time**2 + 0.0 * x
    if time <= 5.0 / 3.0:
        since = time - 1.0
        wave = -10.0 * np.minimum(x / WAVE, CROSSING - abs(since - CROSSING))
        n = (np.arange(1, 40001) - 0.5) * np.pi / LENGTH
        terms = -2.0 * GRAVITY / (WAVE**2 * LENGTH * n**3) * (1.0 - np.cos(WAVE * n * since))
        return wave + np.sin(np.outer(x, n)) @ terms
    since = time - 5.0 / 3.0

    def cosines(distance):
        """Σ cos(λ_n d)/n²."""
        angle = (np.pi * distance / LENGTH) % (2.0 * np.pi)
        return np.pi**2 / 6.0 - np.pi * angle / 2.0 + angle**2 / 4.0

    swing = 0.5 * (cosines(x + WAVE * since) + cosines(x - WAVE * since))
    flight = HEIGHT - 0.5 * GRAVITY * (time - 8.0 / 3.0) ** 2
    return (
        flight - 2.0 * GRAVITY * LENGTH**2 / (3.0 * WAVE**2) + 4.0 * GRAVITY * LENGTH**2 / (WAVE * np.pi) ** 2 * swing
    )


def bounced(elements, method, periods=2.0, courant=1.0, stiffness=0.0, averaged=True):
    floor = NodeContact(np.array([0]), RigidPlane(elements + 1, (0.0, 1.0)), method, stiffness, averaged=averaged)
    bar = system(
        [Bar(HEIGHT, HEIGHT + LENGTH)],
        elements,
        young=YOUNG,
        density=DENSITY,
        gravity=GRAVITY,
        contacts=[floor],
        points=[(0.0, 0.0)],
    )
    step = courant * LENGTH / elements / WAVE
    upwards = 0.5 * GRAVITY * step  # half a step before the start
    seen = follow(bar, np.append(np.full(elements + 1, upwards), 0.0), step, round(periods * PERIOD / step) + 1)
    return bar, step, seen


def test_the_exact_solution_has_the_published_displacements():
    for time, ends in TABLE.items():
        np.testing.assert_allclose(exact(np.array([0.0, 5.0, 10.0]), time), ends, atol=6e-7)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["multiplier", "defence node"])
@pytest.mark.parametrize("elements", [20, 60])
def test_nodes_move_exactly_at_a_courant_number_of_one(elements, method, evidence):
    """Over two periods, four contacts."""
    bar, step, seen = bounced(elements, method)
    assert float(bar.stable_step()) == pytest.approx(step, rel=1e-12)
    x = np.linspace(0.0, LENGTH, elements + 1)
    moved = HEIGHT + seen.displacement[:, :-1]
    off = max(np.max(np.abs(moved[k] - exact(x, k * step))) for k in range(0, len(moved), 7))
    evidence(TOPIC, "bouncing bar, two periods at a Courant number of one", off, 1e-8, "exact solution", "m")


def test_the_contact_force_rises_in_the_first_contact_and_falls_in_the_second():
    """ρ c v + ρ g c (t - t1), from 300 to 500 N, and its mirror image; impulse 800/3 N s each."""
    _, step, seen = bounced(60, "multiplier", periods=1.0)
    time, force = step * np.arange(len(seen.force)), seen.force[:, 0]
    first, second = (
        (time > 1.0 + step) & (time < 5.0 / 3.0 - step),
        (time > 11.0 / 3.0 + step) & (time < 13.0 / 3.0 - step),
    )
    np.testing.assert_allclose(force[first], 300.0 + 300.0 * (time[first] - 1.0), atol=1e-6)
    np.testing.assert_allclose(force[second], 500.0 - 300.0 * (time[second] - 11.0 / 3.0), atol=1e-6)
    for part in (time < 2.5, time > 2.5):
        assert step * force[part].sum() == pytest.approx(800.0 / 3.0, rel=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_energy_is_kept_to_rounding(method):
    """Also while the floor takes a part of it, in the first step of a contact, or for the penalty's depth."""
    _, _, seen = bounced(60, method, periods=1.0, courant=0.6, stiffness=2.0 * YOUNG / LENGTH * 60)
    kinetic, stored, _, contact, _, potential, *_ = seen.energies.T
    work = GRAVITY * LENGTH * DENSITY * HEIGHT
    assert np.abs(contact).max() > 1e-3 * work and stored.max() > 0.1 * work
    np.testing.assert_allclose(kinetic + stored + contact + potential, kinetic[0] + potential[0], atol=1e-11 * work)


def test_energy_comes_back_after_a_period():
    _, _, seen = bounced(60, "multiplier", periods=1.0)
    moving = seen.energies[:, [0, 1, 5]].sum(axis=1)  # kinetic, stored, potential
    work = GRAVITY * LENGTH * DENSITY * HEIGHT
    assert np.ptp(moving) < 0.02 * work  # a first step of contact takes a share of 1/elements, and gives it back
    assert abs(moving[-1] - moving[0]) < 1e-9 * work


def test_below_one_the_force_rings_about_the_exact_one():
    _, step, seen = bounced(60, "multiplier", periods=0.4, courant=0.5, averaged=False)
    time, force = step * np.arange(len(seen.force)), seen.force[:, 0]
    inside = (time > 1.02) & (time < 1.64)
    off = force[inside] - 300.0 - 300.0 * (time[inside] - 1.0)
    assert 5.0 < np.abs(off).max() < 15.0 and abs(off.mean()) < 2.0
    assert step * force.sum() == pytest.approx(800.0 / 3.0, rel=0.01)


def test_all_methods_are_offered():
    assert METHODS == ("defence node", "multiplier", "penalty")
