"""Hertz's contact of a cylinder with a rigid plane, by damped steps until it is at rest, under refinement."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.structures import Elastic, FiniteElementSystem, Plane, Quads
from jaxbuffer.structures.central_differences import advance
from jaxbuffer.structures.contact import NodeContact, RigidPlane

TOPIC = "Finite elements, liquid and contact"
RADIUS, YOUNG, POISSON = 0.1, 1e7, 0.3
MODULUS = YOUNG / (1.0 - POISSON**2)
WIDTH = 0.1 * RADIUS  # half of it
FORCE = np.pi * MODULUS * WIDTH**2 / (4.0 * RADIUS)  # of the whole cylinder, a metre long
PEAK = np.sqrt(FORCE * MODULUS / (np.pi * RADIUS))
STEPS = 150  # for each element across


def quarter_disc(across):
    """Nodes, corners and numbers [along the arc, upwards] of a quarter of the cylinder, whose elements are the smaller
    the nearer to where it is pressed: a map of the square onto arc, arc, diameter and axis (Coons)."""
    s = (np.arange(across + 1) / across) ** 2.0
    arc = lambda angle: RADIUS * np.stack([np.sin(angle), 1.0 - np.cos(angle)], axis=-1)  # noqa: E731
    low, right = arc(0.25 * np.pi * s)[:, None], arc(0.25 * np.pi * (1.0 + s))[None]
    axis = RADIUS * np.stack([0.0 * s, s], axis=-1)[None]
    high = RADIUS * np.stack([s, 1.0 + 0.0 * s], axis=-1)[:, None]
    a, b = s[:, None, None], s[None, :, None]
    ends = (1.0 - a) * b * high[0, 0] + a * (1.0 - b) * low[-1, 0] + a * b * high[-1, 0]
    at = (1.0 - b) * low + b * high + (1.0 - a) * axis + a * right - ends
    node = np.arange((across + 1) ** 2).reshape(across + 1, across + 1)
    corners = np.stack([node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]], axis=-1)
    return at.reshape(-1, 2), corners.reshape(-1, 4), node


def shares(x):
    """How much of a line through x belongs to each of its nodes."""
    half = np.zeros(len(x))
    half[:-1] += 0.5 * np.diff(x)
    half[1:] += 0.5 * np.diff(x)
    return half


class Pressed(NamedTuple):
    """Nodes that may touch: places [m], forces [N], pressures [Pa]; and whether it is at rest."""

    x: np.ndarray
    force: np.ndarray
    pressure: np.ndarray
    kinetic: float
    stored: float


def pressed(across):
    """Half of `FORCE`, spread over the diameter, rises on a quarter of the cylinder and then stays.

    At rest masses mean nothing: each element is as dense as gives it the same frequency, so that small ones do not
    shorten the step. A drag well below the critical one of the slowest motion brings it to rest.
    """
    at, corners, node = quarter_disc(across)
    positions = np.concatenate([at, [[0.0, 0.0]]])
    load = np.zeros(positions.shape)
    load[node[:, -1], 1] = -0.5 * FORCE / RADIUS * shares(at[node[:, -1], 0])
    slaves = node[: across // 2, 0]

    def settle():
        quads = Quads.of(jnp.asarray(positions), corners)
        frequency = Plane(quads, Elastic(1.0, YOUNG, POISSON)).fastest()
        group = Plane(quads, Elastic(frequency**2, YOUNG, POISSON))
        mass = group.mass()[:-1]
        inverse = jnp.concatenate([jnp.repeat(1.0 / mass[:, None], 2, axis=1), jnp.zeros((1, 2))])
        inverse = inverse.at[node[0], 0].set(0.0)
        floor = NodeContact(slaves, RigidPlane(len(at), (0.0, 1.0)))
        system = FiniteElementSystem(jnp.asarray(positions), inverse, (group,), (floor,), load=jnp.asarray(load))
        step = 0.9 * system.stable_step()
        damped = 0.35 * jnp.sqrt(MODULUS / jnp.sum(mass)) * step
        rise = 0.4 * STEPS * across * step

        def one(state, _):
            share = jnp.minimum(state.time / rise, 1.0)
            rising = FiniteElementSystem(system.positions, inverse, (group,), (floor,), load=share * system.load)
            after, _ = advance(rising, state, step, (None,))
            return after._replace(velocity=(1.0 - damped) / (1.0 + damped) * after.velocity), None

        state = jax.lax.scan(one, system.start(), length=STEPS * across)[0]
        seen = advance(system, state, step, (None,))[1]
        return seen.contacts[0].normal, seen.energies.kinetic, seen.energies.stored

    force, kinetic, stored = jax.jit(settle)()
    x = at[node[:, 0], 0]
    return Pressed(
        x[: len(slaves)],
        np.asarray(force),
        np.asarray(force) / shares(x)[: len(slaves)],
        float(kinetic),
        float(stored),
    )


@pytest.mark.long
def test_pressure_and_width_under_refinement(evidence):
    """The pressure √(F E*/(π R)) √(1 - x²/a²) over four fifths of the half width a = √(4 F R/(π E*)), and that width
    by the forces' second moment, a²/4 of an ellipse."""
    off = []
    for across in (12, 24, 48):
        found = pressed(across)
        assert found.force.sum() == pytest.approx(0.5 * FORCE, rel=1e-4), "all of the load is carried"
        assert found.kinetic < 1e-6 * found.stored, "it is at rest"
        inside = found.x < 0.8 * WIDTH
        exact = PEAK * np.sqrt(1.0 - (found.x[inside] / WIDTH) ** 2)
        width = 2.0 * np.sqrt(found.force @ found.x**2 / found.force.sum())
        off.append((abs(found.pressure[inside] - exact).max() / PEAK, abs(width / WIDTH - 1.0)))
    pressures, widths = zip(*off, strict=True)
    assert np.all(np.diff(pressures) < 0.0) and np.all(np.diff(widths) < 0.0), off
    evidence(TOPIC, "pressure of a cylinder on a plane", pressures[-1], 0.01, "Hertz")
    evidence(TOPIC, "width of a cylinder's contact", widths[-1], 0.01, "Hertz")
