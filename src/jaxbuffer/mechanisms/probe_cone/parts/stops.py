"""The stops at either end of the buffer's way: end stop (M28), also of rubber (M183), and rebound stop (M174)."""

from collections.abc import Callable, Iterator
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool

from ...._types import Scalar
from ....contact import KelvinVoigt
from ....elements import Element, EndStop, RubberBlock
from ....errors import InputError, check_entries, concrete, inside
from ....fields import NON_NEGATIVE, POSITIVE, Number, Part, number, on
from ....suggestions import same_word
from ...assembled import Assembled, Observable
from ...drawing import Outline
from ...layout import Closed, EvaluatedState
from ...quantity import Quantity
from .part import B, DrawnPart, Joined, ProbePart, loss
from .rod import CYLINDER_WIDTH
from .springs import SpringFields

same_word("stop", "bumper")


class EndStopFields(SpringFields):
    """The end of the buffer's way in.

    An end stop pushes the probe out again while the stroke exceeds s_m (M28), one of rubber stiffens from k_s on
    (M183); only the free length ends that run. Without an end stop a run that gets to s_m ends as "bottomed" (M66).
    """

    max_stroke: Number = number(
        None, "m", **POSITIVE, doc="stroke s_m at which the buffer is at its end; not set: the free length"
    )
    stop_stiffness: Number = number(
        None, "N/m", **POSITIVE, doc="stiffness k_s of an end stop beyond the largest stroke; not set: none"
    )
    stop_damping: Number = number(
        0.0, "N s/m", **NON_NEGATIVE, needs=on("stop_stiffness"), doc="damping c_s of the end stop"
    )
    stop_thickness: Number = number(
        None, "m", **POSITIVE, needs=on("stop_stiffness"), doc="thickness h of an end stop of rubber; not set: linear"
    )

    def check_together(self) -> None:
        super().check_together()
        if self.has("max_stroke"):
            above = "; it ends where the spring's ends meet, at buffer.free_length"
            length = self.free_length
            check_entries("buffer.max_stroke", self.max_stroke, "m", 0.0, length, too_high=above, high_open=False)
        _check_damping(self, "stop", "an end stop")

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        if self.has("max_stroke"):
            yield inside(self.max_stroke, high=self.free_length, **POSITIVE)
        yield from _damping_in_range(self, "stop")

    @property
    def end(self) -> Scalar:
        """Return the stroke at which the buffer is at its end or its end stop, if there is one, begins to push [m]
        (M28)."""
        return self.max_stroke if self.has("max_stroke") else self.free_length

    @property
    def longest_stroke(self) -> Scalar:
        """Return the stroke that ends a run as "bottomed" [m] (M66): with an end stop that is where the spring's ends
        meet."""
        return self.free_length if self.has("stop_stiffness") else self.end

    @property
    def end_field(self) -> str:
        """Return the path of the number that sets `longest_stroke`."""
        return (
            "buffer.max_stroke" if self.has("max_stroke") and not self.has("stop_stiffness") else "buffer.free_length"
        )


class ReboundStopFields(Part):
    """The end of the buffer's way out: a stop that holds the probe near its free length (M174).

    Without it the spring also pulls, as in the paper.
    """

    rebound_stiffness: Number = number(
        None, "N/m", **POSITIVE, doc="stiffness k_r of a stop beyond the free length; not set: none"
    )
    rebound_damping: Number = number(
        0.0, "N s/m", **NON_NEGATIVE, needs=on("rebound_stiffness"), doc="damping c_r of the rebound stop"
    )
    rebound_gap: Number = number(
        5e-4,
        "m",
        **POSITIVE,
        needs=on("rebound_stiffness"),
        doc="way g_r beyond the free length at which that stop begins",
    )

    def check_together(self) -> None:
        super().check_together()
        _check_damping(self, "rebound", "a rebound stop")

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        yield from _damping_in_range(self, "rebound")


def _check_damping(fields: Part, stop: str, name: str) -> None:
    """Raise `InputError` for the damping of a stop that is not there."""
    damping = concrete(getattr(fields, f"{stop}_damping"))
    if not fields.has(f"{stop}_stiffness") and damping is not None and np.any(damping != 0.0):
        shown = f"buffer.{stop}_damping = {float(damping.flat[np.argmax(damping)]):g} N s/m"
        raise InputError(f"{shown} needs {name}: give buffer.{stop}_stiffness [N/m] too")


def _damping_in_range(fields: Part, stop: str) -> Iterator[Bool[Array, ""]]:
    """Yield that the damping of a stop that is not there is zero, as `_check_damping` has it."""
    if not fields.has(f"{stop}_stiffness"):
        yield inside(getattr(fields, f"{stop}_damping"), low=0.0, high=0.0)


class EndStopPart(ProbePart):
    """The stop at the end of the buffer's way in."""

    def elements(self, joined: Joined) -> tuple[Element, ...]:
        buffer = joined.design.buffer
        law = KelvinVoigt(buffer.stop_stiffness, buffer.stop_damping)
        if buffer.has("stop_thickness"):
            law = RubberBlock(law.linear_stiffness, law.damping, buffer.stop_thickness)
        return (EndStop(joined.axial, law, buffer.end),)

    def history(self, design: Any) -> tuple[Observable, ...]:
        # A history has the force in any case.
        return () if self.present(design) else (Observable("stop_force", lambda mechanism, at, rate: jnp.zeros(())),)

    def push(self, mechanism: Assembled, at: EvaluatedState, active: Closed) -> Scalar | None:
        stop = mechanism.element(self.name)
        return stop.force(mechanism.evaluated(at, self.name), mechanism.closed_switches(active, self.name))

    def stroke_energy(self, mechanism: Assembled) -> Callable[[Array], Array] | None:
        stop = mechanism.element(self.name)
        return lambda stroke: stop.law.energy(stroke - stop.place)

    def summary(self, capture: Any, element: Element) -> list[tuple[str, str]]:
        return []  # it stands in the lines of the buffer

    def buffer_text(self, capture: Any) -> str:
        return f", end stop {float(capture.peak_stop_force):.6g} N"

    def stroke_limits(self, design: Any) -> list[tuple[str, Scalar]]:
        return [("end stop", design.buffer.end)]

    def drawn(self, design: Any, first: int) -> DrawnPart:
        # The rear end of the rod meets the end stop (M28) that far before its place at rest.
        return DrawnPart((_line(design, -design.buffer.end, "end stop"),))


class ReboundStopPart(ProbePart):
    """The stop at the end of the buffer's way out."""

    def elements(self, joined: Joined) -> tuple[Element, ...]:
        buffer = joined.design.buffer
        law = KelvinVoigt(buffer.rebound_stiffness, buffer.rebound_damping)
        return (EndStop(joined.axial, law, buffer.rebound_gap, rebound=True, watched=False, name=self.name),)

    def summary(self, capture: Any, element: Element) -> list[tuple[str, str]]:
        return []  # nothing of it is watched

    def drawn(self, design: Any, first: int) -> DrawnPart:
        # The rear end of the rod meets the rebound stop (M174) that far behind its place at rest, nearly at the hinge.
        return DrawnPart((_line(design, design.buffer.rebound_gap, "rebound stop"),))


def _line(design: Any, place: Scalar, part: str) -> Outline:
    """Return the line where the rear end of the rod meets a stop, ``place`` [m] before its place at rest."""
    x, tall = (
        float(design.buffer.cylinder_length) / 2.0 + float(place),
        0.5 * CYLINDER_WIDTH * float(design.probe.tip_radius),
    )
    return Outline(B, np.array([[x, -tall], [x, tall]]), filled=False, part=part)


END_STOP = EndStopPart(
    name="stop",
    path="buffer.stop_stiffness",
    quantities={
        "peak_stop_force": Quantity(
            "N",
            lambda c: c.peak_stop_force,
            "largest force of the buffer's end stop",
            "peak force of the end stop",
            swept=True,
            tuned=True,
            part="buffer.stop_stiffness",
        ),
        "stop_loss": Quantity("J", lambda c: c.energy.stop_damper, "energy lost in the buffer's end stop"),
    },
    recorded={"stop_force": "N"},
)
REBOUND_STOP = ReboundStopPart(
    name="rebound",
    path="buffer.rebound_stiffness",
    quantities={
        "rebound_loss": Quantity("J", loss("rebound_damper"), "energy lost in the buffer's rebound stop"),
    },
)
