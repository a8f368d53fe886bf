"""How a capture ended."""

import enum

import jax.numpy as jnp
from jaxtyping import Array, Int

from .integrate import Status


class Outcome(enum.IntEnum):
    """How a capture ended; the members compare with the integer codes inside compiled code.

    A failed capture is one whose equations were not solved: its numbers are NaN and say nothing about the design.
    """

    captured = 0
    escaped = 1
    bottomed = 2
    timeout = 3
    failed_steps = 4
    failed_step_size = 5
    failed_not_finite = 6
    failed_penetration = 7
    failed_input = 8

    @property
    def failed(self) -> bool:
        """Whether the solver gave up."""
        return self >= Outcome.failed_steps

    @property
    def reason(self) -> str:
        """A sentence for the user."""
        return _REASONS[self]


_REASONS = {
    Outcome.captured: "captured: the tip centre crossed the capture plane inwards",
    Outcome.escaped: "escaped: the tip left the cone",
    Outcome.bottomed: "bottomed: the buffer came to its end; the run stops there",
    Outcome.timeout: "timeout: neither captured nor escaped within the duration",
    Outcome.failed_steps: "failed: more steps than max_steps; raise it, loosen rtol, or try the implicit solver",
    Outcome.failed_step_size: "failed: the step size fell below 1e-14 s; the tolerance can't be met",
    Outcome.failed_not_finite: "failed: the state stopped being finite",
    Outcome.failed_penetration: "failed: the tip went deeper into a flank than its radius; the contact is too soft for "
    "this speed",
    Outcome.failed_input: "failed: a number of the design, the scenario or the options is out of its allowed range",
}

_FROM_STATUS = {
    0: Outcome.captured,  # the mechanism's terminal guards, in their order
    1: Outcome.escaped,
    2: Outcome.bottomed,
    3: Outcome.failed_penetration,
    Status.TIMEOUT: Outcome.timeout,
    Status.TOO_MANY_STEPS: Outcome.failed_steps,
    Status.STEP_TOO_SMALL: Outcome.failed_step_size,
    Status.NOT_FINITE: Outcome.failed_not_finite,
    Status.INPUT: Outcome.failed_input,
}


def outcome_code(status: Int[Array, ""]) -> Int[Array, ""]:
    """The outcome's code from a run's status."""
    code = jnp.asarray(int(Outcome.failed_not_finite))
    for value, outcome in _FROM_STATUS.items():
        code = jnp.where(status == int(value), int(outcome), code)
    return code
