"""The nodes and elements of the tank's mesh as numbers: what no dimension changes."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Int

from .design import TankDrop

BOTTOM, CORNER, WET, DRY = 13, 4, 10, 16  # elements along the wall: flat bottom, corner, up to the level, from there on
WITHIN, BEYOND, ABOVE = 7, 5, 8  # of BOTTOM and of DRY, where a plate takes one: within it, beyond it, up to it
SIDE, HALFWAY = 9, 5  # of a tank that is full: along the side, and up to where the support ends; the rest as below
UPRIGHT = 14  # elements along a plate


class Numbering(NamedTuple):
    """The numbers of nodes and elements of half of the cross-section.

    - ``wall``: (columns, across) its nodes: along it from the middle of the bottom on, in a column from the inside out.
    - ``plate``: (rows, across) the plate's nodes, upwards, from the middle of the tank on; no rows without one. Its
      first row and its last are the wall's.
    - ``ribs``: (columns, across) the ribs' nodes as the wall's; their last are the wall's inner ones.
    - ``corners``: (elements, 4) the elements' nodes, counter-clockwise, column by column, those of plate or ribs last;
      the first own axis of each goes along the wall or the plate.
    - ``flat``, ``level``: the columns where the flat bottom ends, and at the liquid's surface; half way up where the
      tank is full.
    - ``corner``, ``upper``: the columns at the lower and the upper right corner of the liquid's block.
    - ``full``: whether the liquid fills the tank, without a surface.
    - ``liquid``: (across, up) the liquid's nodes, counted for themselves, from the middle of the bottom on; none
      between the faces of a plate that it feels.
    - ``plate_side``: which of these columns is on the inner face of such a plate, the next being on the outer one; -1
      without.
    """

    wall: Int[np.ndarray, "columns across"]
    plate: Int[np.ndarray, "rows across"]
    ribs: Int[np.ndarray, "ribs across"]
    corners: Int[np.ndarray, "elements 4"]
    flat: int
    level: int
    corner: int
    upper: int
    full: bool
    liquid: Int[np.ndarray, "across up"]
    plate_side: int

    @staticmethod
    def of(design: TankDrop) -> "Numbering":
        """Return a numbering as fine as the design says."""
        fine = design.mesh.refinement
        full = design.contents.kind == "full"
        flat, level = fine * BOTTOM, fine * (BOTTOM + CORNER + (HALFWAY if full else WET))
        columns, across = fine * (BOTTOM + CORNER + WET + DRY) + 1, fine + 1
        wall = np.arange(columns * across).reshape(columns, across)
        plate = np.zeros((0, across), int)
        if design.plates.kind != "none":
            # A plate has as many elements across as the wall, and stands on nodes of the wall's inside.
            foot = wall[fine * WITHIN :][:across, 0]
            # Along the top the wall runs back to the middle: reversed, the head's nodes stand over the foot's.
            head = wall[columns - 1 - fine * (WITHIN + 1) :][:across, 0][::-1]
            between = columns * across + np.arange((fine * UPRIGHT - 1) * across).reshape(-1, across)
            plate = np.concatenate([foot[None], between, head[None]])
        ribs = np.zeros((0, across), int)
        if design.ribs.kind != "none":
            ribs = np.hstack([wall.size + np.arange(columns * fine).reshape(columns, fine), wall[:, :1]])
        corners = np.concatenate([_elements(nodes) for nodes in (wall, plate, ribs)])
        corner = flat + fine * CORNER // 2
        upper = columns - 1 - corner if full else level
        felt = design.plates.kind != "none" and design.plates.aperture is not None
        # Between the faces of a plate that it feels the liquid has no nodes.
        blocks = corner + 1 - (fine - 1 if felt else 0), upper - corner + 1
        liquid = np.arange(np.prod(blocks)).reshape(blocks)
        side = fine * WITHIN if felt else -1
        return Numbering(wall, plate, ribs, corners, flat, level, corner, upper, full, liquid, side)

    @property
    def inner(self) -> Int[np.ndarray, " columns"]:
        """Return the wall's nodes on its inside."""
        return self.wall[:, 0]

    @property
    def outer(self) -> Int[np.ndarray, " columns"]:
        """Return the wall's nodes on its outside."""
        return self.wall[:, -1]

    @property
    def middle(self) -> Int[np.ndarray, " nodes"]:
        """Return the wall's and the ribs' nodes in the middle of the section, which do not move sideways."""
        both = np.hstack([self.ribs[:, :-1], self.wall]) if len(self.ribs) else self.wall
        return both[[0, -1]].ravel()

    @property
    def liquid_corners(self) -> Int[np.ndarray, "elements 4"]:
        """Return the liquid's nodes at the corners of its elements, counter-clockwise."""
        sides = [self.liquid[:-1, :-1], self.liquid[1:, :-1], self.liquid[1:, 1:], self.liquid[:-1, 1:]]
        elements = np.stack(sides, axis=-1)
        if self.plate_side >= 0:
            # Between the faces of such a plate there is no liquid.
            elements = np.delete(elements, self.plate_side, axis=0)
        return elements.reshape(-1, 4)

    @property
    def wet(self) -> Int[np.ndarray, " wet"]:
        """Return the liquid's nodes along the wall, from the middle of the bottom to the level or the middle of the
        top."""
        top = self.liquid[-2::-1, -1] if self.full else self.liquid[:0, -1]
        return np.concatenate([self.liquid[:, 0], self.liquid[-1, 1:], top])

    @property
    def free(self) -> Int[np.ndarray, " free"]:
        """Return the liquid's nodes on its surface, none where the tank is full."""
        return self.liquid[:0, -1] if self.full else self.liquid[:, -1]

    @property
    def wetted(self) -> Int[np.ndarray, " wet"]:
        """Return the wall's nodes in the places of `wet`."""
        within = self.within_plate
        if self.full:
            within = np.concatenate([within, len(self.inner) - 1 - within])
        columns = len(self.inner) if self.full else self.upper + 1
        return np.delete(self.inner[:columns], within)

    @property
    def beside_plate(self) -> Int[np.ndarray, "sides pairs"]:
        """Return the liquid's nodes on the inner and on the outer face of a plate that it feels, upwards."""
        return self.liquid[self.plate_side :][:2] if self.plate_side >= 0 else np.zeros((2, 0), int)

    @property
    def within_plate(self) -> Int[np.ndarray, " columns"]:
        """Return the columns along the bottom between the faces of a plate that the liquid feels."""
        if self.plate_side < 0:
            return np.zeros(0, int)
        return np.arange(self.plate_side + 1, self.plate_side + self.wall.shape[1] - 1)

    def at_a_joint(self, element: int) -> bool:
        """Return whether an element, or its image in the whole section, is where a plate meets the wall, or next to
        that."""
        columns = self.wall[np.isin(self.inner, self.plate[[0, -1]])] if len(self.plate) else self.plate
        return bool(np.isin(self.corners[element % len(self.corners)], columns).any())


def _elements(nodes: np.ndarray) -> np.ndarray:
    """Return the corners of the elements between columns of nodes (columns, across) that follow each other."""
    # `Quads` has its points across between the sides 1-2 and 3-4, which are the wall's outside and inside.
    sides = [nodes[:-1, 1:], nodes[1:, 1:], nodes[1:, :-1], nodes[:-1, :-1]]
    return np.stack(sides, axis=-1).reshape(-1, 4)
