"""A plate with holes in a duct of liquid, when a pressure is let go on one side: closed forms of one dimension."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from test_quads import grid

from jaxbuffer.structures import FiniteElementSystem, Liquid
from jaxbuffer.structures.acoustics import element_matrices
from jaxbuffer.structures.boundary import boundary_areas
from jaxbuffer.structures.central_differences import advance
from jaxbuffer.structures.incidence import Incidence
from jaxbuffer.structures.perforated import Holes, Perforated, at_heights

TOPIC = "Finite elements, liquid and contact"
DENSITY, SOUND = 1000.0, 1500.0  # kg/m³, m/s
HALF, ELEMENTS = 3.0, 600  # m of duct on either side, and elements along it
STEP = 0.5 * HALF / ELEMENTS / SOUND
STEPS = 1800  # no wave has come back from an end


def duct(holes, mass):
    """A plate of a ``mass`` over its area [kg/m²] between two halves, 1 m high; its two nodes stand on each other."""
    (left, cells), (right, _) = grid(ELEMENTS, 1, HALF, 1.0), grid(ELEMENTS, 1, HALF, 1.0)
    positions = np.concatenate([left - [HALF, 0.0], right])
    corners = np.concatenate([cells, cells + len(left)])
    stiffness, consistent = element_matrices(positions, corners, SOUND)
    incidence = Incidence.of(corners, len(positions))
    before, after = np.array([len(left) - 2, len(left) - 1]), np.array([len(left), len(left) + 1])
    plate = np.array([[0], [1]])
    at = jnp.array([[0.0, 0.0], [0.0, 1.0]])
    through = Perforated(
        before, after, boundary_areas(at)[:, 0], plate, at_heights(at[:, 1], at[:, 1]), holes, jnp.asarray(DENSITY)
    )
    nothing = np.zeros(0, int)
    mass_of_liquid = incidence.to_nodes(jnp.sum(consistent, axis=2))
    everywhere, nowhere = jnp.ones(len(positions)), jnp.zeros((0, 2))
    liquid = Liquid(incidence, stiffness, mass_of_liquid, everywhere, DENSITY, nothing, nothing, nowhere)
    added = through.added_mass()[:, 0]
    inverse = jnp.stack([jnp.where(jnp.isinf(mass), 0.0, 1.0 / (0.5 * mass + added)), jnp.zeros(2)], axis=1)
    system = FiniteElementSystem(at, inverse, liquid=liquid._replace(plate=through))
    return system, np.arange(len(positions)) < len(left)


@jax.jit  # once for all holes, masses and pressures
def course(holes, mass, pressure):
    """At each step: volume that passes [m/s], energy, energy lost [J/m²], the plate's velocity [m/s]."""
    system, on_the_left = duct(holes, mass)
    start = system.start()._replace(pressure=jnp.where(on_the_left, pressure, 0.0))

    def one(state, _):
        after, known = advance(system, state, STEP, ())
        passed = (1.0 - holes.carried) * after.velocity[0, 0] + after.through[0]
        return after, (passed, sum(known.energies), known.energies.holes, after.velocity[0, 0])

    return jax.lax.scan(one, start, length=STEPS)[1]


def let_go(holes, mass, pressure):
    """The time of each step [s], and what `course` sees there."""
    return STEP * (np.arange(STEPS) + 0.5), *map(np.asarray, course(holes, mass, pressure))


def test_numbers_of_holes():
    """At a third, 20 mm and 6 mm, by hand; fully open there is only the liquid in the plate's place."""
    share = 1.0 / 3.0
    beyond = 0.85 * 0.02 * (1.0 - 1.47 * share**0.5 + 0.47 * share**1.5)
    holes = jax.jit(Holes.of)(0.006, 0.02, share)
    contracted = 0.63 + 0.37 / 27.0
    assert float(holes.inertia) == pytest.approx(3.0 * (0.006 + beyond), rel=1e-12)
    assert float(holes.loss) == pytest.approx((3.0 / contracted - 1.0) ** 2, rel=1e-12)
    np.testing.assert_allclose(jax.jit(Holes.of)(0.006, 0.02, 1.0), [0.006, 1.0, 0.0, 0.0], atol=1e-15)


@pytest.mark.parametrize("pressure", [1.0, 1e7, 3e8])
def test_the_flow_through_a_plate_that_is_held(pressure, evidence):
    """ρ τ q̇ = p - 2 ρ c q - ρ ζ q²/2, whose solution is elementary; at 1 Pa nothing is lost, at 300 MPa the loss holds
    the flow at 2/3 of what it would be."""
    holes = Holes.of(0.5, 1.0, 0.2)
    time, passed, energy, lost, _ = let_go(holes, np.inf, pressure)
    inertia, loss = float(holes.inertia), float(holes.loss)
    push, slow, brake = pressure / (DENSITY * inertia), 2.0 * SOUND / inertia, 0.5 * loss / inertia
    root = np.sqrt(slow**2 + 4.0 * push * brake)
    decay = np.exp(-root * time)
    expected = 2.0 * push * (1.0 - decay) / (root + slow + (root - slow) * decay)
    off = np.abs(passed - expected).max() / expected.max()
    evidence(TOPIC, "flow through a plate that is held", off, 2e-3, "a wave's closed form, with loss")
    assert np.ptp(energy[1:]) < 1e-10 * energy[1]
    assert lost[-1] == pytest.approx(np.trapezoid(0.5 * DENSITY * loss * expected**3, time), rel=1e-2)


@pytest.mark.parametrize(("aperture", "mass"), [(0.2, 400.0), (0.7, 400.0), (1.0, 400.0), (1e-3, 400.0)])
def test_a_plate_that_is_free_goes_along(aperture, mass, evidence):
    """Weak, so that nothing is lost: of what passes the plate and the liquid in its holes are in the way together, like
    two masses side by side; a plate all holes is not moved."""
    holes = jax.tree.map(np.asarray, Holes.of(0.5, 1.0, aperture))
    time, passed, energy, _, speed = let_go(holes, mass, 1.0)
    softness = 1.0 / (DENSITY * holes.inertia) + (1.0 - holes.carried) ** 2 / (mass + DENSITY * holes.added)
    rate = 2.0 * DENSITY * SOUND * softness
    expected = (1.0 - np.exp(-rate * time)) / (2.0 * DENSITY * SOUND)
    off = np.abs(passed - expected).max() / expected.max()
    evidence(TOPIC, "a plate with holes that a wave moves", off, 1e-2, "a wave's closed form")
    own = (1.0 - holes.carried) / (mass + DENSITY * holes.added)
    assert float(speed[-1]) == pytest.approx(float(expected[-1] * own / softness), rel=1e-2, abs=1e-15)
    assert np.ptp(energy[1:]) < 1e-10 * energy[1]
