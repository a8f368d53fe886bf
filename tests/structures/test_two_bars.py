"""Bars against walls, points and each other: closed forms of their forces, durations and speeds."""

import jax.numpy as jnp
import numpy as np
import pytest
from bars import Bar, follow, system
from scipy.integrate import solve_ivp

from jaxbuffer.structures.contact import NodeContact, RigidPlane

TOPIC = "Finite elements, liquid and contact"
STEEL = {"young": 2e11, "density": 7800.0, "section": 4e-4}
WAVE = np.sqrt(2e11 / 7800.0)
PLATEAU = 7800.0 * WAVE * 4e-4 / 2.0  # N s/m, ρcS/2


def node_on_node(slave, master, method):
    """The end of one bar above that of another."""
    return NodeContact(np.array([slave]), RigidPlane(master, (0.0, 1.0)), method)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["multiplier", "defence node"])
@pytest.mark.parametrize("elements", [10, 50])
def test_a_free_bar_on_a_clamped_one(elements, method):
    """SDNL111: 7899.367 N from the second step on, 4 L/c long, then away with 1/(4 ne) less speed."""
    n = elements
    bars = system([Bar(0.0, 1.0), Bar(1.0, 2.0)], n, **STEEL, contacts=[node_on_node(n + 1, n, method)], held=[0])
    step = 1.0 / n / WAVE
    speeds = np.where(np.arange(2 * n + 2) > n, -1.0, 0.0)
    seen = follow(bars, speeds, step, 6 * n)
    force = seen.force[:, 0]
    pressed = np.flatnonzero(force > 1.0)
    np.testing.assert_allclose(force[pressed[1:-1]], PLATEAU, rtol=1e-10)
    assert pytest.approx(7899.367, abs=6e-4) == PLATEAU
    assert force[pressed[0]] == pytest.approx(PLATEAU / 2.0, rel=1e-10)
    assert len(pressed) * step == pytest.approx(4.0 / WAVE, abs=1.01 * step)
    upper = np.average(seen.velocity[-1, n + 1 :], weights=np.asarray(bars.mass)[n + 1 :, 1])
    assert upper == pytest.approx(1.0 - 1.0 / (4.0 * n), rel=1e-6)


def test_two_free_bars_exchange_their_speeds(evidence):
    n = 50
    bars = system([Bar(0.0, 1.0), Bar(1.0, 2.0)], n, **STEEL, contacts=[node_on_node(n + 1, n, "multiplier")])
    step = 1.0 / n / WAVE
    seen = follow(bars, np.where(np.arange(2 * n + 2) > n, -1.0, 0.0), step, 3 * n)
    pressed = np.flatnonzero(seen.force[:, 0] > 1.0)
    off = np.max(np.abs(seen.force[pressed[1:-1], 0] / PLATEAU - 1.0))
    evidence(TOPIC, "force between two bars", off, 1e-10, "d'Alembert's solution")
    assert len(pressed) * step == pytest.approx(2.0 / WAVE, abs=1.01 * step)
    mass = np.asarray(bars.mass[:, 1])
    lower, upper = (
        np.average(seen.velocity[-1][part], weights=mass[part]) for part in (slice(0, n + 1), slice(n + 1, None))
    )
    assert lower == pytest.approx(-1.0, abs=2.0 / n) and upper == pytest.approx(0.0, abs=2.0 / n)
    np.testing.assert_allclose(seen.velocity @ mass, -7800.0 * 4e-4, rtol=1e-12)


def test_the_impacting_bar():
    """Siconos' example: ρcSv = 1270.827 N for 2 L/c = 385.450 µs, from 0.5 ms on; no gravity."""
    n, young, section, speed, gap = 100, 210e9, 3.14e-4, 0.1, 5e-5
    wave = np.sqrt(young / 7800.0)
    floor = NodeContact(np.array([0]), RigidPlane(n + 1, (0.0, 1.0)), "multiplier")
    bar = system(
        [Bar(gap, gap + 1.0)], n, young=young, density=7800.0, section=section, contacts=[floor], points=[(0.0, 0.0)]
    )
    step = 1.0 / n / wave
    seen = follow(bar, np.append(np.full(n + 1, -speed), 0.0), step, round(1.2e-3 / step))
    force, time = seen.force[:, 0], step * np.arange(len(seen.force))
    exact = 7800.0 * wave * section * speed
    assert exact == pytest.approx(1270.827, abs=1e-3)
    pressed = np.flatnonzero(force > 1.0)
    np.testing.assert_allclose(force[pressed[2:-2]], exact, rtol=1e-9)
    assert time[pressed[0]] == pytest.approx(gap / speed, abs=2.0 * step)
    assert len(pressed) * step == pytest.approx(385.450e-6, abs=1.5 * step)
    assert step * force.sum() == pytest.approx(2.0 * 7800.0 * section * speed, rel=0.02)


@pytest.mark.long
def test_a_laterally_held_bar_of_plane_elements_on_a_wall():
    """SDNV100: 1.85638e6 N for 68.95 µs, by penalty; the plateau between the overshoots of its first half."""
    import jax

    from jaxbuffer.structures import Elastic, FiniteElementSystem, Plane, Quads
    from jaxbuffer.structures.central_differences import advance

    n, side, length, speed, gap = 80, 0.02, 0.2, 100.0, 2e-3
    material = Elastic(8000.0, 2e11, 0.3)
    wave = float(material.wave_speed())
    assert wave == pytest.approx(5801.19, abs=6e-3)
    heights = gap + np.linspace(0.0, length, n + 1)
    positions = jnp.asarray([[x, y] for y in heights for x in (0.0, side)] + [[0.0, 0.0]])
    first = 2 * np.arange(n)
    group = Plane(Quads.of(positions, np.stack([first, first + 1, first + 3, first + 2], axis=1)), material)
    inverse = np.zeros(positions.shape)
    inverse[:-1, 1] = 1.0 / np.asarray(group.mass())[:-1]
    floor = NodeContact(np.array([0, 1]), RigidPlane(2 * n + 2, (0.0, 1.0)), "penalty", 2e11)
    bar = FiniteElementSystem(positions, jnp.asarray(inverse), (group,), (floor,))
    step = 0.5 * float(bar.stable_step())
    start = bar.start(jnp.zeros_like(positions).at[:-1, 1].set(-speed))

    def one(state, _):
        after, seen = advance(bar, state, step, (None,))
        return after, (seen.time, jnp.sum(seen.contacts[0].normal) * side)  # as deep as it is wide

    time, force = map(np.asarray, jax.lax.scan(one, start, length=round(1.2e-4 / step))[1])
    pressed = force > 0.1 * force.max()
    assert time[pressed][0] == pytest.approx(gap / speed, rel=0.05)
    middle = (time > 3.5e-5) & (time < 8e-5)
    # logarithmic strain at 1.7 %: a little stiffer in compression than the linear bar
    assert force[middle].mean() == pytest.approx(1.85638e6, rel=0.02)
    assert np.ptp(time[pressed]) == pytest.approx(68.95e-6, rel=0.05)


def test_a_mass_on_a_spring_against_a_stiff_stop():
    """SDND101: 9950.372 N for 31.26 ms, by penalty; a bar of one element is the spring."""
    mass, spring, stop, speed = 100.0, 1e4, 1e6, 1.0
    contact = NodeContact(np.array([1]), RigidPlane(2, (0.0, 1.0)), "penalty", stop)
    bars = system([Bar(0.0, 1.0)], 1, young=spring, density=1e-9, contacts=[contact], held=[0], points=[(1.0, 0.0)])
    inverse = jnp.asarray(bars.inverse_mass).at[1, 1].set(1.0 / mass)
    bars = type(bars)(bars.positions, inverse, bars.elements, bars.contacts)
    step = 1e-5
    seen = follow(bars, np.array([0.0, -speed, 0.0]), step, 4000)
    force = seen.force[:, 0]
    omega = np.sqrt((spring + stop) / mass)
    assert force.max() == pytest.approx(stop * speed / omega, rel=1e-5)
    assert stop * speed / omega == pytest.approx(9950.372, abs=6e-4)
    assert np.count_nonzero(force) * step == pytest.approx(np.pi / omega, abs=2.0 * step)
    assert np.pi / omega == pytest.approx(31.2600e-3, abs=6e-8)
    reference = solve_ivp(lambda t, y: [y[1], -(omega**2) * y[0]], (0.0, 0.03), [0.0, -speed], rtol=1e-10, atol=1e-12)
    assert seen.displacement[3000, 1] == pytest.approx(reference.y[0, -1], abs=2e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("beta", "critical"),
    [
        (0.0, 1.0),
        (0.25, 0.992394),
        (0.5, 0.971737),
        (1.0, 0.910180),
        (2.0, 0.786151),
        (5.0, 0.572644),
        (10.0, 0.425438),
        (100.0, 0.140716),
    ],
)
def test_the_step_found_is_safe_with_a_penalty(beta, critical):
    """The critical step of a lumped bar whose end node rests on k = β EA/h, over h/c; ours bounds it from below."""
    n = 40
    h = 1.0 / n
    contact = NodeContact(np.array([0]), RigidPlane(n + 1, (0.0, 1.0)), "penalty", beta * 1.0 / h)
    bar = system([Bar(0.0, 1.0)], n, young=1.0, density=1.0, contacts=[contact], points=[(0.0, 0.0)])
    main = np.full(n + 1, 2.0)
    main[[0, -1]] = 1.0
    stiffness = (np.diag(main) - np.eye(n + 1, k=1) - np.eye(n + 1, k=-1)) / h
    stiffness[0, 0] += beta / h
    root = np.sqrt(np.asarray(bar.inverse_mass)[:-1, 1])
    exact = 2.0 / np.sqrt(np.linalg.eigvalsh(root[:, None] * stiffness * root)[-1])
    assert exact / h == pytest.approx(critical, abs=2e-3)
    found = float(bar.stable_step())
    assert 0.6 * exact < found <= exact * (1.0 + 1e-12)
