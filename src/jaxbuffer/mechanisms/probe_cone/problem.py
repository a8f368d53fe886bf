"""What a tuning problem of the probe-cone mechanism must keep to."""

from typing import Any

import numpy as np

from ...errors import InputError
from ...fields import replace

LONGEST = {"buffer.max_stroke", "buffer.free_length"}


def check_problem(problem: Any) -> None:
    """Raise `InputError` for a limit on the stroke beyond the longest one that a design within the bounds allows: it
    limits nothing."""
    corners: list[dict[str, float]] = [{v.path: v.high for v in problem.variables if v.path in LONGEST}, {}]
    most = max(float(np.asarray(replace(problem.design, corner).buffer.longest_stroke)) for corner in corners)
    if (limit := problem.limits.at_most.get("stroke", 0.0)) > most:
        raise InputError(
            f"constraints.stroke = {limit:g} m is out of range; allowed: (0, {most:g}] m, the buffer's end"
            " (buffer.max_stroke, or buffer.free_length with an end stop or without max_stroke)"
        )
