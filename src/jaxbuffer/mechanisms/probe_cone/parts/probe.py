"""The probe: its rod with the tip, which may bend."""

from typing import ClassVar

from .bending import BendingFields


class Probe(BendingFields):
    """The rod and its ball tip (`RodFields`), and what bends it, if anything does (`BendingFields`)."""

    section: ClassVar[str] = "probe"
