"""How a drop onto a tank ends."""

from ..outcome import INPUT, NOT_FINITE, PENETRATION, STEP_SIZE, RunOutcome

STEPS = "failed: more steps than max_steps; raise it, or take a coarser mesh or a shorter duration"


class TankOutcome(RunOutcome):
    """Outcomes of a drop onto a tank."""

    whole = 0, "whole: no element of the wall was deleted until the duration was over"
    holed = 1, "holed: the wall strained beyond its failure strain, and elements were deleted"
    failed_steps = 2, STEPS
    failed_step_size = 3, STEP_SIZE
    failed_not_finite = 4, NOT_FINITE
    failed_penetration = 5, PENETRATION
    failed_input = 6, INPUT
