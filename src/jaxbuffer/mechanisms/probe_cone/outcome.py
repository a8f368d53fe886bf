"""How a capture ended."""

from ..outcome import INPUT, NOT_FINITE, STEP_SIZE, STEPS, RunOutcome


class Outcome(RunOutcome):
    """How a capture ended; the members compare with the integer codes inside compiled code.

    A failed capture is one whose equations were not solved: its numbers are NaN and say nothing about the design.

    **Example:**

    >>> capture = jb.simulate(jb.table2(), jb.Scenario())
    >>> capture.outcome is jb.Outcome.captured
    True
    >>> capture.outcome.reason
    'captured: the tip centre crossed the capture plane inwards'
    """

    captured = 0, "captured: the tip centre crossed the capture plane inwards"
    escaped = 1, "escaped: the tip left the cone"
    bottomed = 2, "bottomed: the buffer came to its end; the run stops there"
    timeout = 3, "timeout: neither captured nor escaped within the duration"
    failed_steps = 4, STEPS
    failed_step_size = 5, STEP_SIZE
    failed_not_finite = 6, NOT_FINITE
    failed_penetration = (
        7,
        "failed: the tip went deeper into a flank than its radius; the contact is too soft for this speed",
    )
    failed_input = 8, INPUT

    @classmethod
    def ends(cls) -> tuple[str, ...]:
        """See `RunOutcome`."""
        return ("captured", "escaped", "bottomed", "failed_penetration")

    @classmethod
    def time_is_up(cls) -> str:
        """See `RunOutcome`."""
        return "timeout"
