"""A latch and a buffer that fit, both together."""

from collections.abc import Sequence
from typing import Any

from ...sizing import SizedParts, Sizer
from .buffer import buffer_for
from .encounter import encounter
from .latch import latch_for
from .wishes import DockingWishes


def size_docking(design: Any, scenarios: Sequence[Any], wishes: DockingWishes) -> SizedParts:
    """Return the buffer that fits, and behind it the latch."""
    met = encounter(design, scenarios)
    buffer = buffer_for(design, met, wishes)
    latch = latch_for(buffer.design, met, wishes)
    return SizedParts(
        design,
        latch.design,
        (*latch.numbers, *buffer.numbers),
        (*latch.estimates.values(), *buffer.estimates.values()),
        (*latch.trade_offs, *buffer.trade_offs),
        (*latch.remarks, *buffer.remarks),
        met.approach + latch.estimates["settling_time"].value,
    )


SIZER = Sizer(DockingWishes, size_docking)
