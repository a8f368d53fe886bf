"""What the paper's text claims of its studies, and what the model says to each."""

from collections.abc import Callable, Sequence
from itertools import pairwise

from ..study import NO, YES, Claim, Row, Rows, Verdict
from ..study import verdict as _verdict


def _of(rows: Sequence[Row], name: str) -> list[float]:
    return [float(row[name]) for row in rows]


def _listed(values: Sequence[float], form: str = ".3g") -> str:
    return ", ".join(format(value, form) for value in values)


def _rising(values: Sequence[float]) -> bool:
    return all(a < b for a, b in pairwise(values))


def _cut(rows: Rows) -> Verdict:
    rigid, soft = rows["rigid"]
    first, peak = (float(soft[name]) / float(rigid[name]) for name in ("first_peak", "peak_force"))
    said = (
        f"first impact {float(soft['first_peak']):.4g} N against {float(rigid['first_peak']):.4g} N ({first:.0%}), "
        f"whole capture {float(soft['peak_force']):.4g} N against {float(rigid['peak_force']):.4g} N ({peak:.0%})"
    )
    return Verdict(said, _verdict([first < 0.5, peak < 0.5]))


def _longer(rows: Rows) -> Verdict:
    rigid, soft = rows["rigid"]
    first = [1e3 * float(row["first_contact"]) for row in (rigid, soft)]
    total = [1e3 * float(row["contact_time"]) for row in (rigid, soft)]
    said = f"rigid, buffered: first impact {_listed(first)} ms, contact in all {_listed(total)} ms"
    return Verdict(said, _verdict([first[1] > first[0], total[1] > total[0]]))


def _back(rows: Rows) -> Verdict:
    (row,) = rows["motion"]
    left = abs(float(row["end_stroke"])) / float(row["stroke"])
    said = f"compressed by up to {1e3 * float(row['stroke']):.3g} mm; {left:.0%} of that is left at capture"
    return Verdict(said, YES if left < 0.05 else NO)


def _success(name: str) -> Callable[[Rows], Verdict]:
    def judge(rows: Rows) -> Verdict:
        outcomes = {str(row["case"]): str(row["outcome"]) for row in rows[name]}
        said = ", ".join(f"{case} {outcome}" for case, outcome in outcomes.items())
        return Verdict(said, _verdict([outcome == "captured" for outcome in outcomes.values()]))

    return judge


def _times(row: str, rising: bool) -> Callable[[Rows], Verdict]:
    """Both readings of the paper's "contact duration": time in contact, and time from first contact to capture; of the
    captures that succeed."""

    def judge(rows: Rows) -> Verdict:
        sign = 1.0 if rising else -1.0
        made = [one for one in rows[row] if one["outcome"] == "captured"]
        contact, capture = _of(made, "contact_time"), _of(made, "capture_time")
        said = (
            f"{made[0]['case']} to {made[-1]['case']}: from first contact to capture {_listed(capture)} s; "
            f"in contact {_listed(contact)} s"
        )
        return Verdict(said, _verdict([_rising([sign * t for t in times]) for times in (capture, contact)]))

    return judge


def _seven(rows: Rows) -> Verdict:
    welded, free = rows["tip"]
    first, peak = (float(free[name]) / float(welded[name]) - 1.0 for name in ("first_peak", "peak_force"))
    said = f"first impact {first:+.1%}, whole capture {peak:+.1%}"
    return Verdict(said, _verdict([abs(change + 0.07) < 0.02 for change in (first, peak)]))


def _less(name: str, unit: str, scale: float) -> Callable[[Rows], Verdict]:
    def judge(rows: Rows) -> Verdict:
        welded, free = _of(rows["tip"], name)
        said = f"welded {scale * welded:.4g} {unit}, free {scale * free:.4g} {unit}"
        return Verdict(said, YES if free < welded else NO)

    return judge


def _faster(rows: Rows) -> Verdict:
    names = [("tip", "tip")] + [(name, f"{name}_free") for name in ("speed", "rate", "misalignment")]
    pairs = [tuple(rows["tip"])] + [pair for a, b in names[1:] for pair in zip(rows[a], rows[b], strict=True)]
    both = [pair for pair in pairs if all(row["outcome"] == "captured" for row in pair)]
    quicker = [float(free["capture_time"]) < float(welded["capture_time"]) for welded, free in both]
    welded, free = (float(row["capture_time"]) for row in rows["tip"])
    said = f"Table 2: {free:.3g} s against {welded:.3g} s; faster in {sum(quicker)} of {len(quicker)} pairs of captures"
    return Verdict(said, _verdict(quicker))


CLAIMS = (
    Claim("The buffer cuts the impact force drastically against a rigid probe", "7, fig. 6-7", _cut),
    Claim("The buffer enhances the collision time", "7, fig. 7", _longer),
    Claim("The buffer is compressed and returns to its initial length at the end of contact", "7, fig. 9", _back),
    Claim("Captured at all approach speeds", "8, fig. 10", _success("speed")),
    Claim("The higher the approach speed, the shorter the contact duration", "8, fig. 10", _times("speed", False)),
    Claim("Captured at 0, 0.05 and 0.1 °/s", "8, fig. 11", _success("rate")),
    Claim("Captured at all misalignments", "8, fig. 12", _success("misalignment")),
    Claim("Captured at all friction coefficients", "8, fig. 13", _success("friction")),
    Claim("More friction, longer total contact duration", "8, fig. 13", _times("friction", True)),
    Claim("A free tip lowers the largest impact force by 7 %", "8, fig. 14", _seven),
    Claim("A free tip shortens the contact duration", "8, fig. 14", _less("contact_time", "ms", 1e3)),
    Claim("A free tip lowers the penetration", "8, fig. 14", _less("penetration", "µm", 1e6)),
    Claim("Captured at all approach speeds with a free tip", "8, fig. 15", _success("speed_free")),
    Claim("Captured at 0, 0.05 and 0.1 °/s with a free tip", "8, fig. 16", _success("rate_free")),
    Claim("Captured at all misalignments with a free tip", "8, fig. 17", _success("misalignment_free")),
    Claim("Capture is faster with a free tip", "8", _faster),
)
