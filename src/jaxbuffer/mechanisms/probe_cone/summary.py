"""A capture in a dozen lines, for people."""

from functools import partial
from typing import Any

import jax
import numpy as np

from ...elements import Buffer
from ...elements.buffer import extension_line
from ...elements.telling import SummaryRow
from ...value_text import percent_text
from ..energy import energy_text
from ..quantity import NEGLIGIBLE
from .capture import Capture
from .law_validity import warnings
from .outcome import Outcome
from .panels import SUPPLIES, energy_shares, stroke_limits
from .parts import part_of_element, parts_of
from .sanity_checks import cautions
from .vehicle_forces import larger_than_contact

Row = tuple[str, str]  # heading and text; a line without a heading goes on with the one above


def summary(capture: Capture) -> str:
    """Return a capture in a dozen lines, units included."""
    outcome, view = capture.outcome, capture.mechanism.view
    if outcome.failed:
        where = view.label(capture.scenario)
        return f"{view.title}: {outcome.reason} (after {int(capture.attempts)} steps; {where})"
    b = jax.tree.map(np.asarray, capture.balance)
    of_parts = "".join(part.buffer_text(capture) for part in parts_of(capture.design, capture.scenario))
    limits = "".join(f", {what} from {1e3 * float(at):.6g} mm on" for what, at in stroke_limits(capture.design))
    row, longest = partial(SummaryRow.largest, capture), capture.design.buffer.longest_stroke
    rows: list[Row] = [
        ("scenario", view.label(capture.scenario)),
        ("end time", f"{float(capture.end_time):.6g} s, in contact {float(capture.contact_time):.4g} s"),
        *_contact_rows(capture),
        row("hinge_force", "N", "peak hinge force", least=NEGLIGIBLE["N"]).line,
        ("peak buffer force", f"{row('buffer_force', 'N', least=NEGLIGIBLE['N']).text}{of_parts}"),
        row("stroke", "m", "stroke", limit=longest, note=limits, least=NEGLIGIBLE["m"]).line,
        *extension_line(capture),
        row("hinge_angle", "rad", "hinge angle").line,
    ]
    for element in capture.elements:
        # The lines of the buffer are lines of the whole, above.
        if not isinstance(element, Buffer):
            part = part_of_element(element.name)
            rows += element.report.summary(capture) if part is None else part.summary(capture, element)
    rows += [
        ("penetration", f"at most {1e6 * float(capture.penetration):.3g} µm into {view.any_contact(capture.design)}"),
        ("capture margin", _margin(capture)),
        *_energy_rows(capture),
        (
            "numerical balance",
            f"energy {float(b.energy):.1e}, momentum {float(b.linear_momentum):.1e} linear,"
            f" {float(b.angular_momentum):.1e} angular, constraint drift {float(b.drift):.1e} m",
        ),
        ("steps", f"{int(capture.accepted)} accepted of {int(capture.attempts)}"),
    ]
    lines = [*(f"{name:20} {text}" for name, text in rows), *warnings(capture), *cautions(capture.design)]
    return "\n".join([f"{view.title}: {outcome.reason}", *(f"  {line}" for line in lines)])


def _contact_rows(capture: Capture) -> list[Row]:
    """Return the largest contact force, what is larger than it, and the first impact beside its closed form."""
    count = int(capture.impact_count)
    larger = [("", text) for text in (larger_than_contact(capture),) if text]
    if not count:
        untouched = capture.mechanism.view.any_contact(capture.design)
        return [("peak contact force", f"none: the tip did not touch {untouched}"), *larger]
    listed, which = int(capture.impacts.count), int(capture.peak_impact) + 1
    impact = f"impact {which} of {count}"
    if count > listed:
        impact = f"impact {which or f'after the {listed}th'} of {count}, the first {listed} of which are listed"
    largest = f"{float(capture.peak_force):.6g} N at {float(capture.peak_time):.6g} s"
    peak = f"{largest}, {_contact(capture, capture.peak_contact)}, {impact}"
    first, force = capture.first_impact, float(np.asarray(capture.impacts.peak_force)[0])
    text = (
        f"{force:.6g} N; closed form {_predicted(capture)} ({float(first.elastic_peak):.4g} N without loss):"
        f" effective mass {float(first.effective_mass):.4g} kg, energy {float(first.effective_energy):.4g} J"
    )
    if capture.scenario.start == "free":
        text = f"{force:.6g} N, {_contact(capture, capture.impacts.contact[0])}"
    return [("peak contact force", peak), *larger, ("first impact", text)]


def _contact(capture: Capture, number: Any) -> str:
    """Return a contact in words: "upper flank"; "cone" of the only one."""
    view = capture.mechanism.view
    return view.contact_in_words(view.names(capture.design).contact(int(number)))


def _energy_rows(capture: Capture) -> list[Row]:
    """Return the energy of relative motion left with the stroke that it may still take, and the energy at the start,
    what parts put in and where it went."""
    docking, longest = capture.docking, float(capture.design.buffer.longest_stroke)
    begin = float(docking.energy_left) / float(docking.relative_energy)
    share, needed = percent_text(float(docking.relative_energy), ".3g"), float(docking.arrest_stroke)
    left = f"{energy_text(docking.energy_left)} of relative motion, {share} of that at the start"
    if capture.outcome == Outcome.captured:
        left = f"at capture, where the run ends, {left}"
    beyond = ", more than the buffer has" if needed > longest else ""
    energy = jax.tree.map(np.asarray, capture.energy)  # so that sums compile nothing
    put_in = {it.words: -float(energy.stored[it.name]) for it in SUPPLIES if it.name in energy.stored}
    more = "".join(f", {value:.6g} J put in by {name}" for name, value in put_in.items() if value)
    others = "".join(f", {it.place} {float(energy.lost[it.names[-1]]):.3g}" for it in energy_shares(capture))
    return [
        ("energy left", f"{left}; it may take up to {1e3 * needed:.4g} mm of stroke{beyond}"),
        (
            "energy",
            f"{begin:.6g} J of relative motion at the start{more}, dissipated {float(energy.dissipated):.6g} J (axial"
            f" damper {float(energy.axial_damper):.3g}, torsional {float(energy.torsional_damper):.3g}, contact"
            f" {float(energy.hysteresis):.3g}, friction {float(energy.friction):.3g}{others})",
        ),
    ]


def _margin(capture: Capture) -> str:
    """Return the capture margin with what it is a distance of."""
    margin = float(capture.capture_margin)
    if capture.outcome == Outcome.bottomed:
        # By how much the buffer is too short is not said: after its end come further impacts, of vehicles that are far
        # heavier than the probe, and no number of this run tells of them.
        raised = f"none: raise {capture.design.buffer.end_field}, buffer.k_A or buffer.c_A"
        return f"{raised}; only a run that does not bottom says what stroke it needs"
    if capture.outcome != Outcome.captured and capture.mechanism.succeeded(int(capture.outcome)):
        return f"{1e3 * float(capture.stroke_margin):.6g} mm of stroke left before the buffer's end"
    # The margin is the lesser of two (M75): equality tells that it is the stroke's.
    if margin == float(capture.stroke_margin):
        return f"{1e3 * margin:.6g} mm of stroke left before the buffer's end"
    return (
        f"{1e3 * margin:.6g} mm beyond the capture plane at the duration,"
        f" coasting on from {1e3 * float(capture.throat_distance):.4g} mm before it at the end time"
    )


def _predicted(capture: Capture) -> str:
    peak = float(capture.first_impact.predicted_peak)
    return f"{peak:.4g} N" if np.isfinite(peak) else f"unknown for the law {capture.design.contact.law}"


def first_impact_line(capture: Capture) -> str:
    """Return the simulated first peak beside its closed form."""
    first, force = capture.first_impact, float(np.asarray(capture.impacts.peak_force)[0])
    if capture.scenario.start == "free":
        return f"First impact: {force:.6g} N" if int(capture.impact_count) else "First impact: none"
    return (
        f"First impact: {force:.6g} N; closed form {_predicted(capture)}, "
        f"{float(first.elastic_peak):.6g} N without loss (effective energy T_c {float(first.effective_energy):.5g} J)"
    )
