"""Run the studies: one row of numbers a capture, and its history for the figures."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..mechanisms.probe_cone.capture import Capture
from ..run.simulate import simulate
from .studies import STUDIES, Study

Row = dict[str, str | float | int]
COLUMNS = {
    "study": "",
    "case": "",
    "value": "",
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


class Studied(NamedTuple):
    """A study with its captures (histories included) and their rows."""

    study: Study
    captures: tuple[Capture, ...]
    rows: tuple[Row, ...]


def captures(studies: tuple[Study, ...] = STUDIES) -> int:
    """How many captures they take."""
    return sum(len(study.cases) for study in studies)


def run(studies: tuple[Study, ...] = STUDIES, done: Callable[[str], None] = lambda _: None) -> list[Studied]:
    """Simulate every case; ``done`` hears of each."""
    found = []
    for study in studies:
        made = []
        for case in study.cases:
            made.append(simulate(case.design, case.scenario, history=True))
            done(f"{study.title}: {case.label}")
        rows = tuple(_row(study, k, capture) for k, capture in enumerate(made))
        found.append(Studied(study, tuple(made), rows))
    return found


def _row(study: Study, k: int, capture: Capture) -> Row:
    history, impacts = capture.history, capture.impacts
    assert history is not None
    case = study.cases[k]
    return {
        "study": study.name,
        "case": case.label,
        "value": case.value,
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
