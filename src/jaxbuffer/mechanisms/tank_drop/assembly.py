"""The drop onto a tank from parts: wall, liquid, cushion, slider and baffle, at rest under gravity (M166, M167)."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..._types import Scalar
from ...structures import Liquid, Orthotropic, Plane, Plastic, Quads, State, System
from ...structures.acoustics import element_matrices
from ...structures.boundary import boundary_areas
from ...structures.contact import Contact, Layer, RigidPlane
from ...structures.incidence import Incidence
from .design import TankDrop, TankDropScenario
from .laminate import equivalent
from .section import Section, section

SOLID = 10.0  # stiffness of the solid cushion over that of the soft one
ACROSS = 4  # integration points from one side of an element to the other
ITERATIONS = 20  # of Newton's method for the static start, and one for each node that may leave the baffle


class Assembled(NamedTuple):
    """The system of half a cross-section, a metre long.

    - ``system``, ``section``: of it; ``wall``: its elements, ``material``: theirs.
    - ``strength``: the size of stresses that matter: yield stress, or the plies' in compression along the fibres [Pa].
    - ``slider``: its node.
    - ``factor``: from its forces and energies to those of the whole tank [m].
    """

    system: System
    section: Section
    wall: Plane
    material: Plastic | Orthotropic
    strength: Scalar
    slider: int
    factor: Scalar


def assembled(design: TankDrop, scenario: TankDropScenario) -> Assembled:
    """The parts put together, nothing loaded yet."""
    seen = section(design, scenario.fill)
    nodes, factor = len(seen.positions), 2.0 * design.tank.length
    slider, baffle = nodes, nodes + 1
    above = design.tank.height + design.cushion.thickness
    bodies = jnp.stack([jnp.stack([jnp.zeros(()), jnp.asarray(above, float)]), jnp.zeros(2)])
    positions = jnp.concatenate([seen.positions, bodies])
    material = _material(design)
    wall = Plane(Quads.of(positions, seen.corners, ACROSS), material)
    inverse = 1.0 / wall.mass()[:nodes]
    middle = np.concatenate([np.arange(design.mesh.refinement + 1), np.arange(nodes)[-design.mesh.refinement - 1 :]])
    inverse = jnp.repeat(inverse[:, None], 2, axis=1).at[middle, 0].set(0.0)
    held = jnp.stack([jnp.zeros(()), factor / jnp.asarray(design.slider.mass, float)])
    inverse = jnp.concatenate([inverse, held[None], jnp.zeros((1, 2))])
    liquid = static = None
    if design.contents.kind == "liquid":
        liquid = _liquid(design, seen)
        surface = seen.liquid[seen.free[0], 1]
        static = design.contents.density * scenario.gravity * (surface - seen.liquid[:, 1])
    system = System(
        positions,
        inverse,
        (wall,),
        (_support(design, seen, baffle),),
        (_cushion(design, seen, slider),),
        jnp.stack([jnp.zeros(()), -jnp.asarray(scenario.gravity, float)]),
        None,
        liquid,
        static,
    )
    return Assembled(system, seen, wall, material, _strength(design), slider, factor)


def _material(design: TankDrop) -> Plastic | Orthotropic:
    if design.material.kind == "composite":
        return equivalent(design.composite)
    material = design.material
    return Plastic(
        material.density,
        material.young_modulus,
        material.poisson_ratio,
        material.yield_stress,
        material.hardening,
        material.failure_strain,
    )


def _strength(design: TankDrop) -> Scalar:
    return design.composite.along_compression if design.material.kind == "composite" else design.material.yield_stress


def _support(design: TankDrop, seen: Section, baffle: int) -> Contact:
    """The outside, up to the level, on the baffle."""
    slaves = seen.outer[: seen.level]
    strips = jnp.linalg.norm(boundary_areas(seen.positions[slaves]), axis=1)
    return Contact(slaves, RigidPlane(baffle, (0.0, 1.0)), design.support.method, design.support.stiffness * strips)


def _cushion(design: TankDrop, seen: Section, slider: int) -> Layer:
    """The cushion over the outside from the level on."""
    slaves = seen.outer[seen.level :]
    width = jnp.abs(boundary_areas(seen.positions[slaves])[:, 1])
    soft = design.cushion
    return Layer(
        slaves,
        RigidPlane(slider, (0.0, -1.0)),
        width,
        soft.thickness,
        soft.stiffness,
        soft.damping,
        SOLID * soft.stiffness,
    )


def _liquid(design: TankDrop, seen: Section) -> Liquid:
    corners, count = seen.liquid_corners, len(seen.liquid)
    stiffness, mass = element_matrices(seen.liquid, corners, design.contents.sound_speed)
    incidence = Incidence.of(corners, count)
    return Liquid(
        incidence,
        stiffness,
        incidence.to_nodes(jnp.sum(mass, axis=2)),
        jnp.ones(count).at[seen.free].set(0.0),
        jnp.asarray(design.contents.density, float),
        seen.inner[: seen.level + 1],
        seen.wet,
        boundary_areas(seen.positions[seen.inner[: seen.level + 1]]),
    )


def at_rest(parts: Assembled) -> State:
    """The tank in equilibrium with gravity and the liquid's static pressure, its flat bottom on the baffle where it
    presses on it, or as deep in it as a penalty lets it; the slider where the cushion would just touch the tank
    undeformed. Newton's method finds it; derivatives are those of the equilibrium."""
    system, seen = parts.system, parts.section
    start = system.start()
    nodes = parts.slider
    free = np.ones((nodes + 2, 2), bool)
    free[nodes:] = False
    middle = np.concatenate([np.arange(seen.inner[1]), np.arange(seen.inner[-1], nodes)])
    free[middle, 0] = False
    places = np.flatnonzero(free.ravel())
    bottom = np.searchsorted(places, 2 * seen.outer[: seen.flat + 1] + 1)
    load = system.mass * system.gravity[None]
    if system.liquid is not None:
        assert system.static_pressure is not None
        load = load + system.liquid.push(system.static_pressure, nodes + 2)
    wall, (history,), (contact,) = parts.wall, start.histories, system.contacts

    def displaced(moves: Array) -> Array:
        return jnp.zeros(free.size).at[places].set(moves).reshape(free.shape)

    def unbalanced(moves: Array) -> Array:
        return (wall.resist(displaced(moves), history).forces - load).ravel()[places]

    corners = 2 * wall.quads.incidence.corners[:, :, None] + np.arange(2)
    rows = corners.reshape(-1, 8)

    def newton(moves: Array, stands: Array) -> tuple[Array, Array]:
        """Better displacements where these bottom nodes stand, and which stand then: pressed, or below the baffle."""
        whole = (
            jnp.zeros((free.size, free.size)).at[rows[:, :, None], rows[:, None]].add(wall.stiffness(displaced(moves)))
        )
        matrix, left = whole[np.ix_(places, places)], unbalanced(moves)
        if contact.method == "penalty":
            stiffness = jnp.asarray(contact.stiffness)[: len(bottom)]
            bed = jnp.zeros(len(places)).at[bottom].set(jnp.where(stands, stiffness, 0.0))
            after = moves - jnp.linalg.solve(matrix + jnp.diag(bed), left + bed * moves)
            return after, after[bottom] < 0.0
        held = jnp.zeros(len(places), bool).at[bottom].set(stands)
        change = jnp.linalg.solve(jnp.where(held[:, None], jnp.eye(len(places)), matrix), -jnp.where(held, moves, left))
        after, pressed = moves + change, (left + matrix @ change)[bottom]
        return after, jnp.where(stands, pressed > 0.0, after[bottom] < 0.0)

    nowhere = jnp.zeros(len(places)), jnp.ones(len(bottom), bool)
    found, stands = jax.lax.fori_loop(0, ITERATIONS + len(bottom), lambda _, at: newton(*at), nowhere)
    return start._replace(displacement=displaced(newton(jax.lax.stop_gradient(found), stands)[0]))


def falling(parts: Assembled, scenario: TankDropScenario) -> State:
    """The same with the slider at the speed of its fall."""
    state = at_rest(parts)
    speed = jnp.sqrt(2.0 * scenario.gravity * scenario.height)
    return state._replace(velocity=state.velocity.at[parts.slider, 1].set(-speed))
