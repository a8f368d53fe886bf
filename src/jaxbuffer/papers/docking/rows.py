"""One row of numbers a capture."""

import numpy as np

from ...mechanisms.probe_cone.capture import Capture
from ..study import Case, Row

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
    "hinge_angle": "rad",
    "impacts": "-",
}
SHOWN = ("outcome", "peak_force", "first_peak", "contact_time", "capture_time", "penetration", "stroke")


def row(case: Case, capture: Capture) -> Row:
    """The numbers of one capture, with a history."""
    history, impacts = capture.history, capture.impacts
    assert history is not None
    return {
        "outcome": capture.outcome.name,
        "peak_force": float(capture.peak_force),
        "first_peak": float(impacts.peak_force[0]),
        "first_contact": float(impacts.release_time[0] - impacts.time[0]),
        "contact_time": float(capture.contact_time),
        "capture_time": float(capture.end_time),
        "penetration": float(np.max(-np.asarray(history.gap))),
        "stroke": float(capture.stroke),
        "end_stroke": float(np.asarray(history.stroke)[-1]),
        "hinge_angle": float(capture.hinge_angle),
        "impacts": int(capture.impact_count),
    }
