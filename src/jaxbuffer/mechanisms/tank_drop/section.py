"""The tank's cross-section as a mesh: wall and liquid, whose nodes move smoothly with every dimension and the fill."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._types import Scalar, stacked
from .design import ZONES, TankDrop
from .node_sets import NodeSets, mirrors
from .numbering import ABOVE, BEYOND, BOTTOM, CORNER, DRY, SIDE, WET, WITHIN, Numbering

TAPER = 0.02  # m, over which the thickness goes from one zone's to the next one's


class Section(NamedTuple):
    """Half of the cross-section, to the right of its middle, or the whole.

    - ``numbers``: of the half's nodes and elements; ``sets``: of all there are, the half's first.
    - ``positions``: (nodes, 2) of wall and plate [m]; ``liquid``: (liquid nodes, 2) of the liquid [m].
    """

    numbers: Numbering
    sets: NodeSets
    positions: Float[Array, "nodes 2"]
    liquid: Float[Array, "liquid 2"]


def section(design: TankDrop, fill: Scalar) -> Section:
    """Return the mesh. ``fill``: height of the liquid over the inner height [-]."""
    numbers = Numbering.of(design)
    along = _columns(design, fill)
    face, normal = _outside(design, along)
    thickness = thickness_at(design, along)
    # From the inside out, as columns are numbered; the outside stays where the tank's dimensions put it.
    shares = np.linspace(1.0, 0.0, design.mesh.refinement + 1)
    positions = (face[:, None] - (thickness[:, None] * shares[None])[..., None] * normal[:, None]).reshape(-1, 2)
    if len(numbers.plate):
        foot, head = positions[numbers.plate[0]][None], positions[numbers.plate[-1]][None]
        rows = len(numbers.plate) - 1
        between = foot + (np.arange(1, rows) / rows)[:, None, None] * (head - foot)
        positions = jnp.concatenate([positions, between.reshape(-1, 2)])
    if len(numbers.ribs):
        # A rib's last nodes are the wall's inner ones, which are there already.
        depth = thickness[:, None] + design.ribs.height * shares[None, :-1]
        positions = jnp.concatenate([positions, (face[:, None] - depth[..., None] * normal[:, None]).reshape(-1, 2)])
    liquid = liquid_within(positions, numbers)
    if design.mesh.extent == "whole":
        of_wall, of_liquid = mirrors(numbers)
        positions, liquid = of_wall.vectors(positions), of_liquid.vectors(liquid)
    return Section(numbers, NodeSets.of(design), positions, liquid)


def _columns(design: TankDrop, fill: Scalar) -> Float[Array, " columns"]:
    """Return where along the outside there are nodes [m]: flat bottom, corner, up to the level and from there on, each
    divided evenly; with columns on both faces of a plate."""
    ends = _lengths(design)
    full = design.contents.kind == "full"
    middle = [ends[1], ends[2], ends[3]] if full else [ends[1], _level(design, fill)]
    above = [SIDE, CORNER] if full else [WET]
    marks = [0.0, ends[0], *middle, ends[-1]]
    counts = [BOTTOM, CORNER, *above, BOTTOM if full else DRY]
    if design.plates.kind != "none":
        at, half = design.plates.position, 0.5 * design.plates.thickness
        faces = [at - half, at + half]
        marks = [0.0, *faces, ends[0], *middle, ends[-1] - faces[1], ends[-1] - faces[0], ends[-1]]
        counts = [WITHIN, 1, BEYOND, CORNER, *above, BEYOND if full else ABOVE, 1, WITHIN]
    parts = [
        a + (b - a) * np.linspace(0.0, 1.0, design.mesh.refinement * count, endpoint=False)
        for a, b, count in zip(marks, marks[1:], counts, strict=False)
    ]
    return jnp.concatenate([*parts, stacked([ends[-1]])])


def liquid_within(wall: Float[Array, "nodes 2"], numbers: Numbering) -> Float[Array, "liquid 2"]:
    """Return the liquid's nodes [m] between the ``wall``'s, the middle and any surface, by transfinite
    interpolation."""
    edge, corner = wall[numbers.inner], numbers.corner
    bottom, right = edge[: corner + 1], edge[corner : numbers.upper + 1]
    xi = (np.arange(corner + 1) / corner)[:, None, None]
    eta = (np.arange(len(right)) / (len(right) - 1))[None, :, None]
    top = jnp.stack([xi[:, 0, 0] * right[-1, 0], jnp.full(corner + 1, 1.0) * right[-1, 1]], axis=1)
    if numbers.full:
        # The wall runs back to the middle along the top, and the liquid's rows run away from it.
        top = edge[numbers.upper :][::-1]
    left = jnp.stack([0.0 * right[:, 1], bottom[0, 1] + eta[0, :, 0] * (top[0, 1] - bottom[0, 1])], axis=1)
    sides = (1.0 - xi) * left[None] + xi * right[None]
    ends = (1.0 - eta) * bottom[:, None] + eta * top[:, None]
    corner_at = lambda points, k: points[k][None, None]  # noqa: E731
    knots = (1.0 - xi) * ((1.0 - eta) * corner_at(left, 0) + eta * corner_at(left, -1)) + xi * (
        (1.0 - eta) * corner_at(right, 0) + eta * corner_at(right, -1)
    )
    # Each ruled surface has the corners: together they have them twice (Coons' patch).
    nodes = sides + ends - knots
    if numbers.plate_side >= 0:
        nodes = jnp.delete(_beside_plate(nodes, numbers), numbers.within_plate, axis=0, assume_unique_indices=True)
    return nodes.reshape(-1, 2)


def _beside_plate(nodes: Float[Array, "across up 2"], numbers: Numbering) -> Float[Array, "across up 2"]:
    """Return the liquid's nodes moved sideways, evenly less with the distance, so that two columns lie on the faces of
    a plate that is straight from the bottom to the top."""
    first, last = numbers.plate_side, numbers.plate_side + numbers.wall.shape[1] - 1
    # Each face is moved with the other one at rest, so that the second move leaves the first column on its face.
    for face, others in ((first, [0, first, last]), (last, [first, last, numbers.corner])):
        high = nodes[face, :, 1]
        # Under a surface the liquid ends below the plate's head: its column stands upright over the foot.
        ends = [nodes[face, 0], nodes[face, -1] if numbers.full else nodes[face, 0]]
        share = (high - high[0]) / (high[-1] - high[0])
        off = ends[0][0] + share * (ends[1][0] - ends[0][0]) - nodes[face, :, 0]
        weight = np.interp(np.arange(len(nodes)), others, [0.0, 1.0, 0.0])
        nodes = nodes.at[:, :, 0].add(weight[:, None] * off[None])
    return nodes


def _lengths(design: TankDrop) -> list[Scalar]:
    """Return where along the outside, from the middle of the bottom, its straight parts and corners end [m]."""
    width, height, radius = design.tank.width, design.tank.height, design.tank.corner_radius
    flat, arc, side = 0.5 * width - radius, 0.5 * np.pi * radius, height - 2.0 * radius
    return [flat, flat + arc, flat + arc + side, flat + 2.0 * arc + side, 2.0 * flat + 2.0 * arc + side]


def _level(design: TankDrop, fill: Scalar) -> Float[Array, ""]:
    """Return where along the outside the inner wall is as high as the liquid [m]."""
    height, radius, wall = design.tank.height, design.tank.corner_radius, design.wall
    level = wall.bottom + fill * (height - wall.bottom - wall.top)
    ends = _lengths(design)
    on_side = ends[1] + (level - radius)
    inner = radius - wall.upper_corner
    # At 1 the slope of the arc sine is infinite.
    sine = jnp.clip((level - (height - radius)) / inner, 0.0, 1.0 - 1e-6)
    in_corner = ends[2] + radius * jnp.arcsin(sine)
    return jnp.where(level < height - radius, on_side, in_corner)


def _outside(design: TankDrop, along: Float[Array, " columns"]) -> tuple[Array, Array]:
    """Return positions (columns, 2) [m] and outward normals of the outside."""
    height, radius = design.tank.height, design.tank.corner_radius
    ends = _lengths(design)
    quarter = 0.5 * np.pi
    turned = jnp.clip((along - ends[0]) / radius, 0.0, quarter) + jnp.clip((along - ends[2]) / radius, 0.0, quarter)
    normal = jnp.stack([jnp.sin(turned), -jnp.cos(turned)], axis=1)
    x = jnp.minimum(along, ends[0]) - jnp.maximum(along - ends[3], 0.0)
    y = jnp.clip(along - ends[1], 0.0, height - 2.0 * radius)
    return jnp.stack([x, radius + y], axis=1) + radius * normal, normal


def thickness_at(design: TankDrop, along: Float[Array, " columns"]) -> Float[Array, " columns"]:
    """Return the wall's thickness [m], linear over the tapers where zones meet (M168)."""
    ends = _lengths(design)
    meet = [ends[0], ends[1], 0.5 * (ends[1] + ends[2]), ends[2], ends[3]]
    values = [getattr(design.wall, zone) for zone in ZONES]
    total = jnp.full(along.shape, 1.0) * values[0]
    for at, before, after in zip(meet, values, values[1:], strict=False):
        total = total + (after - before) * jnp.clip((along - at) / TAPER + 0.5, 0.0, 1.0)
    return total


def wall_area(design: TankDrop) -> Float[Array, ""]:
    """Return the area of half of the wall's cross-section [m²], by its middle surface, with the ribs' by theirs and
    their share."""
    ends = _lengths(design)
    # By quadrature: elements have chords for the corners' arcs, and their mass would change with the mesh.
    along = jnp.linspace(0.0, 1.0, 2001) * ends[-1]
    thickness = thickness_at(design, along)
    curved = ((along > ends[0]) & (along < ends[1])) | ((along > ends[2]) & (along < ends[3]))
    bent = jnp.where(curved, 1.0 / design.tank.corner_radius, 0.0)
    # Round a corner the middle surface is shorter than the outside.
    strip = thickness * (1.0 - 0.5 * thickness * bent)
    if design.ribs.kind != "none":
        high = design.ribs.height
        strip = strip + design.ribs.share * high * (1.0 - (thickness + 0.5 * high) * bent)
    return jnp.trapezoid(strip, along)


def plate_area(design: TankDrop) -> Scalar:
    """Return the area of the plate in half of the cross-section [m²]."""
    if design.plates.kind == "none":
        return 0.0
    return design.plates.thickness * (design.tank.height - design.wall.bottom - design.wall.top)


def wall_mass(design: TankDrop) -> Float[Array, ""]:
    """Return the mass of the whole tank's wall, ribs and plates, without its ends [kg]."""
    made_of = design.composite if design.material.kind == "composite" else design.material
    return 2.0 * made_of.density * (wall_area(design) + plate_area(design)) * design.tank.length
