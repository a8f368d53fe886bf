"""The energy that the closing of the latches puts in (M176), beside what the vehicles bring."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ...value_text import percent_text
from ..energy import energy_text
from .capture import Capture

CLOSING = "latch_closing"
MUCH = 0.1  # of the energy of relative motion at the start
REFERENCE_SPEED = 0.1  # m/s, of M182


def closing_energy(capture: Capture) -> Float[Array, ""]:
    """Return what the closing of the latches put in [J], 0 without latches (M176)."""
    stored = capture.energy.stored
    # What is put in counts as stored below zero, so that the sum of all energies does not change.
    return -stored[CLOSING] if CLOSING in stored else 0.0 * capture.end_time


def closing_share(capture: Capture) -> Float[Array, ""]:
    """Return what the closing of the latches put in over the energy of relative motion at the start [-] (M182)."""
    at_start = capture.docking.energy_left / capture.docking.relative_energy
    return closing_energy(capture) / at_start


def reference_share(capture: Capture) -> Float[Array, ""]:
    """Return the energy of relative motion at the end over that of the two vehicles at 0.1 m/s [-] (M182)."""
    design = capture.design
    active = design.active.mass + design.buffer.cylinder_mass + design.probe.rod_mass + design.probe.tip_mass
    reduced = active * design.passive.mass / (active + design.passive.mass)
    return jnp.asarray(capture.docking.energy_left / (0.5 * reduced * REFERENCE_SPEED**2))


def _in_numbers(capture: Capture) -> tuple[float, float]:
    """Return what the closing of the latches put in and the energy of relative motion at the start, of a solved run
    [J]."""
    docking = capture.docking
    # NumPy, because JAX would trace a program for each operation on a finished run.
    added, left, share = map(
        np.asarray, (capture.energy.stored.get(CLOSING, 0.0), docking.energy_left, docking.relative_energy)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        return -float(added), float(left / share)


def closing_words(capture: Capture) -> str:
    """Return in words what closing the latches added: "Closing the latch added 344 J, 6 times what the vehicles
    brought (57 J)"; "" where it added nothing."""
    added, brought = _in_numbers(capture)
    if not added > 0.0:
        return ""
    ratio = added / brought
    share = f"{ratio:.2g} times what" if ratio >= 1.0 else f"{percent_text(ratio)} of what"
    return f"closing the latch added {energy_text(added)}, {share} the vehicles brought ({energy_text(brought)})"


def closing_warnings(capture: Capture) -> list[str]:
    """Return a line where closing the latches added more than a tenth of what the vehicles brought."""
    added, brought = _in_numbers(capture)
    if not added > MUCH * brought:
        return []
    return [
        f"sanity check: {closing_words(capture)}, more than a tenth: a softer latch.stiffness, a longer"
        " latch.closing_time or a smaller latch.preload adds less"
    ]
