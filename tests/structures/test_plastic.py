"""Plasticity after von Mises against closed forms: a tension cycle under plane strain, and a thick-walled cylinder."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import brentq

from jaxbuffer.structures import Plane, Plastic, Quads, mises
from jaxbuffer.structures.materials import PlasticHistory

TOPIC = "Finite elements, liquid and contact"
SOFT = Plastic(950.0, 1e9, 0.4, 25e6, 40e6, 0.6)


def driven(material, strains):
    """Stresses and equivalent plastic strains along a path of strains (steps, 3)."""

    def one(history, strain):
        found = material.answer(strain, history)
        return found.history, (
            found.stress,
            found.history.equivalent,
            found.stored,
            material.plastic_work(found.history),
        )

    steps = jax.jit(lambda strains: jax.lax.scan(one, PlasticHistory.none(), strains)[1])(strains)
    return tuple(map(np.asarray, steps))


def test_pure_shear_loads_unloads_and_loads_back_as_hand_calculation_says(evidence):
    """τ = μγ to τ_y = σ_y/√3, then the slope μ H/(3μ + H) ; back elastically over twice the stress reached."""
    shear, limit = float(SOFT.elastic.shear_modulus), 25e6 / np.sqrt(3.0)
    slope = shear * 40e6 / (3.0 * shear + 40e6)
    up = 0.2
    path = np.concatenate([np.linspace(0.0, up, 201), np.linspace(up, -up, 401)[1:]])
    stress, equivalent, stored, work = driven(SOFT, np.stack([0 * path, 0 * path, path], axis=1))
    tau = np.asarray(stress[:, 2])
    top = limit + slope * (up - limit / shear)
    evidence(TOPIC, "shear stress of a hardening material", abs(tau[200] / top - 1.0), 1e-12, "hand calculation")
    back = path[201:]
    turned = up - 2.0 * top / shear  # where it yields the other way
    exact = np.where(back >= turned, top - shear * (up - back), -top + slope * (back - turned))
    np.testing.assert_allclose(tau[201:], exact, rtol=1e-10, atol=1e-3)
    gained = np.asarray(equivalent)[200]
    assert gained == pytest.approx((up - top / shear) / np.sqrt(3.0), rel=1e-12)
    total = np.trapezoid(tau, path)
    assert total == pytest.approx(float(stored[-1] + work[-1]), rel=1e-5)


def test_what_flows_keeps_its_volume_and_the_stress_stays_on_the_surface():
    rng = np.random.default_rng(0)
    path = np.cumsum(0.004 * rng.standard_normal((300, 3)), axis=0)
    stress, equivalent, _, _ = driven(SOFT, path)
    limit = 25e6 + 40e6 * np.asarray(equivalent)
    assert np.all(np.asarray(mises(stress)) <= limit * (1.0 + 1e-12))
    assert np.all(np.diff(equivalent) >= 0.0) and equivalent[-1] > 0.05
    volume = path[:, 0] + path[:, 1]
    pressure = (stress[:, 0] + stress[:, 1] + stress[:, 3]) / 3.0
    np.testing.assert_allclose(pressure, 1e9 / 3.0 / (1.0 - 0.8) * volume, rtol=1e-9, atol=1e-3)


@pytest.mark.long
def test_a_thick_cylinder_yields_through_at_its_closed_form_pressure(evidence):
    """Perfectly plastic, plane strain: p = (2σ_y/√3) (ln(c/a) + (1 - c²/b²)/2) with the front at c; radial displacement
    outside of it elastic, u(b) = p_c c²·2(1 - ν²) b/(E (b² - c²)), p_c = σ_y/√3 (1 - c²/b²), ν → 1/2."""
    inner, outer, young, poisson, limit = 0.1, 0.2, 2e11, 0.49, 250e6
    rings, sectors = 24, 12
    r = np.linspace(inner, outer, rings + 1)
    angle = np.linspace(0.0, np.pi / 2.0, sectors + 1)
    positions = np.stack([np.outer(np.cos(angle), r), np.outer(np.sin(angle), r)], axis=-1).reshape(-1, 2)
    node = np.arange(len(positions)).reshape(sectors + 1, rings + 1)
    corners = np.stack([node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]], axis=-1).reshape(-1, 4)
    group = Plane(Quads.of(jnp.asarray(positions), corners), Plastic(1.0, young, poisson, limit, 0.0, 1.0))
    front = 0.15
    k = limit / np.sqrt(3.0)
    pressure = 2.0 * k * np.log(front / inner) + k * (1.0 - front**2 / outer**2)
    held = np.zeros(positions.shape, bool)
    held[node[0], 1] = True
    held[node[-1], 0] = True
    free = np.flatnonzero(~held.ravel())
    edge = positions[node[:, 0]]
    tangent = np.zeros_like(edge)
    tangent[:-1] += 0.5 * (edge[1:] - edge[:-1])
    tangent[1:] += 0.5 * (edge[1:] - edge[:-1])
    push = np.zeros(positions.shape)
    push[node[:, 0]] = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)  # p = 1 on the inner face

    def residual(moves, history, factor):
        u = jnp.zeros(positions.size).at[free].set(moves).reshape(positions.shape)
        found = group.resist(u, history)
        return (found.forces - factor * push).ravel()[free], found

    solve = jax.jit(lambda m, h, f: (*residual(m, h, f), jax.jacfwd(lambda x: residual(x, h, f)[0])(m)))
    moves, history = jnp.zeros(len(free)), group.start()
    for factor in pressure * np.linspace(0.5, 1.0, 6):
        for _ in range(25):
            off, found, matrix = solve(moves, history, factor)
            if float(jnp.abs(off).max()) < 1e-6 * factor * inner:
                break
            moves = moves - jnp.linalg.solve(matrix, off)
        history = found.history
    radius = np.asarray(jnp.linalg.norm(positions[corners].mean(axis=1), axis=1))
    yielded = np.asarray(found.history.equivalent).max(axis=1) > 0.0
    assert radius[yielded].max() == pytest.approx(front, abs=1.1 * (outer - inner) / rings)
    stress = np.asarray(group.quads.in_own_axes(found.stress[..., :3])).mean(axis=1)
    centre = positions[corners].mean(axis=1) / radius[:, None]
    radial = np.einsum("ei,ei->e", centre**2, stress[:, :2]) + 2.0 * centre[:, 0] * centre[:, 1] * stress[:, 2]
    exact = np.where(
        radius < front,
        -k * (1.0 - front**2 / outer**2 + 2.0 * np.log(front / radius)),
        -k * front**2 / outer**2 * (outer**2 / radius**2 - 1.0),
    )
    off = np.max(np.abs(radial - exact)) / pressure
    evidence(TOPIC, "radial stress of a thick cylinder that yields", off, 0.012, "closed form (Hill)")


def test_the_depth_of_the_front_follows_from_the_pressure():
    """The closed form used above, against integrated equilibrium."""
    k, a, b = 1.0, 1.0, 2.0
    p = lambda c: 2.0 * k * np.log(c / a) + k * (1.0 - c**2 / b**2)  # noqa: E731
    assert brentq(lambda c: p(c) - p(1.5), a, b) == pytest.approx(1.5)
    assert p(b) == pytest.approx(2.0 * k * np.log(2.0))


@pytest.mark.long
def test_a_deleted_element_carries_nothing_and_its_energy_is_told():
    positions = jnp.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    group = Plane(Quads.of(positions, np.array([[0, 1, 2, 3]])), Plastic(1.0, 1e9, 0.3, 25e6, 40e6, 0.1))
    stretched = lambda x: jnp.array([[0.0, 0.0], [x, 0.0], [x, 0.0], [0.0, 0.0]])  # noqa: E731
    history, released, work = group.start(), 0.0, []
    for x in np.linspace(0.0, 0.3, 61):
        found = group.resist(stretched(x), history)
        history = found.history
        released += float(found.released)
        work.append((x, float(found.forces[1, 0] + found.forces[2, 0]), float(found.stored), float(found.plastic)))
    x, force, stored, plastic = np.array(work).T
    gone = np.flatnonzero(force == 0.0)[1]  # 0 at rest
    assert np.all(force[gone:] == 0.0) and np.all(stored[gone:] == 0.0)
    assert np.ptp(plastic[gone:]) == 0.0, "it remembers no more"
    assert released == pytest.approx(stored[gone - 1], rel=1e-12)
    assert np.trapezoid(force[:gone], x[:gone]) == pytest.approx(stored[gone - 1] + plastic[gone - 1], rel=1e-3)
    assert float(history.equivalent.min()) >= 0.1
