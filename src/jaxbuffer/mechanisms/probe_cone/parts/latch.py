"""Latches of the cone, which close behind the tip and hold the vehicles together (M175 to M177)."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Array, Bool, Float

from ...._types import Scalar
from ....elements import Element, Latch
from ....errors import InputError, concrete, inside
from ....fields import NON_NEGATIVE, POSITIVE, Number, Part, number, on
from ....suggestions import same_name, same_word
from ...drawing import Outline
from ...mechanism import RequiredEnd
from ...quantity import Quantity
from ...validity import ValidityLimit
from ...view import Caution
from .latch_energy import (
    CLOSING,
    MUCH,
    MUCH_ADDED,
    closing_cautions,
    closing_energy,
    closing_share,
    closing_warnings,
    closing_words,
)
from .part import DrawnPart, Joined, P, ProbePart, Supply, T, loss, time_of
from .rod import ROD_WIDTH

HOOK, GRIP = 1.05, 0.6  # of a tooth: distance behind the ball's centre and length, of the tip's radius; assumed
same_name("strength", "max_force", "peak_force", "limit")
same_word("latch", "latches", "lock", "clamp")


class Latches(Part):
    """Latches that close where the tip crosses the capture plane, and hold the vehicles together (M175 to M177).

    Without them a run ends there.
    """

    section: ClassVar[str] = "latch"
    stiffness: Number = number(
        None, "N/m", **POSITIVE, doc="stiffness k_l with which the tip is held in its seat; not set: no latch"
    )
    damping: Number = number(
        0.0, "N s/m", **NON_NEGATIVE, needs=on("stiffness"), doc="damping c_l of the tip in its seat"
    )
    preload: Number = number(
        0.0, "N", **NON_NEGATIVE, needs=on("stiffness"), doc="force F_l with which the latch pulls the tip to its seat"
    )
    preload_length: Number = number(
        1e-4,
        "m",
        **POSITIVE,
        needs=(*on("stiffness"), *on("preload")),
        doc="distance r_l over which that preload is reached",
    )
    turn_stiffness: Number = number(
        0.0,
        "N m/rad",
        **NON_NEGATIVE,
        needs=on("stiffness"),
        doc="stiffness k_t with which the probe is held along the cone's axis",
    )
    turn_damping: Number = number(
        0.0, "N m s/rad", **NON_NEGATIVE, needs=on("stiffness"), doc="damping c_t of the probe's turning"
    )
    closing_time: Number = number(
        0.02, "s", **NON_NEGATIVE, needs=on("stiffness"), doc="time in which the latch closes"
    )
    depth: Number = number(0.0, "m", needs=on("stiffness"), doc="depth of the seat behind the capture plane")
    strength: Number = number(
        None, "N", **POSITIVE, needs=on("stiffness"), doc="force that tears the latch; not set: none does"
    )
    quiet: Number = number(
        1e-3,
        "-",
        low=0.0,
        high=1.0,
        low_open=True,
        high_open=True,
        needs=on("stiffness"),
        doc="share of the first energy of relative motion at which the vehicles count as held",
    )

    def check_together(self) -> None:
        if not self.has("strength"):
            return
        preload, strength, closing = (concrete(x) for x in (self.preload, self.strength, self.closing_time))
        if preload is not None and strength is not None and np.any(below := strength <= preload):
            both = [float(array[below].flat[0]) for array in np.broadcast_arrays(strength, preload)]
            raise InputError(
                f"latch.strength = {both[0]:g} N must be above latch.preload = {both[1]:g} N: the preload alone would"
                " tear the latch"
            )
        if closing is not None and np.any(closing == 0.0):
            raise InputError(
                "latch.closing_time = 0 s with a latch.strength: the latch would jump to its force at once, and its"
                " tearing would depend on nothing; give a closing time above 0 s, the default 0.02 s say"
            )

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        if self.has("strength"):
            yield inside(self.strength, low=self.preload, low_open=True)
            yield inside(self.closing_time, **POSITIVE)


class LatchPart(ProbePart):
    """The latches."""

    def elements(self, joined: Joined) -> tuple[Element, ...]:
        latch, plane = joined.design.latch, joined.plane
        element = Latch(
            first=P,
            second=T,
            point=joined.tip,
            plane=plane,
            seat=(plane + latch.depth, 0.0),
            stiffness=latch.stiffness,
            damping=latch.damping,
            turn_stiffness=latch.turn_stiffness,
            turn_damping=latch.turn_damping,
            preload=latch.preload,
            preload_length=latch.preload_length,
            closing_time=latch.closing_time,
            strength=latch.strength,
        )
        return (element,)

    def rest_threshold(self, design: Any) -> Scalar:
        return design.latch.quiet

    def cautions(self, design: Any) -> list[str]:
        if design.buffer.has("rebound_stiffness"):
            return []
        return [
            "a latch without buffer.rebound_stiffness: beyond the buffer's free length its spring pulls, and latched"
            " vehicles swing on it; with a rebound stop the latch force may be far larger"
        ]

    def contradictions(self, design: Any, scenario: Any) -> list[Caution]:
        reach, depth = design.cone.reach(design.probe.tip_radius), float(design.latch.depth)
        found = closing_cautions(design, scenario)
        if 0.0 <= reach < depth:
            seat = f"a seat that is more than {1e3 * reach:.3g} mm behind the capture plane"
            line = f"latch.depth {1e3 * depth:.4g} mm: the ball cannot reach {seat}"
            found = [Caution(line, "seat", excess=depth - reach), *found]
        return found

    def validity(self, quantities: Mapping[str, Any]) -> list[ValidityLimit]:
        # Tunings alone know it.
        return [ValidityLimit(MUCH_ADDED, np.asarray(quantities.get("latch_energy_share", 0.0)) / MUCH)]

    def summary(self, capture: Any, element: Element) -> list[tuple[str, str]]:
        lines, docking = element.report.summary(capture), capture.docking
        if not lines:
            return []
        miss = f"{1e3 * float(docking.lateral_miss):.4g} mm off the axis"
        met = ("tip at the latches", f"{miss}, {docking.direction_text()}")
        return [*lines, met, *(("energy of the latch", text) for text in (closing_words(capture),) if text)]

    def warnings(self, capture: Any) -> list[str]:
        return closing_warnings(capture)

    def diagnosis(self, capture: Any) -> tuple[Mapping[str, str], str] | None:
        if capture.outcome.name != "torn":
            return None
        first = (
            "a larger latch.strength or latch.closing_time; 'jaxbuffer sensitivity … --of latch_share' says what moves"
            " it"
        )
        latch, docking, end = capture.design.latch, capture.docking, float(capture.end_time)
        since, closing = end - float(docking.latch_time), float(latch.closing_time)
        how = f"still closing, which takes {1e3 * closing:.4g} ms" if since < closing else "closed"
        torn = (
            f"at {end:.6g} s, {1e3 * since:.4g} ms after the latches began to close ({how}), by more than"
            f" {float(latch.strength or 0.0):.6g} N"
        )
        tip = (
            f"{1e3 * float(docking.lateral_miss):.4g} mm off the axis, {docking.drift_text()};"
            f" {docking.direction_text()}"
        )
        return {"torn": torn, "tip at the latches": tip}, first

    def drawn(self, design: Any, first: int) -> DrawnPart:
        x, y, travel = _tooth(design)
        grip = GRIP * float(design.probe.tip_radius)
        # Teeth that close behind the ball: M175 says what the latches exert, not what they are.
        tooth = np.array([[x, y], [x, y + travel], [x - grip, y + travel], [x - grip, y]])
        shapes = Outline(first, tooth, part="latch"), Outline(first + 1, tooth * [1.0, -1.0])

        def with_teeth(frames: np.ndarray, history: Any) -> Float[np.ndarray, "steps frames 3"]:
            # Behind the frames come those of the upper and the lower latch: the passive vehicle's, as far beside it as
            # they are open.
            x, y, angle = np.moveaxis(frames[:, T], -1, 0)
            away = travel * (1.0 - np.asarray(history.others.get("latch_closed", 0.0 * x)))
            teeth = [
                np.stack([x - side * away * np.sin(angle), y + side * away * np.cos(angle), angle], axis=-1)
                for side in (1.0, -1.0)
            ]
            return np.concatenate([frames, np.stack(teeth, axis=1)], axis=1)

        return DrawnPart(shapes, 2, with_teeth)

    def end_on(self, design: Any, first: int) -> DrawnPart:
        half, (_, y, travel) = float(design.probe.tip_radius), _tooth(design)
        # As wide as the ball, which the teeth would hide if they were filled.
        tooth = np.array([[-half, y], [half, y], [half, y + travel], [-half, y + travel], [-half, y]])
        upper = Outline(first, tooth, filled=False, part="latch")
        lower = Outline(first + 1, tooth * [1.0, -1.0], filled=False)

        def with_teeth(frames: np.ndarray, history: Any) -> Float[np.ndarray, "steps frames 3"]:
            # Behind the frames come those of the upper and the lower latch, in axes in which the cone stands still.
            none = np.zeros(len(frames))
            away = travel * (1.0 - np.asarray(history.others.get("latch_closed", none)))
            teeth = [np.stack([none, side * away, none], axis=-1) for side in (1.0, -1.0)]
            return np.concatenate([frames, np.stack(teeth, axis=1)], axis=1)

        return DrawnPart((upper, lower), 2, with_teeth)


def _tooth(design: Any) -> tuple[float, float, float]:
    """Return where the upper latch's tooth is, x and y in the axes of the passive vehicle, and the way it opens, until
    it is behind the flank [m]."""
    cone, tip, angle = design.cone, float(design.probe.tip_radius), float(design.cone.half_angle)
    x = -float(cone.offset) - tip * math.sin(angle) + float(design.latch.depth) - HOOK * tip
    y = 0.5 * ROD_WIDTH * tip
    reach = min(max(GRIP * tip - float(cone.offset) - x, 0.0), float(cone.length) * math.cos(angle))
    return x, y, float(cone.throat_radius) + reach * math.tan(angle) - y


LATCH = LatchPart(
    name="latch",
    path="latch.stiffness",
    quantities={
        "peak_latch_force": Quantity(
            "N",
            lambda c: c.peak_latch_force,
            "largest force of the latches",
            "peak latch force",
            swept=True,
            tuned=True,
            part="latch.stiffness",
        ),
        "latch_share": Quantity(
            "-",
            lambda c: c.docking.latch_share,
            "largest force of the latches over their strength; of torn ones above 1",
            "share of the latches' strength",
            tuned=True,
            part="latch.strength",
        ),
        "latch_time": Quantity(
            "s",
            lambda c: c.docking.latch_time,
            "when the tip crosses the capture plane and the latches begin to close",
            "latch time",
            swept=True,
            part="latch.stiffness",
        ),
        "settling_time": Quantity(
            "s",
            lambda c: c.docking.settling_time,
            "from the latching until the vehicles are held; NaN where they are not yet",
            "settling time",
            swept=True,
            tuned=True,
            part="latch.stiffness",
            awaits="held",
        ),
        "latch_energy": Quantity(
            "J",
            closing_energy,
            "energy that the closing of the latches put in",
            "energy put in by the latches",
            tuned=True,
            part="latch.stiffness",
        ),
        "latch_energy_share": Quantity(
            "-",
            closing_share,
            "that over the energy of relative motion at the start",
            "share of energy put in by the latches",
            tuned=True,
            shown=("%", 100.0),
            part="latch.stiffness",
        ),
        "peak_passive_acceleration": Quantity(
            "m/s²",
            lambda c: c.passive_force / c.design.passive.mass,
            "largest acceleration of the passive vehicle's centre of mass, with latches or from a free start",
            "peak acceleration of the passive vehicle",
            tuned=True,
            part="latch.stiffness",
        ),
        "peak_latch_force_time": time_of("latch_force", "the force of the latches"),
        "latch_loss": Quantity("J", loss("latch_damper"), "energy lost in the latches"),
    },
    recorded={"latch_force": "N", "latch_closed": "-"},
    supply=Supply(CLOSING, "the closing of the latches", "latches put in some as they close"),
    vehicle_force=("latch", "peak_latch_force"),
    holds=True,
    has_events=True,
    # How hard a design with latches is held, and how long until it is at rest.
    defaults={
        "duration": 20.0,
        "success": "latched",  # at the end, whether at rest together or not yet
        "differentiated": ("peak_force", "peak_hinge_force", "stroke", "hinge_angle", "peak_latch_force", "end_time"),
        "mapped": ("peak_force", "stroke", "hinge_angle", "peak_latch_force", "settling_time", "relative_energy"),
    },
    always={"latch_share": 1.0},
    ends=(
        RequiredEnd("latched", ("latched", "held"), "latch.stiffness"),
        RequiredEnd("held", ("held",), "latch.stiffness", "relative_energy", "latch.quiet"),
    ),
    example={"latch.stiffness": 2000.0, "latch.damping": 50.0, "latch.strength": 50.0},  # N/m, N s/m, N
    example_variables={
        "latch.stiffness": [500.0, 8000.0],  # N/m
        "latch.damping": [10.0, 200.0],  # N s/m
        "latch.closing_time": [0.01, 0.1],  # s
    },
    example_limits={"relative_energy": 0.05},  # at most a twentieth is left after the 20 s
    limitation=(
        "Without latches (latch.stiffness) the run ends at capture: what the parts do afterwards is not simulated."
    ),
)
