"""A lockout of the buffer, which holds its stroke from the crossing of the capture plane on (M184)."""

from typing import Any, ClassVar

import numpy as np

from ...._types import Scalar
from ....elements import Element, Lockout
from ....elements.lockout import held_stroke
from ....fields import NON_NEGATIVE, POSITIVE, Number, Part, number, on
from ...drawing import Outline
from ...quantity import Quantity, largest, zero
from .part import B, DrawnPart, Joined, P, ProbePart, T, loss, time_of
from .rod import CYLINDER_WIDTH, ROD_WIDTH

PAD = 0.1  # of the cylinder's length: length of the pads that clamp the rod, in drawings; assumed
FIRMER = 10.0  # times the spring's stiffness: from there on a lockout holds the stroke to a tenth of itself


class LockoutFields(Part):
    """A lockout: spring and damper that engage where the tip crosses the capture plane, and hold its stroke (M184)."""

    section: ClassVar[str] = "lockout"
    stiffness: Number = number(
        None,
        "N/m",
        **POSITIVE,
        needs=on("latch.stiffness"),
        doc="stiffness k_h with which the stroke is held after capture; not set: no lockout",
    )
    damping: Number = number(
        0.0, "N s/m", **NON_NEGATIVE, needs=on("stiffness"), doc="damping c_h of the stroke that is held"
    )


class LockoutPart(ProbePart):
    """The lockout."""

    def elements(self, joined: Joined) -> tuple[Element, ...]:
        lockout = joined.design.lockout
        return (Lockout(joined.axial, P, T, joined.tip, joined.plane, lockout.stiffness, lockout.damping),)

    def push(self, mechanism: Any, at: Any, active: Any) -> Scalar | None:
        closed = mechanism.closed_switches(active, self.name)
        return mechanism.element(self.name).force(mechanism.evaluated(at, self.name), closed)

    def cautions(self, design: Any) -> list[str]:
        spring, stiffness = design.buffer.k_A, float(np.min(np.asarray(design.lockout.stiffness)))
        # The stiffness of a measured curve changes with the stroke: nothing is said of it.
        if spring is None or stiffness >= FIRMER * (softest := float(np.max(np.asarray(spring)))):
            return []
        return [
            f"lockout.stiffness {stiffness:.4g} N/m is less than {FIRMER:g} times buffer.k_A {softest:.4g} N/m: at rest"
            f" the spring has pushed the rod out by {softest / (softest + stiffness):.0%} of the stroke that is held"
        ]

    def drawn(self, design: Any, first: int) -> DrawnPart:
        # Two pads at the front end of the cylinder, from its wall to the rod (M184 says what they exert, not what they
        # are).
        tip, half = float(design.probe.tip_radius), float(design.buffer.cylinder_length) / 2.0
        rod, wall, rear = 0.5 * ROD_WIDTH * tip, 0.5 * CYLINDER_WIDTH * tip, half - PAD * 2.0 * half
        pad = np.array([[rear, rod], [half, rod], [half, wall], [rear, wall]])
        return DrawnPart((Outline(B, pad, part="lockout"), Outline(B, pad * [1.0, -1.0])))


LOCKOUT = LockoutPart(
    name="lockout",
    path="lockout.stiffness",
    quantities={
        "peak_lockout_force": Quantity(
            "N",
            largest("lockout_force"),
            "largest force with which the lockout holds the stroke",
            "peak force of the lockout",
            swept=True,
            tuned=True,
            part="lockout.stiffness",
        ),
        "lockout_stroke": Quantity(
            "m",
            lambda c: held_stroke(c, "lockout") if "lockout_stroke" in c.maxima else zero(c),
            "stroke that the lockout holds, below zero of an extension; 0 where it has not engaged",
            "stroke that is held",
            signed=True,
            swept=True,
            part="lockout.stiffness",
        ),
        "peak_lockout_force_time": time_of("lockout_force", "the force of the lockout"),
        "lockout_loss": Quantity("J", loss("lockout_damper"), "energy lost in the lockout"),
    },
    recorded={"lockout_force": "N", "lockout_stroke": "m"},
    has_events=True,
)
