"""jaxbuffer and Exudyn on the same captures: outcome, forces, multipliers and motion, at several steps of Exudyn."""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline

import jaxbuffer as jb
from verification.cases import CASES
from verification.docking_cases import DOCKING
from verification.second_opinion.exudyn_model import Found, simulate

NAMES = ("table2", "table2-rolling", "table2-fast", "random-1-6", "random-1-7", "random-1-13", "random-1-14")
DOCKED = {  # runs of docking, and how long Exudyn follows them: until after the latching [s]
    "free start below": 1.0,
    "free start above, all rates": 0.85,
    "through the middle": 0.9,
    "real buffer": 0.6,
    "torn": 0.8,
    "free tip": 0.75,
    "big": 1.2,
}
STEPS = (8e-6, 4e-6)  # s
TIGHT = 1e-9  # rtol of jaxbuffer
QUANTITIES = ("peak_force", "peak_time", "end_time", "stroke", "hinge_angle", "hinge_force")
TIMES = ("peak_time", "end_time")


class Opinions(NamedTuple):
    """One capture by both programs: jaxbuffer's, then Exudyn's by step."""

    name: str
    ours: jb.Capture
    theirs: dict[float, Found]

    def scalars(self, step: float) -> dict[str, float]:
        """Exudyn over jaxbuffer less one, by quantity; times by their difference [s]."""
        other = self.theirs[step]
        values = {name: float(getattr(self.ours, OURS.get(name, name))) for name in QUANTITIES}
        found = {name: getattr(other, name) / value - 1.0 for name, value in values.items()}
        found |= {name: getattr(other, name) - values[name] for name in TIMES}
        found["first_peak"] = other.first_peak / float(self.ours.impacts.peak_force[0]) - 1.0
        if self.ours.design.latch.stiffness is not None:
            found["latch_force"] = other.latch_force / float(self.ours.peak_latch_force) - 1.0
            found["latch_time"] = other.latch_time - float(self.ours.quantity("latch_time"))
        return found

    def deviations(self, step: float) -> dict[str, float]:
        """The same, and how far the motions are apart: any body's centre of mass [m], angle [rad]."""
        other = self.theirs[step]
        apart = {"motion": motion_apart(self.ours, other), "angles": motion_apart(self.ours, other, True)}
        return self.scalars(step) | apart

    def agree(self, step: float) -> bool:
        """Same outcome, number of impacts and flank of the peak."""
        other = self.theirs[step]
        ours = (self.ours.outcome.name, int(self.ours.impact_count), int(self.ours.peak_flank))
        return ours == (other.outcome, other.impacts, other.peak_flank)


HEADINGS = ("first_peak", *(f"{n} [s]" if n in TIMES else n for n in QUANTITIES), "motion [m]", "angles [rad]")
LATCHED, LATCHED_HEADINGS = ("latch_force", "latch_time"), ("latch_force", "latch_time [s]")
OURS = {"hinge_force": "peak_hinge_force"}


def motion_apart(capture: jb.Capture, other: Found, angles: bool = False) -> float:
    """Largest distance [m] (or angle [rad]) between the bodies of the two programs, each millisecond."""
    seen = capture.history
    assert seen is not None
    time, first = np.unique(np.asarray(seen.time), return_index=True)
    course = other.courses[other.courses[:, 0] <= time[-1]]
    # Where the tip spins freely Exudyn's probe is the rod alone, ours the rod with the tip's mass on its end.
    probe = capture.design.probe
    ahead = probe.tip_mass * probe.length / 2 / (probe.tip_mass + probe.rod_mass) if probe.free_tip else 0.0
    path = CubicHermiteSpline(time, np.asarray(seen.position)[first], np.asarray(seen.velocity)[first])
    ours = path(course[:, 0])
    ours[:, 2, 0] -= ahead * np.cos(ours[:, 2, 2])
    ours[:, 2, 1] -= ahead * np.sin(ours[:, 2, 2])
    apart = ours - course[:, 4:].reshape(-1, 4, 3)
    return float(np.max(np.abs(apart[..., 2]) if angles else np.hypot(apart[..., 0], apart[..., 1])))


def ask(name: str, steps: tuple[float, ...] = STEPS, duration: float = 3.0) -> Opinions:
    """Both programs' opinion on a reference capture, or on a run of docking (for as long as `DOCKED` says)."""
    case, duration = (DOCKING[name], DOCKED[name]) if name in DOCKED else (CASES[name], duration)
    ours = jb.simulate(case.design, case.scenario, duration, rtol=TIGHT, history=True)
    return Opinions(name, ours, {step: simulate(case.design, case.scenario, step, duration) for step in steps})


def table(opinions: Opinions) -> str:
    """A capture's deviations, a line for each step, and what they shrink by."""
    ours = opinions.ours
    docked = ours.design.latch.stiffness is not None
    names, headings = (*QUANTITIES, *LATCHED * docked), (*HEADINGS[:-2], *LATCHED_HEADINGS * docked, *HEADINGS[-2:])
    lines = [
        f"{opinions.name}: {ours.outcome.name} at {float(ours.end_time):.7f} s, {int(ours.impact_count)} impacts, peak "
        f"{float(ours.peak_force):.5f} N at {float(ours.peak_time):.7f} s",
        f"  {'step [s]':>9s} {'outcome, impacts, flank':24s} " + " ".join(f"{name:>14s}" for name in headings),
    ]
    rows = []
    for step, other in opinions.theirs.items():
        off = opinions.deviations(step)
        rows.append([off[name] for name in ("first_peak", *names, "motion", "angles")])
        same = "the same" if opinions.agree(step) else f"{other.outcome}, {other.impacts}, {other.peak_flank}"
        lines.append(f"  {step:9.1e} {same:24s} " + " ".join(f"{value:14.1e}" for value in rows[-1]))
    if len(rows) > 1:
        order = [np.log(abs(a / b)) / np.log(s / t) for a, b, s, t in _pairs(rows, list(opinions.theirs))]
        lines.append(f"  {'order':>9s} {'(trapezoidal rule: 2)':24s} " + " ".join(f"{value:14.1f}" for value in order))
    return "\n".join(lines)


def _pairs(rows, steps):
    return [(a, b, steps[-2], steps[-1]) for a, b in zip(rows[-2], rows[-1], strict=True)]
