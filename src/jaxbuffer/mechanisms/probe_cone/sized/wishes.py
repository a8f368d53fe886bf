"""What may be wished of a latch and a buffer that are sized."""

from typing import ClassVar

from ....fields import POSITIVE, Number, Part, number
from ..parts.latch_energy import MUCH


class DockingWishes(Part):
    """What is wished of a docking whose latch and buffer are sized; what limits a quantity has its name."""

    section: ClassVar[str] = "size"
    settling_time: Number = number(
        None, "s", **POSITIVE, doc="within which the vehicles are held after latching; not set: what comes of the rest"
    )
    latch_energy_share: Number = number(
        MUCH, "-", **POSITIVE, high=1.0, doc="share of the approach's energy that closing the latch puts in at most"
    )
    peak_latch_force: Number = number(None, "N", **POSITIVE, doc="largest force of the latch; not set: its strength")
    stroke: Number = number(
        None,
        "m",
        **POSITIVE,
        doc="stroke that the fastest approach takes; not set: buffer.max_stroke, or 18 % of the free length",
    )
    overspeed: Number = number(
        1.5, "-", low=1.0, doc="times the fastest approach that the end stop still takes, at half of the way left"
    )
