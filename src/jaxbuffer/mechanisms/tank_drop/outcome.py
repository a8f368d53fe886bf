"""How a drop onto a tank ends."""

from ..outcome import INPUT, NOT_FINITE, PENETRATION, STEP_SIZE, RunOutcome

STEPS = "failed: more steps than max_steps (200000, more by jb.simulate); take a shorter duration or a coarser mesh"

FORMS = {
    "yield": "the wall yields or a ply fails",
    "solid": "the cushion is solid",
    "torn": "the liquid is torn",
    "crack": "a point of the wall fails",
}
"""Ways to fail whose times a run has, as `TankRun.yield_time` and so on. A hole takes all points of an element."""


class TankOutcome(RunOutcome):
    """Outcomes of a drop onto a tank."""

    whole = 0, "whole: no element of the wall was deleted until the duration was over"
    holed = 1, "holed: the wall strained beyond its failure strain, and elements were deleted"
    crushed = 2, "crushed: the top came down onto the bottom, where the computation ends"
    failed_steps = 3, STEPS
    failed_step_size = 4, STEP_SIZE
    failed_not_finite = 5, NOT_FINITE
    failed_penetration = 6, PENETRATION
    failed_input = 7, INPUT

    @classmethod
    def time_is_up(cls) -> str:
        """See `RunOutcome`."""
        return "whole"
