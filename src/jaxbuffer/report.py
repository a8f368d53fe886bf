"""Summaries and tables for people."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .capture import Capture

FLANKS = ("lower", "upper")


def summary(capture: "Capture") -> str:
    """A capture in a dozen lines, units included."""
    outcome = capture.outcome
    if outcome.failed:
        return f"Capture: {outcome.reason} (after {int(capture.attempts)} steps)"
    flank, impact = FLANKS[int(capture.peak_flank)], int(capture.peak_impact) + 1
    e, b = capture.energy, capture.balance
    lines = [
        f"Capture: {outcome.reason}",
        f"  end time             {float(capture.end_time):.6g} s, in contact {float(capture.contact_time):.4g} s",
        f"  peak contact force   {float(capture.peak_force):.6g} N at {float(capture.peak_time):.6g} s,"
        f" {flank} flank, impact {impact} of {int(capture.impact_count)}",
        f"  peak hinge force     {float(capture.peak_hinge_force):.6g} N",
        f"  peak buffer force    {float(capture.peak_buffer_force):.6g} N",
        f"  stroke               {1e3 * float(capture.stroke):.6g} mm",
        f"  hinge angle          {np.degrees(float(capture.hinge_angle)):.6g} deg",
        f"  energy               {float(e.total):.6g} J, of which dissipated {float(e.dissipated):.6g} J"
        f" (axial damper {float(e.axial_damper):.3g}, torsional {float(e.torsional_damper):.3g},"
        f" contact {float(e.hysteresis):.3g}, friction {float(e.friction):.3g})",
        f"  numerical balance    energy {float(b.energy):.1e}, momentum {float(b.linear_momentum):.1e} linear,"
        f" {float(b.angular_momentum):.1e} angular, constraint drift {float(b.drift):.1e} m",
        f"  steps                {int(capture.accepted)} accepted of {int(capture.attempts)}",
    ]
    return "\n".join(lines)
