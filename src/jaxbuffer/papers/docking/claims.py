"""What the paper's text claims of its studies, and what the model says to each."""

import math
from collections.abc import Sequence
from itertools import pairwise

from ..study import NO, NONE, OPEN, YES, Claims, ClaimVerdict, Judge, Row, Rows
from ..study import verdict as _verdict
from .rows import FIRST

BACK = 0.05  # of its largest value: a buffer that is compressed by less is back at its length
SLIDING = 0.9  # of the time in contact, in which a tip slides that «has just sliding motion»
LESS = 0.99  # of a number: what is less than it by more than the solver's error


def _of(rows: Sequence[Row], name: str) -> list[float]:
    return [float(row[name]) for row in rows]


def _listed(values: Sequence[float], form: str = ".3g") -> str:
    return ", ".join(format(value, form) for value in values)


def _rising(values: Sequence[float]) -> bool:
    return all(a < b for a, b in pairwise(values))


CLAIMS = Claims()


def _success(name: str) -> Judge:
    def judge(rows: Rows) -> ClaimVerdict:
        outcomes = {str(row["case"]): str(row["outcome"]) for row in rows[name]}
        finding = ", ".join(f"{case} {outcome}" for case, outcome in outcomes.items())
        return ClaimVerdict(finding, _verdict([outcome == "captured" for outcome in outcomes.values()]))

    return judge


def _times(row: str, rising: bool) -> Judge:
    """Return both readings of the paper's "contact duration": time in contact, and time from first contact to capture;
    of the captures that succeed."""

    def judge(rows: Rows) -> ClaimVerdict:
        sign = 1.0 if rising else -1.0
        # How long a capture takes says nothing where there is none.
        made = [one for one in rows[row] if one["outcome"] == "captured"]
        contact, capture = _of(made, "contact_time"), _of(made, "capture_time")
        finding = (
            f"{made[0]['case']} to {made[-1]['case']}: from first contact to capture {_listed(capture)} s; "
            f"in contact {_listed(contact)} s"
        )
        return ClaimVerdict(finding, _verdict([_rising([sign * t for t in times]) for times in (capture, contact)]))

    return judge


def _less(name: str, unit: str, scale: float) -> Judge:
    def judge(rows: Rows) -> ClaimVerdict:
        welded, free = _of(rows["tip"], name)
        finding = f"welded {scale * welded:.4g} {unit}, free {scale * free:.4g} {unit}"
        return ClaimVerdict(finding, YES if free < LESS * welded else NO)

    return judge


@CLAIMS.judge("The force without a buffer agrees with theory and experiment of [27]", "7, fig. 6")
def _literature(rows: Rows) -> ClaimVerdict:
    rigid = rows["rigid"][0]
    peak = float(rigid["first_peak"])
    finding = f"ours {peak:.4g} N; the figure is lost, and the data of its reference [27] are not available"
    return ClaimVerdict(finding, OPEN)


@CLAIMS.judge("The buffer cuts the impact force drastically against a rigid probe", "7, fig. 6-7")
def _cut(rows: Rows) -> ClaimVerdict:
    rigid, soft = rows["rigid"]
    first, peak = (float(soft[name]) / float(rigid[name]) for name in ("first_peak", "peak_force"))
    finding = (
        f"first impact {float(soft['first_peak']):.4g} N against {float(rigid['first_peak']):.4g} N ({first:.0%}), "
        f"whole capture {float(soft['peak_force']):.4g} N against {float(rigid['peak_force']):.4g} N ({peak:.0%})"
    )
    return ClaimVerdict(finding, _verdict([first < 0.5, peak < 0.5]))


@CLAIMS.judge("The buffer enhances the collision time", "7, fig. 7")
def _longer(rows: Rows) -> ClaimVerdict:
    rigid, soft = rows["rigid"]
    first = [1e3 * float(row["first_contact"]) for row in (rigid, soft)]
    total = [1e3 * float(row["contact_time"]) for row in (rigid, soft)]
    finding = f"rigid, buffered: first impact {_listed(first)} ms, contact in all {_listed(total)} ms"
    return ClaimVerdict(finding, _verdict([first[1] > first[0], total[1] > total[0]]))


@CLAIMS.judge("The buffer lets the mass of the colliding bodies grow slowly", "2, 7")
def _masses(rows: Rows) -> ClaimVerdict:
    # Impacts that a run does not have, or that its end cuts off, are the word `NONE`.
    rigid, soft = ([v for k in range(1, FIRST + 1) if (v := row[f"mass_{k}"]) != NONE] for row in rows["rigid"])
    hard, slow = [float(m) for m in rigid], [float(m) for m in soft]
    finding = (
        f"impulse over change of normal speed, impact by impact: rigid {_listed(hard)} kg; buffered {_listed(slow)} kg"
    )
    return ClaimVerdict(finding, _verdict([slow[0] < 0.5 * hard[0], _rising(slow)]))


@CLAIMS.judge("The buffer is compressed and returns to its initial length at the end of contact", "7, fig. 9")
def _back(rows: Rows) -> ClaimVerdict:
    (row,) = rows["motion"]
    axial, last = (abs(float(row[name])) / float(row["stroke"]) for name in ("end_stroke", "stroke_at_release"))
    turned = abs(float(row["end_hinge_angle"])) / float(row["hinge_angle"])
    passed = "never passed" if row["returns_at"] == NONE else f"first passed at {float(row['returns_at']):.3g} s"
    finding = (
        f"axial compressed by up to {1e3 * float(row['stroke']):.3g} mm, {axial:.0%} of that left at capture, "
        f"{last:.0%} at the last release, its length {passed}; torsional {turned:.0%} left at capture"
    )
    return ClaimVerdict(finding, _verdict([axial < BACK, turned < BACK]))


CLAIMS.judge("Captured at all approach speeds", "8, fig. 10")(_success("speed"))
CLAIMS.judge("The higher the approach speed, the shorter the contact duration", "8, fig. 10")(_times("speed", False))
CLAIMS.judge("Captured at 0, 0.05 and 0.1 °/s", "8, fig. 11")(_success("rate"))
CLAIMS.judge("Captured at all misalignments", "8, fig. 12")(_success("misalignment"))


@CLAIMS.judge("Vehicles out of line are brought into line, sideways and in angle", "1, 2, fig. 11-12")
def _aligned(rows: Rows) -> ClaimVerdict:
    # A run without a capture has no crossing at which the tip's offset could be told.
    made = [row for name in ("misalignment", "rate") for row in rows[name] if row["outcome"] == "captured"]
    offset = [max(abs(x) for x in _of(made, name)) for name in ("start_offset", "end_offset")]
    first, last, probe = ([abs(x) for x in _of(made, f"{name}_attitude")] for name in ("start", "end", "probe"))
    turned = [f"{math.degrees(a):.2g} to {math.degrees(b):.2g}" for a, b in zip(first, last, strict=True)]
    finding = (
        f"offset of the tip from {1e3 * offset[0]:.3g} to at most {1e3 * offset[1]:.2g} mm; angle between the vehicles "
        f"{', '.join(turned)}°; probe and cone within {math.degrees(max(probe)):.2g}° at capture"
    )
    return ClaimVerdict(
        finding, _verdict([offset[1] < offset[0], all(b <= a for a, b in zip(first, last, strict=True))])
    )


@CLAIMS.judge("The tip slides on the cone without perfect rebound", "8, fig. 12")
def _rebound(rows: Rows) -> ClaimVerdict:
    rigid, soft = rows["rigid"]
    speeds = [f"{float(row['parting']):.0%}" for row in (rigid, soft)]
    bounces = [1e3 * float(row["bounce"]) for row in (rigid, soft)]
    finding = (
        f"after the first impact the rigid probe leaves the flank by {bounces[0]:.3g} mm and has {rigid['outcome']}, "
        f"the buffered one by {bounces[1]:.3g} mm and is {soft['outcome']}; they part with {speeds[0]} and "
        f"{speeds[1]} of the approach speed (restitution 0.9, assumed)"
    )
    return ClaimVerdict(finding, _verdict([bounces[1] < 0.1 * bounces[0], soft["outcome"] == "captured"]))


CLAIMS.judge("Captured at all friction coefficients", "8, fig. 13")(_success("friction"))
CLAIMS.judge("More friction, longer total contact duration", "8, fig. 13")(_times("friction", True))


@CLAIMS.judge("A free tip lowers the largest impact force by 7 %", "8, fig. 14")
def _seven(rows: Rows) -> ClaimVerdict:
    welded, free = rows["tip"]
    first, peak = (float(free[name]) / float(welded[name]) - 1.0 for name in ("first_peak", "peak_force"))
    finding = f"first impact {first:+.1%}, whole capture {peak:+.1%}"
    return ClaimVerdict(finding, _verdict([abs(change + 0.07) < 0.02 for change in (first, peak)]))


@CLAIMS.judge("A free tip rolls and slides, a welded one only slides", "8, fig. 14")
def _rolls(rows: Rows) -> ClaimVerdict:
    welded, free = _of(rows["tip"], "rolling_share")
    finding = (
        f"no slip beyond the slip speed in {free:.0%} of a free tip's time in contact, {welded:.0%} of a welded one's"
    )
    # A tip that «rolls and slides» does neither all of the time.
    return ClaimVerdict(finding, _verdict([1.0 - SLIDING < free < 1.0, welded < 1.0 - SLIDING]))


@CLAIMS.judge("Rolling lowers the friction force", "8, fig. 14")
def _friction_falls(rows: Rows) -> ClaimVerdict:
    (w, f), (wp, fp) = (_of(rows["tip"], name) for name in ("friction_impulse", "peak_friction"))
    finding = f"welded, free: impulse of friction {w:.3g}, {f:.3g} N s; largest friction {wp:.3g}, {fp:.3g} N"
    return ClaimVerdict(finding, _verdict([f < LESS * w, fp < LESS * wp]))


CLAIMS.judge("A free tip shortens the contact duration", "8, fig. 14")(_less("contact_time", "ms", 1e3))
CLAIMS.judge("A free tip lowers the penetration", "8, fig. 14")(_less("penetration", "µm", 1e6))
CLAIMS.judge("Captured at all approach speeds with a free tip", "8, fig. 15")(_success("speed_free"))
CLAIMS.judge("Captured at 0, 0.05 and 0.1 °/s with a free tip", "8, fig. 16")(_success("rate_free"))
CLAIMS.judge("Captured at all misalignments with a free tip", "8, fig. 17")(_success("misalignment_free"))


@CLAIMS.judge("Capture is faster with a free tip", "8")
def _faster(rows: Rows) -> ClaimVerdict:
    names = [("tip", "tip")] + [(name, f"{name}_free") for name in ("speed", "rate", "misalignment")]
    pairs = [tuple(rows["tip"])] + [pair for a, b in names[1:] for pair in zip(rows[a], rows[b], strict=True)]
    # A pair counts only where both tips are captured.
    both = [pair for pair in pairs if all(row["outcome"] == "captured" for row in pair)]
    quicker = [float(free["capture_time"]) < LESS * float(welded["capture_time"]) for welded, free in both]
    welded, free = (float(row["capture_time"]) for row in rows["tip"])
    finding = (
        f"Table 2: {free:.3g} s against {welded:.3g} s; faster in {sum(quicker)} of {len(quicker)} pairs of captures"
    )
    return ClaimVerdict(finding, _verdict(quicker))
