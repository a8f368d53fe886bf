"""The energy that the closing of the latches puts in (M176), beside what the vehicles bring.

It has two parts: the pull of the tip to its seat, and the turn of the probe onto the cone's axis. Which of them is the
larger decides what lowers it.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Array, Float

from ....value_text import percent_text
from ...energy import energy_text
from ...view import Caution
from .vehicles import reduced_mass

CLOSING = "latch_closing"
MUCH = 0.1  # of the energy of relative motion at the start
MUCH_ADDED = (
    "sanity check: closing the latch adds more than a tenth of what the vehicles bring (latch_energy_share; a run's"
    " summary says whether by latch.stiffness or by latch.turn_stiffness)"
)


def closing_energy(capture: Any) -> Float[Array, ""]:
    """Return what the closing of the latches put in [J], 0 without latches (M176)."""
    stored = capture.energy.stored
    # What is put in counts as stored below zero, so that the sum of all energies does not change.
    return -stored[CLOSING] if CLOSING in stored else 0.0 * capture.end_time


def closing_share(capture: Any) -> Float[Array, ""]:
    """Return what the closing of the latches put in over the energy of relative motion at the start [-] (M182)."""
    at_start = capture.docking.energy_left / capture.docking.relative_energy
    return closing_energy(capture) / at_start


def _in_numbers(capture: Any) -> tuple[float, float]:
    """Return what the closing of the latches put in and the energy of relative motion at the start, of a solved run
    [J]."""
    docking = capture.docking
    # NumPy, because JAX would trace a program for each operation on a finished run.
    added, left, share = map(
        np.asarray, (capture.energy.stored.get(CLOSING, 0.0), docking.energy_left, docking.relative_energy)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        return -float(added), float(left / share)


def closing_words(capture: Any) -> str:
    """Return in words what closing the latches added: "Closing the latch added 344 J, 6 times what the vehicles
    brought (57 J)"; "" where it added nothing."""
    added, brought = _in_numbers(capture)
    if not added > 0.0:
        return ""
    share = _share_of(added / brought)
    return f"closing the latch added {energy_text(added)}, {share} the vehicles brought ({energy_text(brought)})"


def _share_of(ratio: float) -> str:
    return f"{ratio:.2g} times what" if ratio >= 1.0 else f"{percent_text(ratio)} of what"


class ClosingParts(NamedTuple):
    """What latches put in if they close at once [J]: by the ``pull`` of the tip to its seat, ½ k r² and the preload's
    share, and by the ``turn`` of the probe onto the cone's axis, ½ k_t φ²."""

    pull: float
    turn: float

    def advice(self) -> str:
        """Return both parts in words, the larger one first, with what lowers it."""
        pull, turn = (
            f"pulling the tip to its seat {energy_text(self.pull)}",
            f"turning the probe {energy_text(self.turn)}",
        )
        if self.turn > self.pull:
            return f"closed at once {turn}, {pull}; a smaller latch.turn_stiffness adds less"
        softer = "a softer latch.stiffness, a longer latch.closing_time or a smaller latch.preload adds less"
        return f"closed at once {pull}, {turn}; {softer}"


def closing_parts(design: Any, miss: float, angle: float) -> ClosingParts:
    """Return both parts for a ``miss`` of the tip [m] and an ``angle`` of the probe [rad] at the crossing (M176)."""
    latch = design.latch
    stiffness, turn, preload, length, depth = (
        float(np.asarray(it))
        for it in (latch.stiffness, latch.turn_stiffness, latch.preload, latch.preload_length, latch.depth)
    )
    square = miss**2 + depth**2
    pull = 0.5 * stiffness * square + preload * (np.sqrt(square + length**2) - length)
    return ClosingParts(float(pull), 0.5 * turn * angle**2)


def closing_warnings(capture: Any) -> list[str]:
    """Return a line where closing the latches added more than a tenth of what the vehicles brought."""
    added, brought = _in_numbers(capture)
    if not added > MUCH * brought:
        return []
    docking = capture.docking
    parts = closing_parts(capture.design, float(docking.lateral_miss), float(docking.attitude_miss))
    return [f"sanity check: {closing_words(capture)}, more than a tenth: {parts.advice()}"]


def closing_cautions(design: Any, scenario: Any) -> list[Caution]:
    """Return a caution where turning the probe onto the cone's axis, by its angle at the start, puts in more than a
    tenth of what the vehicles bring. How far the tip misses the seat is known after a run only."""
    angle, speed = scenario.approach.angle, np.linalg.norm(scenario.approach.speeds)
    turn, brought = closing_parts(design, 0.0, angle).turn, 0.5 * float(reduced_mass(design)) * float(speed) ** 2
    if not turn > MUCH * brought:
        return []
    line = (
        f"closing the latch adds up to {energy_text(turn)} by turning the probe, at the start's angle of"
        f" {np.degrees(angle):.3g} deg, {_share_of(turn / brought)} the vehicles bring ({energy_text(brought)}):"
        " a smaller latch.turn_stiffness adds less"
    )
    return [Caution(line, "latch energy", excess=turn / brought, measured=True)]
