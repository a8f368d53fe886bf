"""One capture in space, in one compiled loop by DOP853."""

from __future__ import annotations

from functools import cache

import numpy as np

from ..compiled.dop853 import dop853_of
from ..compiled.loop import CONTACT, OUTCOMES, PEAK, TIME, loop_of
from ..compiled.method import Mechanism
from ..course import PeerCapture
from ..parameters import Vector
from .chain import STATES
from .parameters import Parameters
from .watch import ACTIVE, approach, context_of, forces, slope_into, watch_along

SPACE = Mechanism(
    states=STATES,
    contacts=1,
    active=ACTIVE,
    slope_into=slope_into,
    watch_along=watch_along,
    forces=forces,
    approach=approach,
)


@cache
def _loop():
    """The compiled loop."""
    return loop_of(SPACE, dop853_of(STATES, slope_into))


def capture(parameters: Parameters, rtol: float, atol: float | Vector) -> PeerCapture:
    """One capture; ``atol`` is one number for all states, or one for each (35,)."""
    y, context = context_of(parameters)
    allowed = np.full(STATES, atol) if np.ndim(atol) == 0 else np.asarray(atol)
    code, end, best, impacts, steps, slopes = _loop()(y, context, parameters.T, rtol, allowed)
    where = ("cone",)[int(best[CONTACT])]
    return PeerCapture(OUTCOMES[code], end, float(best[PEAK]), float(best[TIME]), where, impacts, steps, slopes)
