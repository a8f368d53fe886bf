"""How a capture ended."""

from ..outcome import INPUT, NOT_FINITE, STEP_SIZE, STEPS, RunOutcome

SUCCESSES = ("captured", "held", "latched")


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
    held = 4, "held: latched, and at rest together but for the quiet share of the energy"
    latched = 5, "latched: held together by the latches, not yet at rest within the duration"
    torn = 6, "torn: the force of the latches exceeded their strength"
    failed_steps = 7, STEPS
    failed_step_size = 8, STEP_SIZE
    failed_not_finite = 9, NOT_FINITE
    failed_penetration = (
        10,
        "failed: the tip went deeper into the cone than its radius, or came behind the middle of its wall; the"
        " contact is too soft for this speed, or a latch too soft to keep the tip in the throat",
    )
    failed_input = 11, INPUT

    @classmethod
    def time_is_up(cls) -> str:
        """See `RunOutcome`."""
        return "timeout"
