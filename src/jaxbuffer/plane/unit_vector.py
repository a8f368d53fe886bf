"""The check of an axis that is given as a unit vector."""

from typing import Any

import numpy as np

from ..errors import InputError, concrete

UNIT = 1e-6  # how far its length may be from 1, as of digits that were typed


def check_unit(name: str, *entries: Any) -> None:
    """Raise `InputError` for an axis that is no unit vector: forces along it, and distances, would be in its length.

    **Arguments:** ``name``: of the axis in messages; ``entries``: its components, numbers or arrays; of traced ones
    nothing is known.
    """
    known = [concrete(entry) for entry in entries]
    columns = [np.ravel(entry) for entry in known if entry is not None]
    if len(columns) < len(entries):
        return
    for axis in np.stack(np.broadcast_arrays(*columns), axis=-1):
        length = float(np.linalg.norm(axis))
        if not abs(length - 1.0) <= UNIT:
            text, each = ", ".join(f"{entry:g}" for entry in axis), "both" if len(axis) == 2 else "all"
            raise InputError(f"{name} ({text}) is no unit vector; its length is {length:g}: divide {each} by that")
