"""What the paper's text claims of its studies, and what the model says to each."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..claims import NONE, Claim, Row, Value, cell, column, joined, listed
from .rows import FIRST

BACK = 0.05  # of its largest value: a buffer that is compressed by less is back at its length
SLIDING = 0.9  # of the time in contact, in which a tip slides that «has just sliding motion»
LESS = 0.99  # of a number: what is less than it by more than the solver's error
RIGID, BUFFERED = range(2)
WELDED, FREE = range(2)
PAIRS = (("tip", "tip"), *((name, f"{name}_free") for name in ("speed", "rate", "misalignment")))


def _made(row: Row) -> bool:
    # How long a capture takes, or where the tip crosses the cone's end, says nothing where there is none.
    return row["outcome"] == "captured"


def _rising(values: Any) -> bool:
    return bool(np.all(np.diff(values) > 0.0))


def _captured(claim: str, where: str, study: str) -> Claim:
    outcome = column(study, "outcome")
    return Claim(claim, where, "{}", (listed("{} {}", column(study, "case"), outcome),), (outcome == "captured",))


def _times_go(claim: str, where: str, study: str, sign: float) -> Claim:
    """Compare both readings of the paper's "contact duration": time in contact, and time from first contact to capture;
    of the captures that succeed. ``sign``: 1 where they rise from case to case."""
    cases, contact, capture = (column(study, name, _made) for name in ("case", "contact_time", "capture_time"))
    return Claim(
        claim,
        where,
        "{} to {}: from first contact to capture {:.3g} s; in contact {:.3g} s",
        (cases[0], cases[-1], capture, contact),
        tuple((sign * times).map(_rising) for times in (capture, contact)),
    )


def _free_tip_lowers(claim: str, name: str, unit: str, scale: float) -> Claim:
    welded, free = column("tip", name)[WELDED], column("tip", name)[FREE]
    finding = f"welded {{:.4g}} {unit}, free {{:.4g}} {unit}"
    return Claim(claim, "8, fig. 14", finding, (scale * welded, scale * free), (free < LESS * welded,))


def _masses(case: int) -> Value:
    """Return impulse over change of normal speed, impact by impact [kg]."""

    # Impacts that a run does not have, or that its end cuts off, are the word `NONE`.
    def of(row: Row) -> Any:
        return np.array([float(mass) for k in range(1, FIRST + 1) if (mass := row[f"mass_{k}"]) != NONE])

    return Value(lambda rows: of(rows["rigid"][case]))


def _aligned(name: str) -> Value:
    """Return the sizes in a column of all captures that begin out of line."""
    return abs(joined(*(column(study, name, _made) for study in ("misalignment", "rate"))))


def _quicker(rows: dict[str, tuple[Row, ...]]) -> Any:
    """Return whether the free tip is captured sooner, of each pair of runs in which both are captured."""
    pairs: list[Sequence[Row]] = [rows["tip"]]
    pairs += [pair for welded, free in PAIRS[1:] for pair in zip(rows[welded], rows[free], strict=True)]
    both = [pair for pair in pairs if all(map(_made, pair))]
    return np.array([float(free["capture_time"]) < LESS * float(welded["capture_time"]) for welded, free in both])


FIRST_PEAK, PEAK, BOUNCE, PARTING, OUTCOME = (
    column("rigid", name) for name in ("first_peak", "peak_force", "bounce", "parting", "outcome")
)
FIRST_SHARE, SHARE = FIRST_PEAK[BUFFERED] / FIRST_PEAK[RIGID], PEAK[BUFFERED] / PEAK[RIGID]
FIRST_CONTACT, CONTACT = (1e3 * column("rigid", name) for name in ("first_contact", "contact_time"))  # ms
HARD, SLOW = _masses(RIGID), _masses(BUFFERED)
STROKE, HINGE = cell("motion", 0, "stroke"), cell("motion", 0, "hinge_angle")
AXIAL_LEFT, RELEASE_LEFT = (abs(cell("motion", 0, name)) / STROKE for name in ("end_stroke", "stroke_at_release"))
TURN_LEFT = abs(cell("motion", 0, "end_hinge_angle")) / HINGE
RETURNS = cell("motion", 0, "returns_at").map(
    lambda time: "never passed" if time == NONE else f"first passed at {time:.3g} s"
)
OFFSET, END_OFFSET = (_aligned(name).map(max) for name in ("start_offset", "end_offset"))
START_ANGLE, END_ANGLE, PROBE_ANGLE = (_aligned(f"{name}_attitude") for name in ("start", "end", "probe"))
FREE_CHANGES = [column("tip", name)[FREE] / column("tip", name)[WELDED] - 1.0 for name in ("first_peak", "peak_force")]
ROLLING, CAPTURE_TIME = column("tip", "rolling_share"), column("tip", "capture_time")
FRICTION_IMPULSE, PEAK_FRICTION = (column("tip", name) for name in ("friction_impulse", "peak_friction"))
QUICKER = Value(_quicker)

CLAIMS = (
    Claim(
        "The force without a buffer agrees with theory and experiment of [27]",
        "7, fig. 6",
        "ours {:.4g} N; the figure is lost, and the data of its reference [27] are not available",
        (FIRST_PEAK[RIGID],),
    ),
    Claim(
        "The buffer cuts the impact force drastically against a rigid probe",
        "7, fig. 6-7",
        "first impact {:.4g} N against {:.4g} N ({:.0%}), whole capture {:.4g} N against {:.4g} N ({:.0%})",
        (FIRST_PEAK[BUFFERED], FIRST_PEAK[RIGID], FIRST_SHARE, PEAK[BUFFERED], PEAK[RIGID], SHARE),
        (FIRST_SHARE < 0.5, SHARE < 0.5),
    ),
    Claim(
        "The buffer enhances the collision time",
        "7, fig. 7",
        "rigid, buffered: first impact {:.3g} ms, contact in all {:.3g} ms",
        (FIRST_CONTACT, CONTACT),
        (FIRST_CONTACT.map(_rising), CONTACT.map(_rising)),
    ),
    Claim(
        "The buffer lets the mass of the colliding bodies grow slowly",
        "2, 7",
        "impulse over change of normal speed, impact by impact: rigid {:.3g} kg; buffered {:.3g} kg",
        (HARD, SLOW),
        (SLOW[0] < 0.5 * HARD[0], SLOW.map(_rising)),
    ),
    Claim(
        "The buffer is compressed and returns to its initial length at the end of contact",
        "7, fig. 9",
        "axial compressed by up to {:.3g} mm, {:.0%} of that left at capture, {:.0%} at the last release, its length "
        "{}; torsional {:.0%} left at capture",
        (1e3 * STROKE, AXIAL_LEFT, RELEASE_LEFT, RETURNS, TURN_LEFT),
        (AXIAL_LEFT < BACK, TURN_LEFT < BACK),
    ),
    _captured("Captured at all approach speeds", "8, fig. 10", "speed"),
    _times_go("The higher the approach speed, the shorter the contact duration", "8, fig. 10", "speed", -1.0),
    _captured("Captured at 0, 0.05 and 0.1 °/s", "8, fig. 11", "rate"),
    _captured("Captured at all misalignments", "8, fig. 12", "misalignment"),
    Claim(
        "Vehicles out of line are brought into line, sideways and in angle",
        "1, 2, fig. 11-12",
        "offset of the tip from {:.3g} to at most {:.2g} mm; angle between the vehicles {}°; probe and cone within "
        "{:.2g}° at capture",
        (
            *(1e3 * OFFSET, 1e3 * END_OFFSET),
            listed("{:.2g} to {:.2g}", np.degrees(START_ANGLE), np.degrees(END_ANGLE)),
            np.degrees(PROBE_ANGLE.map(max)),
        ),
        (END_OFFSET < OFFSET, (END_ANGLE <= START_ANGLE).map(all)),
    ),
    Claim(
        "The tip slides on the cone without perfect rebound",
        "8, fig. 12",
        "after the first impact the rigid probe leaves the flank by {:.3g} mm and has {}, the buffered one by {:.3g} "
        "mm and is {}; they part with {:.0%} and {:.0%} of the approach speed (restitution 0.9, assumed)",
        (
            1e3 * BOUNCE[RIGID],
            OUTCOME[RIGID],
            1e3 * BOUNCE[BUFFERED],
            OUTCOME[BUFFERED],
            PARTING[RIGID],
            PARTING[BUFFERED],
        ),
        (BOUNCE[BUFFERED] < 0.1 * BOUNCE[RIGID], OUTCOME[BUFFERED] == "captured"),
    ),
    _captured("Captured at all friction coefficients", "8, fig. 13", "friction"),
    _times_go("More friction, longer total contact duration", "8, fig. 13", "friction", 1.0),
    Claim(
        "A free tip lowers the largest impact force by 7 %",
        "8, fig. 14",
        "first impact {:+.1%}, whole capture {:+.1%}",
        tuple(FREE_CHANGES),
        tuple(abs(change + 0.07) < 0.02 for change in FREE_CHANGES),
    ),
    Claim(
        "A free tip rolls and slides, a welded one only slides",
        "8, fig. 14",
        "no slip beyond the slip speed in {:.0%} of a free tip's time in contact, {:.0%} of a welded one's",
        (ROLLING[FREE], ROLLING[WELDED]),
        # A tip that «rolls and slides» does neither all of the time.
        ((ROLLING[FREE] > 1.0 - SLIDING) & (ROLLING[FREE] < 1.0), ROLLING[WELDED] < 1.0 - SLIDING),
    ),
    Claim(
        "Rolling lowers the friction force",
        "8, fig. 14",
        "welded, free: impulse of friction {:.3g} N s; largest friction {:.3g} N",
        (FRICTION_IMPULSE, PEAK_FRICTION),
        tuple(value[FREE] < LESS * value[WELDED] for value in (FRICTION_IMPULSE, PEAK_FRICTION)),
    ),
    _free_tip_lowers("A free tip shortens the contact duration", "contact_time", "ms", 1e3),
    _free_tip_lowers("A free tip lowers the penetration", "penetration", "µm", 1e6),
    _captured("Captured at all approach speeds with a free tip", "8, fig. 15", "speed_free"),
    _captured("Captured at 0, 0.05 and 0.1 °/s with a free tip", "8, fig. 16", "rate_free"),
    _captured("Captured at all misalignments with a free tip", "8, fig. 17", "misalignment_free"),
    Claim(
        "Capture is faster with a free tip",
        "8",
        "Table 2: {:.3g} s against {:.3g} s; faster in {} of {} pairs of captures",
        (CAPTURE_TIME[FREE], CAPTURE_TIME[WELDED], QUICKER.map(sum), QUICKER.map(len)),
        (QUICKER,),
    ),
)
