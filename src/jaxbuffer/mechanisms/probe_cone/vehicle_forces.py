"""The largest force on a vehicle: of a contact, of a part, or of the hinge (M181)."""

import functools

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .capture import Capture
from .parts import PARTS

EQUAL = 1e-6  # relative: forces as near as that count as one
OF_PARTS = dict(part.vehicle_force for part in PARTS if part.vehicle_force is not None)


def peak_vehicle_force(capture: Capture) -> Float[Array, ""]:
    """Return the largest single force on a vehicle [N] (M181)."""
    forces = (capture.quantity(quantity) for quantity in OF_PARTS.values())
    return functools.reduce(jnp.maximum, [capture.peak_force, *forces, capture.peak_hinge_force])


def larger_than_contact(capture: Capture) -> str:
    """Return which force on a vehicle exceeds the contact's, and by how much, in words: "the largest force on a vehicle
    is the hinge's, 636 N"; "" where none does."""
    names = (*OF_PARTS, "hinge")
    of_parts = (capture.quantity(quantity) for quantity in OF_PARTS.values())
    forces = [float(np.asarray(force)) for force in (*of_parts, capture.peak_hinge_force)]
    largest = max(forces)
    if not largest > float(capture.peak_force) * (1.0 + EQUAL):
        return ""
    of = names[forces.index(largest)]
    time = capture.maximum_times.get(f"{of}_force", np.nan)
    when = f" at {time:.6g} s" if np.isfinite(time) else ""
    return f"the largest force on a vehicle is the {of}'s, {largest:.6g} N{when}"
