"""Attitude control of the active vehicle, as a part of the design (M217)."""

from typing import ClassVar

from ...fields import NON_NEGATIVE, POSITIVE, Number, Part, choice, number, on


class Control(Part):
    """Thrusters that turn the active vehicle back to the inertial axes, by their mean moment (M217).

    - ``stiffness``: k_p [N m/rad]; None: no control.
    - ``damping``: c_p [N m s/rad].
    - ``limit``: M_max, which the moment about no axis exceeds [N m]; None: it has no limit.
    - ``until``: "contact", the first touchdown (a start in contact has no control), "latch", where the latches begin to
      close, or "end".
    """

    section: ClassVar[str] = "control"
    stiffness: Number = number(
        None, "N m/rad", **POSITIVE, doc="moment k_p per angle of the active vehicle; not set: no attitude control"
    )
    damping: Number = number(
        0.0, "N m s/rad", **NON_NEGATIVE, needs=on("stiffness"), doc="moment c_p per rate of the active vehicle"
    )
    limit: Number = number(
        None, "N m", **POSITIVE, needs=on("stiffness"), doc="largest moment about each axis; not set: none"
    )
    until: str = choice(
        "end",
        "contact",
        "latch",
        "end",
        needs=on("stiffness"),
        doc="how long it acts: to the first contact, until the latches close, or to the end",
    )
