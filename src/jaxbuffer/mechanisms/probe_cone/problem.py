"""What a tuning problem of the probe-cone mechanism must keep to."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...errors import InputError
from ...fields import replace
from ...value_text import percent_text
from ..energy import energy_text
from .parts import PARTS, holder_of
from .sanity_checks import cautions

LONGEST = {"buffer.max_stroke", "buffer.free_length"}
LEFT = ("energy_left", "relative_energy", "arrest_stroke")  # quantities of what is left when a run ends
HOLDER = next(part.name for part in PARTS if part.holds)  # what would hold the tip after capture


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


def left_open(number: Callable[[str], Any]) -> tuple[str, ...]:
    """Return the quantities that say what a design's runs leave open; where a part holds the tip the share of the
    energy alone."""
    return LEFT[1:2] if any(part.holds and number(part.path) is not None for part in PARTS) else LEFT


def unfinished(problem: Any, evaluation: Any) -> list[str]:
    """Return a line where a tuned design that nothing holds after capture keeps its limits up to there only, with the
    worst case; of others, what their parts caution against.

    Limits on what is left at capture say that somebody has thought of it: then none.
    """
    if holder_of(problem.design) is not None:
        return cautions(problem.design)
    if set(LEFT) & set(problem.limits.at_most):
        return []
    column = {name: evaluation.quantities[:, k] for k, name in enumerate(problem.names)}
    needed = np.where(evaluation.succeeded, column["arrest_stroke"], -np.inf)
    worst = int(np.argmax(needed))
    # Where no scenario ends in a capture, nothing is known of what one leaves.
    if not evaluation.succeeded[worst]:
        return []
    left = f"{energy_text(column['energy_left'][worst])}, {percent_text(column['relative_energy'][worst], '.3g')},"
    where = f" in scenario {problem.number_text(worst)}" if len(needed) > 1 else ""
    return [
        f"the limits hold up to capture only: there{where} {left} of the energy of relative motion is left, which may"
        f" take up to {1e3 * needed[worst]:.4g} mm of stroke; give the design a {HOLDER}, or limit arrest_stroke"
    ]
