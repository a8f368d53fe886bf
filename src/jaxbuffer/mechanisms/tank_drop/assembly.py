"""The drop onto a tank from parts: wall, liquid, cushion, slider and baffle (M166)."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._types import Scalar
from ...structures import Liquid, Orthotropic, Plane, Plastic, Quads, System
from ...structures.acoustics import Cover, element_matrices
from ...structures.boundary import boundary_areas, enclosed
from ...structures.contact import Contact, Layer, RigidPlane
from ...structures.gas import Gas
from ...structures.incidence import Incidence
from ...structures.perforated import Holes, Perforated, at_heights
from .design import TankDrop, TankDropScenario
from .laminate import equivalent
from .numbering import Numbering
from .section import Section, section

SOLID = 10.0  # stiffness of the solid cushion over that of the soft one
ACROSS = 4  # integration points from one side of an element to the other


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

    def compression(self, positions: Float[Array, "nodes 2"]) -> Float[Array, " pressed"]:
        """How far the cushion is pressed together at each node below it; without one, the wall into the slider [m]."""
        if self.system.layers:
            return self.system.layers[0].compression(positions)
        strike = self.system.contacts[1]
        return -strike.surface.pairs(strike.slaves, positions, None).gap


def assembled(design: TankDrop, scenario: TankDropScenario) -> Assembled:
    """The parts put together, nothing loaded yet."""
    seen = section(design, scenario.fill)
    nodes, factor = len(seen.positions), 2.0 * design.tank.length
    slider, baffle = nodes, nodes + 1
    above = design.tank.height + (design.cushion.thickness if design.cushion.kind == "layer" else 0.0)
    bodies = jnp.stack([jnp.stack([jnp.zeros(()), jnp.asarray(above, float)]), jnp.zeros(2)])
    positions = jnp.concatenate([seen.positions, bodies])
    material = _material(design)
    quads, density = Quads.of(positions, seen.numbers.corners, ACROSS), material.density
    if len(seen.numbers.ribs):
        quads, density = _with_ribs(design, quads)
    wall = Plane(quads, material)
    liquid = static = None
    mass = jnp.repeat(quads.lumped_mass(density)[:nodes, None], 2, axis=1)
    if design.contents.kind != "none":
        liquid = _liquid(design, seen)
        surface = seen.liquid[seen.numbers.liquid[0, -1], 1]
        static = design.contents.density * scenario.gravity * (surface - seen.liquid[:, 1])
        if liquid.plate is not None:
            mass = mass.at[liquid.plate.plate, 0].add(liquid.plate.added_mass())
    inverse = (1.0 / mass).at[seen.numbers.middle, 0].set(0.0)
    held = jnp.stack([jnp.zeros(()), factor / jnp.asarray(design.slider.mass, float)])
    inverse = jnp.concatenate([inverse, held[None], jnp.zeros((1, 2))])
    system = System(
        positions,
        inverse,
        (wall,),
        (_support(design, seen, baffle), *([] if design.cushion.kind == "layer" else [_strike(design, seen, slider)])),
        (_cushion(design, seen, slider),) if design.cushion.kind == "layer" else (),
        jnp.stack([jnp.zeros(()), -jnp.asarray(scenario.gravity, float)]),
        None,
        liquid,
        static,
        _air(design, seen) if design.contents.air == "trapped" and not seen.numbers.full else None,
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


def _with_ribs(design: TankDrop, quads: Quads) -> tuple[Quads, Float[Array, " elements"]]:
    """Elements of which the ribs' are as deep as their share of a metre and, as narrow ribs are free to narrow along
    the tank and plane elements are not, 1 - ν² of that; densities that give them their whole mass (M168)."""
    narrowed = 1.0 - jnp.asarray(design.material.poisson_ratio, float) ** 2
    last = np.arange(len(quads.weight)) >= len(quads.weight) - Numbering.of(design).ribs[1:, 1:].size
    depth = jnp.where(last, narrowed * design.ribs.share, 1.0)
    density = design.material.density * jnp.where(last, 1.0 / narrowed, 1.0)
    return quads._replace(weight=quads.weight * depth[:, None]), density


def _strength(design: TankDrop) -> Scalar:
    return design.composite.along_compression if design.material.kind == "composite" else design.material.yield_stress


def _support(design: TankDrop, seen: Section, baffle: int) -> Contact:
    """The outside, up to the level, on the baffle."""
    slaves = seen.numbers.outer[: seen.numbers.level]
    strips = jnp.linalg.norm(boundary_areas(seen.positions[slaves]), axis=1)
    return Contact(slaves, RigidPlane(baffle, (0.0, 1.0)), design.support.method, design.support.stiffness * strips)


def _strike(design: TankDrop, seen: Section, slider: int) -> Contact:
    """The slider without a cushion, on the outside from the level on, by the method of the support."""
    slaves = seen.numbers.outer[seen.numbers.level :]
    strips = jnp.linalg.norm(boundary_areas(seen.positions[slaves]), axis=1)
    return Contact(slaves, RigidPlane(slider, (0.0, -1.0)), design.support.method, design.support.stiffness * strips)


def _air(design: TankDrop, seen: Section) -> Gas:
    """The air that is shut in above the liquid."""
    wall = seen.positions[seen.numbers.inner]
    below = 0.0 if design.contents.kind == "none" else enclosed(seen.liquid[seen.numbers.wet])
    return Gas(seen.numbers.inner, enclosed(wall) - below, enclosed(wall), design.contents.air_pressure)


def _cushion(design: TankDrop, seen: Section, slider: int) -> Layer:
    """The cushion over the outside from the level on."""
    slaves = seen.numbers.outer[seen.numbers.level :]
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
    corners, count = seen.numbers.liquid_corners, len(seen.liquid)
    stiffness, mass = element_matrices(seen.liquid, corners, design.contents.sound_speed)
    incidence = Incidence.of(corners, count)
    cover = None
    if not seen.numbers.full:
        surface = seen.numbers.free
        above = seen.numbers.inner[seen.numbers.level :][::-1]
        cover = Cover.of(surface, seen.liquid[surface], above, seen.positions[above])
    return Liquid(
        incidence,
        stiffness,
        incidence.to_nodes(jnp.sum(mass, axis=2)),
        jnp.ones(count).at[seen.numbers.free].set(0.0),
        jnp.asarray(design.contents.density, float),
        seen.numbers.wetted,
        seen.numbers.wet,
        boundary_areas(seen.positions[seen.numbers.wetted]),
        follows=seen.numbers.full,
        cover=cover,
        plate=_holes(design, seen) if seen.numbers.plate_side >= 0 else None,
    )


def _holes(design: TankDrop, seen: Section) -> Perforated:
    """The plate as the liquid feels it."""
    plates, numbers, side = design.plates, seen.numbers, seen.numbers.plate_side
    assert plates.aperture is not None
    left, right = numbers.liquid[side], numbers.liquid[side + 1]
    middle = 0.5 * (seen.liquid[left] + seen.liquid[right])
    rows = jnp.mean(seen.positions[numbers.plate, 1], axis=1)
    return Perforated(
        left,
        right,
        boundary_areas(middle)[:, 0],
        numbers.plate,
        at_heights(middle[:, 1], rows),
        Holes.of(plates.thickness, plates.hole_diameter, plates.aperture),
        jnp.asarray(design.contents.density, float),
    )
