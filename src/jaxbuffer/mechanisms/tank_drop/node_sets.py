"""Which nodes take which part in the model: those of half of the section or, with its mirror image, of the whole."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from .design import TankDrop
from .numbering import Numbering

FLIP = np.array([[-1.0, 1.0]])


class Mirror(NamedTuple):
    """The nodes of a half, which come first in the whole, and their images, which follow.

    - ``image``: (half,) the image of each node of the half; a node in the middle is its own.
    - ``others``: the nodes that are not in the middle, in the order of their images.
    """

    image: Int[np.ndarray, " half"]
    others: Int[np.ndarray, " others"]

    @staticmethod
    def of(corners: np.ndarray, middle: np.ndarray) -> "Mirror":
        """Return the mirror of the elements' nodes (elements, 4), of which those in the ``middle`` are their own
        images."""
        image = np.arange(1 + corners.max())
        others = np.setdiff1d(image, middle)
        image[others] = len(image) + np.arange(len(others))
        return Mirror(image, others)

    def vectors(self, half: Float[Array, "half 2"]) -> Float[Array, "whole 2"]:
        """Return positions or displacements of the whole, from those of its right half [m]."""
        return jnp.concatenate([half, half[self.others] * FLIP])

    def elements(self, corners: np.ndarray) -> Int[np.ndarray, "elements 4"]:
        """Return the half's elements, then their images, counter-clockwise; sides 1-2 and 3-4 keep their places."""
        # A mirror image runs clockwise: exchanging neighbours turns it round.
        return np.concatenate([corners, self.image[corners][:, [1, 0, 3, 2]]])

    def across(self, nodes: np.ndarray) -> np.ndarray:
        """Return nodes from the middle outwards, continued to the other side: from there to this one's last."""
        return np.concatenate([self.image[nodes][::-1], nodes[1:]])

    def onwards(self, nodes: np.ndarray) -> np.ndarray:
        """Return nodes that end in the middle, continued on the other side, back to the image of the first."""
        return np.concatenate([nodes, self.image[nodes][::-1][1:]])


class NodeSets(NamedTuple):
    """The node sets of half of the section, or of the whole. Nodes that bound an area have it on their left.

    - ``corners``, ``liquid_corners``: (elements, 4) the elements' nodes, counter-clockwise; the whole's are the half's
      and then, in the same order, their images.
    - ``inner``, ``outer``: the wall's nodes inside and outside: from the middle of the bottom to that of the top or, of
      the whole, all the way round.
    - ``plate``: (rows, across) of the right plate upwards and, of the whole, of the left one downwards.
    - ``on_axis``: nodes in the middle, which symmetry holds sideways; none of the whole.
    - ``support``, ``pressed``: of ``outer``, those that the baffle may meet, and the slider.
    - ``wet``, ``wetted``: nodes of liquid and wall in the same places; ``free``: of the surface, from left to right.
    - ``above``: of ``inner``, those above the surface, from left to right.
    - ``left_of_plate``, ``right_of_plate``: the liquid's nodes beside the plates that it feels, in the order of these.
    """

    corners: Int[np.ndarray, "elements 4"]
    liquid_corners: Int[np.ndarray, "liquid_elements 4"]
    inner: Int[np.ndarray, " columns"]
    outer: Int[np.ndarray, " columns"]
    plate: Int[np.ndarray, "rows across"]
    on_axis: Int[np.ndarray, " on_axis"]
    support: Int[np.ndarray, " support"]
    pressed: Int[np.ndarray, " pressed"]
    wet: Int[np.ndarray, " wet"]
    wetted: Int[np.ndarray, " wet"]
    free: Int[np.ndarray, " free"]
    above: Int[np.ndarray, " above"]
    left_of_plate: Int[np.ndarray, " pairs"]
    right_of_plate: Int[np.ndarray, " pairs"]

    @staticmethod
    def of(design: TankDrop) -> "NodeSets":
        """Return the sets of what ``mesh.extent`` says."""
        numbers = Numbering.of(design)
        half = NodeSets(
            corners=numbers.corners,
            liquid_corners=numbers.liquid_corners,
            inner=numbers.inner,
            outer=numbers.outer,
            plate=numbers.plate,
            on_axis=numbers.middle,
            support=numbers.outer[: numbers.level],
            pressed=numbers.outer[numbers.level :],
            wet=numbers.wet,
            wetted=numbers.wetted,
            free=numbers.free,
            above=numbers.inner[numbers.level :][::-1],
            left_of_plate=numbers.beside_plate[0],
            right_of_plate=numbers.beside_plate[1],
        )
        return half._mirrored(*mirrors(numbers)) if design.mesh.extent == "whole" else half

    def _mirrored(self, wall: Mirror, liquid: Mirror) -> "NodeSets":
        return NodeSets(
            corners=wall.elements(self.corners),
            liquid_corners=liquid.elements(self.liquid_corners),
            inner=wall.onwards(self.inner),
            outer=wall.onwards(self.outer),
            plate=np.concatenate([self.plate, wall.image[self.plate][::-1]]),
            # Nothing holds the whole section sideways.
            on_axis=self.on_axis[:0],
            support=wall.across(self.support),
            pressed=wall.onwards(self.pressed),
            wet=liquid.across(self.wet),
            wetted=wall.across(self.wetted),
            free=liquid.across(self.free),
            above=wall.across(self.above),
            # A mirror image exchanges left and right, and the left plate is followed downwards.
            left_of_plate=np.concatenate([self.left_of_plate, liquid.image[self.right_of_plate][::-1]]),
            right_of_plate=np.concatenate([self.right_of_plate, liquid.image[self.left_of_plate][::-1]]),
        )


def mirrors(numbers: Numbering) -> tuple[Mirror, Mirror]:
    """Return the mirrors of the wall's nodes, with those of plates and ribs, and of the liquid's."""
    return Mirror.of(numbers.corners, numbers.middle), Mirror.of(numbers.liquid_corners, numbers.liquid[0])
