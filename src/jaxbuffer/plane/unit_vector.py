"""The check of an axis that is given as a unit vector."""

from typing import Any

import numpy as np

from ..errors import InputError, concrete

UNIT = 1e-6  # how far its length may be from 1, as of digits that were typed


def check_unit(name: str, x: Any, y: Any) -> None:
    """Raise `InputError` for an axis that is no unit vector: forces along it, and distances, would be in its length.

    **Arguments:** ``name``: of the axis in messages; ``x``, ``y``: numbers or arrays; of traced ones nothing is known.
    """
    known_x, known_y = concrete(x), concrete(y)
    if known_x is None or known_y is None:
        return
    columns = np.broadcast_arrays(np.ravel(known_x), np.ravel(known_y))
    lengths = np.hypot(*columns)
    for x_of, y_of, length in zip(*columns, lengths, strict=True):
        if not abs(length - 1.0) <= UNIT:
            raise InputError(
                f"{name} ({x_of:g}, {y_of:g}) is no unit vector; its length is {length:g}: divide both by that"
            )
