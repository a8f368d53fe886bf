"""Contact of plane bodies: momentum, defence node against multipliers, friction, the search, and Hertz."""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from test_quads import grid

from in_short import quick
from jaxbuffer.structures import Elastic, FiniteElementSystem, Plane, Quads
from jaxbuffer.structures.central_differences import advance
from jaxbuffer.structures.contact import NodeContact, RigidPlane, Segments, candidates, contact_forces

SOFT = Elastic(1000.0, 1e7, 0.3)


@eqx.filter_jit
def two_blocks(method, slaves=None, published=False, friction=0.0, speed=(0.4, -1.0)):
    """A small block falls, slanting, on a larger one of other elements."""
    low, low_corners = grid(7, 3, 0.7, 0.3)
    high, high_corners = grid(3, 2, 0.23, 0.2)
    high = high + np.array([0.21, 0.3005])
    positions = jnp.asarray(np.concatenate([low, high]))
    corners = np.concatenate([low_corners, high_corners + len(low)])
    group = Plane(Quads.of(positions, corners), SOFT)
    inverse = jnp.repeat(1.0 / group.mass()[:, None], 2, axis=1)
    top = np.flatnonzero(low[:, 1] == 0.3)
    ends = np.stack([top[1:], top[:-1]], axis=1)  # the body on the left: from right to left along its top
    bottom = len(low) + np.flatnonzero(high[:, 1] < 0.301)
    contact = NodeContact(
        bottom if slaves is None else bottom[slaves],
        Segments(ends),
        method,
        stiffness=2e6,
        friction=friction,
        published=published,
    )
    system = FiniteElementSystem(positions, inverse, (group,), (contact,))
    velocity = jnp.zeros_like(positions).at[len(low) :].set(jnp.asarray([speed]))
    return system, system.start(velocity), len(low)


stable_step = eqx.filter_jit(FiniteElementSystem.stable_step)


def followed(system, start, steps, share=0.5):
    step = share * float(stable_step(system))

    def one(state, _):
        after, seen = advance(system, state, step, system.search(state.displacement))
        return after, (seen.velocity, seen.displacement, seen.contacts[0].normal, sum(seen.energies))

    return step, *map(np.asarray, jax.jit(lambda s: jax.lax.scan(one, s, length=steps)[1])(start))


def momenta(system, velocity, displacement):
    mass = np.asarray(system.mass)[:, 0]
    at = np.asarray(system.positions) + displacement
    spin = at[..., 0] * velocity[..., 1] - at[..., 1] * velocity[..., 0]
    return np.einsum("n,tni->ti", mass, velocity), spin @ mass


@functools.cache
def met(method):
    """The system of two blocks without friction, and what is seen of them in 1500 steps."""
    system, start, _ = two_blocks(method)
    return system, followed(system, start, 1500)


@pytest.mark.parametrize("method", quick(["defence node", "multiplier", "penalty"], "multiplier"))
def test_both_momenta_are_kept_to_rounding(method):
    """The angular one, Σ m x × v, with the place of an instant and the mean of the velocities half a step before and
    after it."""
    system, (_, velocity, displacement, normal, _) = met(method)
    assert np.count_nonzero(normal.sum(axis=1)) > 10
    linear, angular = momenta(system, velocity, displacement)
    size = np.abs(linear[0]).max()
    np.testing.assert_allclose(linear - linear[0], 0.0, atol=1e-12 * size)
    np.testing.assert_allclose(angular - angular[0], 0.0, atol=1e-10 * size * 0.3)


@pytest.mark.slow
@pytest.mark.parametrize("method", quick(["defence node", "multiplier", "penalty"], "multiplier"))
def test_frictions_arm_is_the_gap(method):
    """Friction pulls the node here and the foot there: as a couple, whose moment is what the angular momentum lacks."""
    system, start, _ = two_blocks(method, friction=0.3)
    step = 0.5 * float(stable_step(system))

    def one(state, _):
        after, seen = advance(system, state, step, near := system.search(state.displacement))
        at, (found,) = system.positions + state.displacement, seen.contacts
        pairs = system.contacts[0].surface.pairs(system.contacts[0].slaves, at, near[0])
        moment = jnp.sum(at[:, 0] * found.nodes[:, 1] - at[:, 1] * found.nodes[:, 0])
        return after, (seen.velocity, seen.displacement, moment, 0.3 * jnp.sum(jnp.abs(pairs.gap) * found.normal))

    seen = jax.jit(lambda s: jax.lax.scan(one, s, length=1500)[1])(start)
    velocity, displacement, moment, most = map(np.asarray, seen)
    linear, angular = momenta(system, velocity, displacement)
    size = np.abs(linear[0]).max()
    np.testing.assert_allclose(linear - linear[0], 0.0, atol=1e-12 * size)
    turned = step * (np.cumsum(moment) - 0.5 * moment - 0.5 * moment[0])  # the mean of before and after each instant
    np.testing.assert_allclose(angular - angular[0], turned, atol=1e-10 * size * 0.3)
    assert np.abs(moment).max() > 0.0
    assert np.all(np.abs(moment) <= most * (1.0 + 1e-9) + 1e-9)


def forces_on_uneven_masses(system, start):
    """Places of the nodes with the upper block 1 mm lower, and the contact's forces of one step there on masses that
    are unequal."""
    lower = jnp.where(start.velocity[:, 1] < 0.0, -1e-3, 0.0)
    displacement = start.displacement.at[:, 1].add(lower)
    positions, near = system.positions + displacement, system.search(displacement)[0]
    uneven = np.linspace(1.0, 3.0, len(positions))[:, None] * system.inverse_mass
    still = jnp.zeros_like(positions)
    found = contact_forces(system.contacts[0], positions, start.velocity, still, uneven, 1e-4, near)
    return positions, found.nodes, found.normal


@pytest.mark.slow
def test_the_published_distribution_turns_bodies_of_unequal_masses():
    """The moment about any point, of the forces of one step: none by the shape functions."""
    for published, lost in ((False, 0.0), (True, 1e-3)):
        system, start, _ = two_blocks("defence node", published=published)
        found = jax.jit(functools.partial(forces_on_uneven_masses, system))(start)
        positions, forces, normal = map(np.asarray, found)
        turning = positions[:, 0] * forces[:, 1] - positions[:, 1] * forces[:, 0]
        total = abs(np.sum(turning)) / np.sum(np.abs(turning))
        assert np.abs(np.sum(forces, axis=0)).max() < 1e-9 * np.sum(normal)
        assert (total < 1e-12) if not published else (total > lost)


@pytest.mark.slow
def test_a_defence_node_is_a_multiplier_where_no_two_pairs_share_a_node():
    seen = {}
    for method in ("defence node", "multiplier"):
        system, start, _ = two_blocks(method, slaves=[0, 3])
        seen[method] = followed(system, start, 600)[1:4]
    for one, other in zip(*seen.values(), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9 * np.abs(other).max())


@pytest.mark.slow
def test_multipliers_let_nobody_in_and_never_pull():
    system, (_, _, displacement, normal, _) = met("multiplier")
    assert normal.min() >= 0.0
    contact = system.contacts[0]

    @jax.jit
    def deepest(u):
        pairs = contact.surface.pairs(contact.slaves, system.positions + u, system.search(u)[0])
        return jnp.min(jnp.where(pairs.present, pairs.gap, 1.0))

    for u in displacement[::50]:
        assert float(deepest(u)) > -2e-5  # the surface turns within a step


@pytest.mark.slow
def test_defence_nodes_let_in_what_neighbours_push_away():
    """Pairs that share nodes: each is closed for itself, so all together are pushed too far or not far enough; the
    difference to multipliers goes with the step."""
    impulses = [met(method)[1][3].sum() for method in ("defence node", "multiplier")]
    assert impulses[0] == pytest.approx(impulses[1], rel=0.05) and impulses[0] != impulses[1]


@eqx.filter_jit
def sliding_block():
    """A block on a plane, its start along it, and the critical step."""
    block, corners = grid(2, 1, 0.2, 0.1)
    positions = jnp.asarray(np.concatenate([block, [[0.0, 0.0]]]))
    group = Plane(Quads.of(positions, corners), Elastic(1000.0, 1e8, 0.3))
    inverse = jnp.repeat(jnp.where(group.mass() > 0.0, 1.0 / jnp.maximum(group.mass(), 1e-9), 0.0)[:, None], 2, axis=1)
    floor = NodeContact(np.flatnonzero(block[:, 1] == 0.0), RigidPlane(6, (0.0, 1.0)), "multiplier", friction=0.4)
    system = FiniteElementSystem(positions, inverse, (group,), (floor,), gravity=jnp.array([0.0, -10.0]))
    return system, system.start(jnp.zeros_like(positions).at[:-1, 0].set(0.2)), system.stable_step()


@pytest.mark.slow
def test_coulombs_friction_slides_and_sticks():
    """A block on a plane: it slows down by μ g, and then stays."""
    system, start, critical = sliding_block()
    step = 0.5 * float(critical)

    def one(state, _):
        after, seen = advance(system, state, step, (None,))
        return after, (seen.velocity[:-1, 0].mean(), seen.displacement[:-1, 0].mean())

    steps = round(0.08 / step)
    speed, way = map(np.asarray, jax.jit(lambda s: jax.lax.scan(one, s, length=steps)[1])(start))
    time = step * np.arange(steps)
    sliding = (time > 0.01) & (time < 0.04)
    slowed = np.polyfit(time[sliding], speed[sliding], 1)[0]
    assert slowed == pytest.approx(-0.4 * 10.0, rel=0.05)
    assert abs(speed[time > 0.07]).max() < 2e-2
    assert way[-1] == pytest.approx(0.2**2 / (2.0 * 4.0), rel=0.1)


@pytest.mark.long
def test_the_search_finds_the_segments_that_are_near():
    rng = np.random.default_rng(3)
    x = np.sort(rng.uniform(0.0, 1.0, 41))
    positions = jnp.asarray(
        np.concatenate([np.stack([x, 0.05 * np.sin(9.0 * x)], axis=1), rng.uniform(0.1, 0.9, (30, 2)) * [1.0, 0.1]])
    )
    ends = np.stack([np.arange(1, 41), np.arange(40)], axis=1)
    slaves = np.arange(41, 71)
    near = np.asarray(candidates(slaves, ends, positions, 6))
    surface = Segments(ends)
    some = surface.pairs(slaves, positions, jnp.asarray(near))
    every = surface.pairs(slaves, positions, jnp.broadcast_to(jnp.arange(40)[None], (30, 40)))
    close = np.asarray(every.present) & (np.abs(np.asarray(every.gap)) < 0.1)
    np.testing.assert_allclose(np.asarray(some.gap)[close], np.asarray(every.gap)[close])
    assert np.all(np.asarray(some.present)[close]) and np.count_nonzero(close) > 15
