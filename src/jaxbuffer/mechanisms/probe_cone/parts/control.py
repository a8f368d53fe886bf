"""Attitude control of the active vehicle (M221)."""

from typing import Any, ClassVar

from ....elements import AttitudeControl, Element
from ....errors import InputError
from ....fields import NON_NEGATIVE, POSITIVE, Number, Part, choice, number, on
from .latch import LATCH
from .part import Joined, ProbePart, S, Supply


class Control(Part):
    """Thrusters that turn the active vehicle back to the inertial axes, by their mean moment (M221).

    Until "contact" is until the first touchdown: a start in contact then has no control. Until "latch" is until the
    latches begin to close.
    """

    section: ClassVar[str] = "control"
    stiffness: Number = number(
        None, "N m/rad", **POSITIVE, doc="moment k_p per angle of the active vehicle; not set: no attitude control"
    )
    damping: Number = number(
        0.0, "N m s/rad", **NON_NEGATIVE, needs=on("stiffness"), doc="moment c_p per rate of the active vehicle"
    )
    limit: Number = number(None, "N m", **POSITIVE, needs=on("stiffness"), doc="largest moment M_max about each axis")
    until: str = choice(
        "end",
        "contact",
        "latch",
        "end",
        needs=on("stiffness"),
        doc="how long it acts: to the first contact, until the latches close, or to the end",
    )

    def check_together(self) -> None:
        if self.has("stiffness") and not self.has("limit"):
            raise InputError("control.stiffness needs control.limit [N m] too")


class ControlPart(ProbePart):
    """The attitude control."""

    def present(self, design: Any, scenario: Any = None) -> bool:
        # It ends with the first contact, which a start in contact begins with.
        over = super().present(design) and design.control.until == "contact" and scenario is not None
        return super().present(design) and not (over and scenario.start == "contact")

    def elements(self, joined: Joined) -> tuple[Element, ...]:
        control = joined.design.control
        # Until latches close that the design does not have, it acts to the end.
        latch = LATCH.elements(joined)[0] if control.until == "latch" and LATCH.present(joined.design) else None
        until = joined.contact if control.until == "contact" else latch
        return (AttitudeControl(S, control.stiffness, control.damping, control.limit, until),)


CONTROL = ControlPart(
    name="control",
    path="control.stiffness",
    recorded={"control_moment": "N m"},
    supply=Supply("control", "the attitude control"),
    has_events=True,
)
