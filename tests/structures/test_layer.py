"""A cushion: a mass on it against closed forms of the damped oscillator, and its solid end."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.structures import FiniteElementSystem
from jaxbuffer.structures.central_differences import advance
from jaxbuffer.structures.contact import Layer, RigidPlane

TOPIC = "Finite elements, liquid and contact"
MASS, STIFFNESS, WIDTH, THICKNESS, SPEED = 2.0, 4e4, 0.25, 0.1, 1.0
OMEGA = np.sqrt(STIFFNESS * WIDTH / MASS)


def struck(damping=0.0, speed=SPEED, solid=0.0, step=1e-5, steps=8000):
    """A node falls on a cushion that lies on the ground: times, compressions, forces, speeds and energies."""
    layer = Layer(np.array([0]), RigidPlane(1, (0.0, 1.0)), jnp.full(1, WIDTH), THICKNESS, STIFFNESS, damping, solid)
    inverse = jnp.array([[0.0, 1.0 / MASS], [0.0, 0.0]])
    system = FiniteElementSystem(jnp.array([[0.0, THICKNESS], [0.0, 0.0]]), inverse, layers=(layer,))

    def one(state, _):
        after, seen = advance(system, state, step, ())
        energies = seen.energies.kinetic, seen.energies.contact
        return after, (seen.time, -seen.displacement[0, 1], seen.layers[0].normal[0], seen.velocity[0, 1], *energies)

    start = system.start(jnp.array([[0.0, -speed], [0.0, 0.0]]))
    return map(np.asarray, jax.jit(lambda s: jax.lax.scan(one, s, length=steps)[1])(start))


def test_without_a_damper_it_gives_back_half_a_sine(evidence):
    time, depth, force, velocity, kinetic, contact = struck()
    assert depth.max() == pytest.approx(SPEED / OMEGA, rel=1e-3)
    off = abs(force.max() / (MASS * OMEGA * SPEED) - 1.0)
    evidence(TOPIC, "largest force of a cushion", off, 1e-3, "half a sine")
    assert np.ptp(time[force > 0.0]) == pytest.approx(np.pi / OMEGA, abs=3e-5)
    assert velocity[-1] == pytest.approx(SPEED, rel=1e-3)
    np.testing.assert_allclose(kinetic + contact, kinetic[0], rtol=1e-11)


@pytest.mark.parametrize("ratio", [0.1, 0.5])
def test_with_a_damper_it_presses_until_its_force_is_zero_and_never_pulls(ratio):
    """The oscillator's deflection until ω² x + 2 ζ ω ẋ = 0, where the mass leaves with the speed it has then."""
    time, _, force, velocity, kinetic, contact = struck(2.0 * ratio * MASS * OMEGA / WIDTH)
    turned = OMEGA * np.sqrt(1.0 - ratio**2)
    leaves = (np.pi - np.arctan2(2.0 * ratio * np.sqrt(1.0 - ratio**2), 1.0 - 2.0 * ratio**2)) / turned
    decay = np.exp(-ratio * OMEGA * leaves)
    speed = -SPEED * decay * (np.cos(turned * leaves) - ratio / np.sqrt(1.0 - ratio**2) * np.sin(turned * leaves))
    assert force.min() == 0.0
    assert time[force > 0.0].max() == pytest.approx(leaves, abs=3e-5)
    assert velocity[-1] == pytest.approx(speed, rel=2e-3)
    assert contact[-1] == pytest.approx(kinetic[0] - kinetic[-1], rel=1e-11), "what the damper has taken"


def test_its_end_is_felt():
    """Beyond four fifths of the thickness the solid stiffness is added: energy gives the depth."""
    speed, solid = 8.0, 40.0 * STIFFNESS
    _, depth, force, *_ = struck(speed=speed, solid=solid)
    reached = depth.max()
    beyond = reached - 0.8 * THICKNESS
    assert beyond > 0.0
    stored = 0.5 * WIDTH * (STIFFNESS * reached**2 + solid * beyond**2)
    assert stored == pytest.approx(0.5 * MASS * speed**2, rel=2e-3)
    assert force.max() == pytest.approx(WIDTH * (STIFFNESS * reached + solid * beyond), rel=1e-3)
