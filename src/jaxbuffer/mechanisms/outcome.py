"""How a run ended: what every mechanism's outcomes have in common."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Int

from .._types import Code
from ..errors import InputError, suggest
from ..hybrid import Status

STEPS = "failed: more steps than max_steps; raise it, loosen rtol, or try the implicit solver"
STEP_SIZE = "failed: the step size fell below 1e-14 s; the tolerance can't be met"
NOT_FINITE = "failed: the state stopped being finite"
PENETRATION = (
    "failed: a ball went deeper into a flank than its radius, or came behind the middle of a long one; the contact is"
    " too soft for this speed"
)
INPUT = "failed: a number of the design, the scenario or the options is out of its allowed range"
FAILURES = {
    Status.TOO_MANY_STEPS: "failed_steps",
    Status.STEP_TOO_SMALL: "failed_step_size",
    Status.NOT_FINITE: "failed_not_finite",
    Status.INPUT: "failed_input",
}


class RunOutcome(Code):
    """Base of the mechanisms' outcomes. Each member is a code and a sentence for the user.

    First come the ways in which a run ends well, then from ``failed_steps`` on those in which the equations were not
    solved: then all numbers of the run are NaN and say nothing about the design. Every mechanism has the members
    ``failed_steps``, ``failed_step_size``, ``failed_not_finite`` and ``failed_input``.
    """

    reason: str

    def __new__(cls, code: int, reason: str = "") -> "RunOutcome":
        """Make a member of the enumeration from its code and its reason in words."""
        member = int.__new__(cls, code)
        member._value_ = code
        member.reason = reason
        return member

    @classmethod
    def time_is_up(cls) -> str:
        """Return the outcome's name of a run whose duration is over."""
        return "finished"

    @property
    def failed(self) -> bool:
        """Return whether the equations were not solved."""
        return self >= type(self)["failed_steps"]


class Simulated(RunOutcome):
    """Outcomes of a mechanism whose runs end at a guard of its own or of an element, or when the duration is over."""

    ended = 0, "ended: the mechanism reached its end"
    finished = 1, "finished: the duration is over"
    held = 2, "held: all latches are closed, and hardly any energy of relative motion is left"
    bottomed = 3, "bottomed: a buffer came to the end of its way"
    torn = 4, "torn: a latch was pulled with more than its strength"
    failed_steps = 5, STEPS
    failed_step_size = 6, STEP_SIZE
    failed_not_finite = 7, NOT_FINITE
    failed_penetration = 8, PENETRATION
    failed_input = 9, INPUT


def outcome_code(outcomes: type[RunOutcome], ends: tuple[str, ...], status: Int[Array, ""]) -> Int[Array, ""]:
    """Return the code of a run's outcome.

    **Arguments:** ``outcomes``: the mechanism's; ``ends``: the outcome's name for each guard of the run's end
    (`ContactSystem.end_outcomes`); ``status``: a `Status` of the time stepping.
    """
    for name in ends:
        if name not in outcomes.__members__:
            raise InputError(f"no outcome {name!r} of the mechanism's end{suggest(name, outcomes.__members__)}")
    by_time = {int(Status.TIMEOUT): outcomes.time_is_up()}
    names = dict(enumerate(ends)) | by_time | {int(s): name for s, name in FAILURES.items()}
    # The status is known only inside the program: each one that there can be is compared with it.
    code = jnp.asarray(int(outcomes["failed_not_finite"]))
    for value, name in names.items():
        code = jnp.where(status == value, int(outcomes[name]), code)
    return code


class NotComputed(NamedTuple):
    """In the place of the outcome of a run that was not made."""

    name: str = "not computed"
    reason: str = "it was not computed"
    failed: bool = False

    def __str__(self) -> str:
        return self.name
