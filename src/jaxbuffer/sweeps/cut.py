"""Arrays cut into the blocks of a store."""

import dataclasses
import itertools
import math

import numpy as np

Region = tuple[slice, ...]


@dataclasses.dataclass(frozen=True)
class Cut:
    """How arrays are cut: ``sizes`` of all, ``block`` of one. Blocks have numbers from 0."""

    sizes: tuple[int, ...]
    block: tuple[int, ...]

    def __len__(self) -> int:
        return math.prod(self.counts)

    @property
    def counts(self) -> tuple[int, ...]:
        """Return the number of blocks along each axis."""
        return tuple(-(-size // length) for size, length in zip(self.sizes, self.block, strict=True))

    def numbers(self, places: np.ndarray) -> np.ndarray:
        """Return the numbers of the blocks that hold the runs at these ``places`` in the arrays of all."""
        corners = [
            place // length for place, length in zip(np.unravel_index(places, self.sizes), self.block, strict=True)
        ]
        return np.unique(np.ravel_multi_index(corners, self.counts))

    def corner(self, number: int) -> tuple[int, ...]:
        """Return a block's place among the blocks, along each axis."""
        return tuple(map(int, np.unravel_index(number, self.counts)))

    def region(self, number: int) -> Region:
        """Return the region of the arrays of all that a block covers."""
        starts = [place * length for place, length in zip(self.corner(number), self.block, strict=True)]
        # The last block along an axis may be shorter than the others.
        ends = [min(a + n, size) for a, n, size in zip(starts, self.block, self.sizes, strict=True)]
        return tuple(itertools.starmap(slice, zip(starts, ends, strict=True)))

    def shape(self, number: int) -> tuple[int, ...]:
        """Return the shape of a block's arrays."""
        return tuple(part.stop - part.start for part in self.region(number))


def box(sizes: list[int], most: int) -> tuple[int, ...]:
    """Return the lengths of a box of at most ``most`` cells in an array of these sizes.

    The box is longest along its last axes, along which runs are neighbours in the result.
    """
    lengths: list[int] = []
    for size in reversed(sizes):
        room = max(1, most // math.prod(lengths))
        # Equal pieces in place of full ones and a rest: all blocks take about the same time.
        pieces = -(-size // min(size, room))
        lengths.append(-(-size // pieces))
    return tuple(reversed(lengths))
