"""One row of numbers a capture."""

import math

import numpy as np
from scipy.interpolate import CubicSpline

from ...mechanisms.history import History
from ...mechanisms.probe_cone.capture import Capture
from ..claims import NONE, Row
from ..study import StudyCase

FIRST = 5  # impacts whose effective mass is compared
COLUMNS = {
    "outcome": "",
    "peak_force": "N",
    "first_peak": "N",
    "first_contact": "s",
    "contact_time": "s",
    "capture_time": "s",
    "penetration": "m",
    "stroke": "m",
    "end_stroke": "m",
    "stroke_at_release": "m",
    "returns_at": "s",
    "hinge_angle": "rad",
    "end_hinge_angle": "rad",
    "impacts": "-",
    "friction_impulse": "N s",
    "peak_friction": "N",
    "rolling_share": "-",
    "bounce": "m",
    "parting": "-",
    **{f"mass_{k}": "kg" for k in range(1, FIRST + 1)},
    "start_offset": "m",
    "end_offset": "m",
    "start_attitude": "rad",
    "end_attitude": "rad",
    "probe_attitude": "rad",
}
SHOWN = ("outcome", "peak_force", "first_peak", "contact_time", "capture_time", "penetration", "stroke")


def row(case: StudyCase, capture: Capture) -> Row:
    """Return the numbers of one capture, with a history."""
    history, impacts = capture.history, capture.impacts
    assert history is not None
    return {
        "outcome": capture.outcome.name,
        "peak_force": float(capture.peak_force),
        "first_peak": float(impacts.peak_force[0]),
        "first_contact": float(impacts.release_time[0] - impacts.time[0]),
        "contact_time": float(capture.contact_time),
        "capture_time": float(capture.end_time),
        # The run's own penetration is an upper bound (M72), while a history has the depth itself.
        "penetration": float(np.max(-np.asarray(history.gap))),
        "hinge_angle": float(capture.hinge_angle),
        "impacts": int(capture.impact_count),
        **_buffer(capture, history),
        **_friction(capture, history),
        **_first_impacts(capture, history),
        **_alignment(capture, history),
    }


def _buffer(capture: Capture, history: History) -> Row:
    """Return both buffers when contact ends; ``returns_at``: when the stroke is back at zero after its largest
    value."""
    time, stroke = np.asarray(history.time), np.asarray(history.stroke)
    releases = np.asarray(capture.impacts.release_time)[: int(capture.impact_count)]
    # Of a contact that is still closed at the end there is no release.
    last = np.max(releases[~np.isnan(releases)], initial=0.0)
    top = int(np.argmax(stroke))
    back = np.flatnonzero(stroke[top:] <= 0.0)
    return {
        "stroke": float(capture.stroke),
        "end_stroke": float(stroke[-1]),
        "stroke_at_release": float(np.interp(last, time, stroke)),
        "returns_at": float(time[top + back[0]]) if len(back) else NONE,
        "end_hinge_angle": float(np.asarray(history.hinge_angle)[-1]),
    }


def _friction(capture: Capture, history: History) -> Row:
    """Return the numbers of friction. ``rolling_share``: of the time in contact, in which the tip slips by less than
    the slip speed."""
    time, friction = np.asarray(history.time), np.abs(np.asarray(history.friction_force))
    touching = np.asarray(history.contact_force) > 0.0
    rolling = touching & (np.abs(np.asarray(history.slip)) < float(capture.design.contact.slip_speed))
    contact = float(np.trapezoid(touching.sum(1), time))
    return {
        "friction_impulse": float(np.trapezoid(friction.sum(1), time)),
        "peak_friction": float(friction.max()),
        "rolling_share": float(np.trapezoid(rolling.sum(1), time)) / contact,
    }


def _first_impacts(capture: Capture, history: History) -> Row:
    """Return the effective mass of each of the first impacts: impulse over the change of the normal speed. ``parting``:
    of the first, separation over approach speed; ``bounce``: gap that follows it."""
    time, impacts = np.asarray(history.time), capture.impacts
    masses, parting, bounce = [math.nan] * FIRST, math.nan, 0.0
    for k in range(min(FIRST, int(capture.impact_count))):
        start, end, side = float(impacts.time[k]), float(impacts.release_time[k]), int(impacts.contact[k])
        # An impact that the run's end cuts off has no impulse to compare.
        if math.isnan(end):
            break
        inside = (time >= start) & (time <= end)
        apart = -float(np.asarray(history.approach_speed)[inside, side][-1])
        # A history may hold an instant twice, which a spline does not take.
        instants, first = np.unique(time[inside], return_index=True)
        forces = np.asarray(history.contact_force)[inside, side][first]
        impulse = float(CubicSpline(instants, forces).integrate(start, end))  # some ten steps an impact
        masses[k] = impulse / (float(impacts.approach_speed[k]) + apart)
        if k == 0:
            parting = apart / float(impacts.approach_speed[0])
            after = float(impacts.time[1]) if int(capture.impact_count) > 1 else math.inf
            bounce = float(np.asarray(history.gap)[(time >= end) & (time <= after), side].max(initial=0.0))
    named = {f"mass_{k}": mass for k, mass in enumerate(masses, 1)}
    return {"parting": parting, "bounce": bounce, **named}


def _alignment(capture: Capture, history: History) -> Row:
    """Return the offset of the tip's centre from the cone's axis, angle of the active vehicle against the passive one,
    at the start and at the end; angle of the probe against the cone where it is captured."""
    cone, angle = capture.design.cone, np.asarray(history.position)[:, :, 2]
    active, passive = angle[:, 0], angle[:, 3]
    half, radius = float(cone.half_angle), float(capture.design.probe.tip_radius)
    along = float(capture.scenario.contact_distance)
    return {
        "start_offset": radius * math.cos(half) - float(cone.throat_radius) - along * math.sin(half),
        "end_offset": float(capture.docking.lateral_miss),
        "start_attitude": float(active[0] - passive[0]),
        "end_attitude": float(active[-1] - passive[-1]),
        "probe_attitude": float(capture.docking.attitude_miss),
    }
