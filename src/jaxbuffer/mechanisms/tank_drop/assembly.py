"""The drop onto a tank from parts: wall, liquid, cushion, slider and baffle (M166)."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax.scipy.linalg import block_diag
from jaxtyping import Array, Float

from ..._types import Scalar, stacked
from ...fields import replace
from ...structures import FiniteElementSystem, Liquid, Orthotropic, Plane, Plastic, Quads
from ...structures.acoustics import Cover, element_matrices
from ...structures.boundary import boundary_areas, enclosed
from ...structures.contact import Layer, NodeContact, RigidPlane
from ...structures.gas import Gas
from ...structures.incidence import Incidence
from ...structures.perforated import Holes, Perforated, at_heights
from ...structures.system import Instant
from .design import TankDrop, TankDropScenario
from .laminate import equivalent
from .numbering import Numbering
from .section import Section, section

SOLID = 10.0  # stiffness of the solid cushion over that of the soft one
# With two a bent wall would begin to yield only at 1.73 times the moment at which its faces do (see `Quads.of`).
ACROSS = 4  # integration points from one side of an element to the other


class TankModel(NamedTuple):
    """The system of half a cross-section or of the whole, a metre long.

    - ``system``, ``section``: of it; ``wall``: its elements, ``material``: theirs.
    - ``strength``: the size of stresses that matter: yield stress, or the plies' in compression along the fibres [Pa].
    - ``slider``: its node.
    - ``factor``: from its forces and energies to those of the whole tank [m].
    - ``angle``: of the slider's underside, counter-clockwise [rad].
    - ``half``: of the whole, half of it under a slider at no angle; None for a half.
    """

    system: FiniteElementSystem
    section: Section
    wall: Plane
    material: Plastic | Orthotropic
    strength: Scalar
    slider: int
    factor: Scalar
    angle: Scalar
    half: "TankModel | None"

    def compression(self, positions: Float[Array, "nodes 2"]) -> Float[Array, " pressed"]:
        """Return how far the cushion is pressed together at each node below it; without one, the wall into the slider
        [m]."""
        if self.system.layers:
            return self.system.layers[0].compression(positions)
        strike = self.system.contacts[1]
        return -strike.surface.pairs(strike.slaves, positions, None).gap

    def force(self, instant: Instant) -> Float[Array, ""]:
        """Return the upward part of the force on the slider, along its fall [N]: the guide takes the sideways part."""
        (normal,) = [forces.normal for forces in (instant.layers or instant.contacts[1:])]
        return jnp.cos(self.angle) * jnp.sum(normal)


def assembled(design: TankDrop, scenario: TankDropScenario) -> TankModel:
    """Return the parts put together, nothing loaded yet."""
    mesh = section(design, scenario.fill)
    whole = design.mesh.extent == "whole"
    nodes, factor = len(mesh.positions), (1.0 if whole else 2.0) * design.tank.length
    # The rigid bodies come last, so that a slice at the slider's number parts the wall's nodes from them.
    slider, baffle = nodes, nodes + 1
    # Half of a section stands for a symmetric drop: `check_fit` and `valid` refuse an angle there.
    angle = scenario.angle if whole else 0.0
    under = RigidPlane(slider, (jnp.sin(angle), -jnp.cos(angle)) if whole else (0.0, -1.0))
    above = _above(design, mesh, under)
    bodies = jnp.stack([jnp.stack([jnp.zeros(()), jnp.asarray(above, float)]), jnp.zeros(2)])
    positions = jnp.concatenate([mesh.positions, bodies])
    material, strength = _material(design)
    quads, density = Quads.of(positions, mesh.sets.corners, ACROSS), material.density
    if len(mesh.numbers.ribs):
        quads, density = _with_ribs(design, quads)
    wall = Plane(quads, material)
    liquid = static = None
    # Slider and baffle are corners of no element: their lumped mass is zero, and its inverse would be infinite.
    mass = jnp.repeat(quads.lumped_mass(density)[:nodes, None], 2, axis=1)
    if design.contents.kind != "none":
        liquid = _liquid(design, mesh)
        surface = mesh.liquid[mesh.numbers.liquid[0, -1], 1]
        static = design.contents.density * scenario.gravity * (surface - mesh.liquid[:, 1])
        if liquid.plate is not None:
            # Some of the liquid in a plate's holes moves with it (m_h of M204).
            mass = mass.at[liquid.plate.plate, 0].add(liquid.plate.added_mass())
    # An infinite mass holds a node: those on the axis sideways, the slider sideways, the baffle altogether.
    inverse = (1.0 / mass).at[mesh.sets.on_axis, 0].set(0.0)
    # The section carries its share of the slider (M166).
    slider_inverse = jnp.stack([jnp.zeros(()), factor / jnp.asarray(design.slider.mass, float)])
    inverse = jnp.concatenate([inverse, slider_inverse[None], jnp.zeros((1, 2))])
    # Of the outside, up to the level.
    support = _pressed(design, mesh, mesh.sets.support, RigidPlane(baffle, (0.0, 1.0)))
    layers = (_cushion(design, mesh, under),) if design.cushion.kind == "layer" else ()
    system = FiniteElementSystem(
        positions,
        inverse,
        elements=(wall,),
        contacts=(support,) if layers else (support, _pressed(design, mesh, mesh.sets.pressed, under)),
        layers=layers,
        gravity=jnp.stack([jnp.zeros(()), -jnp.asarray(scenario.gravity, float)]),
        liquid=liquid,
        static_pressure=static,
        gas=_air(design, mesh),
    )
    half = assembled(replace(design, {"mesh.extent": "half"}), replace(scenario, {"angle": 0.0})) if whole else None
    return TankModel(system, mesh, wall, material, strength, slider, factor, angle, half)


def _above(design: TankDrop, mesh: Section, under: RigidPlane) -> Scalar:
    """Return how high the slider is where it, or its cushion, just touches the tank [m]."""
    soft = design.cushion.thickness if design.cushion.kind == "layer" else 0.0
    if design.mesh.extent == "half":
        return design.tank.height + soft
    sideways, downwards = under.normal
    x, y = mesh.positions[mesh.sets.pressed].T
    # A gap counts along the underside's normal; the fall that closes it is the gap over the cosine of its angle.
    return (soft - jnp.min(sideways * x + downwards * y)) / -downwards


def _material(design: TankDrop) -> tuple[Plastic | Orthotropic, Scalar]:
    """Return the wall's material and the size of stresses that matter [Pa]."""
    if design.material.kind == "composite":
        return equivalent(design.composite), design.composite.along_compression
    material = design.material
    plastic = Plastic(
        density=material.density,
        young=material.young_modulus,
        poisson=material.poisson_ratio,
        yield_stress=material.yield_stress,
        hardening=material.hardening,
        failure_strain=material.failure_strain,
    )
    return plastic, material.yield_stress


def _with_ribs(design: TankDrop, quads: Quads) -> tuple[Quads, Float[Array, " elements"]]:
    """Return elements of which the ribs' are as deep as their share of a metre and, as narrow ribs are free to narrow
    along the tank and plane elements are not, 1 - ν² of that; and densities that give them their whole mass (M168)."""
    narrowed = 1.0 - jnp.asarray(design.material.poisson_ratio, float) ** 2
    numbers = Numbering.of(design)
    half = len(numbers.corners)
    # The whole's elements are the half's and then their images, each with its ribs last: the remainder finds both.
    last = np.arange(len(quads.weight)) % half >= half - numbers.ribs[1:, 1:].size
    depth = jnp.where(last, narrowed * design.ribs.share, 1.0)
    density = design.material.density * jnp.where(last, 1.0 / narrowed, 1.0)
    return quads._replace(weight=quads.weight * depth[:, None]), density


def _pressed(design: TankDrop, mesh: Section, slaves: np.ndarray, plane: RigidPlane) -> NodeContact:
    """Return the contact of the outside's nodes with a plane by the method of the support: that of the slider, too,
    where it has no cushion."""
    # With a share of the area's stiffness for each node's strip (M167) the contact is as soft on any mesh.
    strips = jnp.linalg.norm(boundary_areas(mesh.positions[slaves]), axis=1)
    return NodeContact(slaves, plane, design.support.method, design.support.stiffness * strips)


def _air(design: TankDrop, mesh: Section) -> Gas | None:
    """Return the air that is shut in above the liquid, if any."""
    # A full tank has no air: the volume that its pressure depends on would be zero.
    if design.contents.air != "trapped" or mesh.numbers.full:
        return None
    wall = mesh.positions[mesh.sets.inner]
    below = 0.0 if design.contents.kind == "none" else enclosed(mesh.liquid[mesh.sets.wet])
    return Gas(mesh.sets.inner, enclosed(wall) - below, enclosed(wall), design.contents.air_pressure)


def _cushion(design: TankDrop, mesh: Section, under: RigidPlane) -> Layer:
    """Return the cushion over the outside from the level on, in strips as wide as what faces it."""
    slaves = mesh.sets.pressed
    # What faces away from the slider carries none of the cushion.
    width = jnp.maximum(-(boundary_areas(mesh.positions[slaves]) @ stacked(under.normal)), 0.0)
    soft = design.cushion
    return Layer(
        slaves,
        under,
        width=width,
        thickness=soft.thickness,
        stiffness=soft.stiffness,
        damping=soft.damping,
        solid=SOLID * soft.stiffness,
    )


def _liquid(design: TankDrop, mesh: Section) -> Liquid:
    corners, count = mesh.sets.liquid_corners, len(mesh.liquid)
    stiffness, mass = element_matrices(mesh.liquid, corners, design.contents.sound_speed)
    incidence = Incidence.of(corners, count)
    cover = None
    if not mesh.numbers.full:
        surface, above = mesh.sets.free, mesh.sets.above
        cover = Cover.of(surface, mesh.liquid[surface], above, mesh.positions[above])
    return Liquid(
        incidence,
        stiffness,
        # Explicit steps take a lumped mass: the sums of its rows (M148).
        incidence.to_nodes(jnp.sum(mass, axis=2)),
        # On the free surface the pressure is zero (M147).
        jnp.ones(count).at[mesh.sets.free].set(0.0),
        jnp.asarray(design.contents.density, float),
        mesh.sets.wetted,
        mesh.sets.wet,
        boundary_areas(mesh.positions[mesh.sets.wetted]),
        # Without a surface to give way any error of the volume would be compressed, so that it is followed exactly.
        follows=mesh.numbers.full,
        cover=cover,
        plate=_holes(design, mesh) if mesh.numbers.plate_side >= 0 else None,
    )


def _holes(design: TankDrop, mesh: Section) -> Perforated:
    """Return the plate, or both, as the liquid feels it."""
    plates, sets, high = design.plates, mesh.sets, mesh.numbers.liquid.shape[1]
    left, right = sets.left_of_plate, sets.right_of_plate
    assert plates.aperture is not None
    middle = 0.5 * (mesh.liquid[left] + mesh.liquid[right])[:high]
    rows = jnp.mean(mesh.positions[mesh.numbers.plate, 1], axis=1)
    area, shares = boundary_areas(middle)[:, 0], at_heights(middle[:, 1], rows)
    if len(left) > high:  # the other one, from its head on
        area, shares = jnp.concatenate([area, area[::-1]]), block_diag(shares, shares[::-1, ::-1])
    return Perforated(
        left,
        right,
        area,
        sets.plate,
        shares,
        Holes.of(plates.thickness, plates.hole_diameter, plates.aperture),
        jnp.asarray(design.contents.density, float),
    )
