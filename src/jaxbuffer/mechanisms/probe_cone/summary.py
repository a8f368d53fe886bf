"""A capture in a dozen lines, for people."""

from typing import Any

import jax
import numpy as np

from ...elements import Buffer, Element
from ...elements.buffer import extension_text
from ...elements.telling import when
from ...labelled.record import heading
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


def summary(capture: Capture) -> str:
    """Return a capture in a dozen lines, units included."""
    outcome, view = capture.outcome, capture.mechanism.view
    if outcome.failed:
        where = view.label(capture.scenario)
        return f"{view.title}: {outcome.reason} (after {int(capture.attempts)} steps; {where})"
    e, b = jax.tree.map(np.asarray, (capture.energy, capture.balance))  # so that sums compile nothing
    at = capture.maximum_times
    lines = [
        f"{view.title}: {outcome.reason}",
        f"  scenario             {view.label(capture.scenario)}",
        f"  end time             {float(capture.end_time):.6g} s, in contact {float(capture.contact_time):.4g} s",
        f"  peak contact force   {_peak(capture)}",
        *_larger(capture),
        *_first_impact(capture),
        f"  peak hinge force     {_force(capture, 'hinge_force', at)}",
        f"  peak buffer force    {_force(capture, 'buffer_force', at)}{_of_parts(capture)}",
        f"  stroke               {_stroke(capture, at)}",
        *(f"  extension            {text}" for text in (extension_text(capture),) if text),
        f"  hinge angle          {np.degrees(float(capture.hinge_angle)):.6g} deg{when(at['hinge_angle'])}",
        *(line for element in capture.elements for line in _of_part(capture, element)),
        f"  penetration          at most {1e6 * float(capture.penetration):.3g} µm into a {view.contact}",
        f"  capture margin       {_margin(capture)}",
        f"  energy left          {_energy_left(capture)}",
        f"  energy               {_energy_before(capture)}, dissipated {float(e.dissipated):.6g} J"
        f" (axial damper {float(e.axial_damper):.3g}, torsional {float(e.torsional_damper):.3g},"
        f" contact {float(e.hysteresis):.3g}, friction {float(e.friction):.3g}{_other_losses(capture)})",
        f"  numerical balance    energy {float(b.energy):.1e}, momentum {float(b.linear_momentum):.1e} linear,"
        f" {float(b.angular_momentum):.1e} angular, constraint drift {float(b.drift):.1e} m",
        f"  steps                {int(capture.accepted)} accepted of {int(capture.attempts)}",
    ]
    return "\n".join([*lines, *(f"  {line}" for line in [*warnings(capture), *cautions(capture.design)])])


def _force(capture: Capture, name: str, at: dict[str, float]) -> str:
    """Return the largest value of a force and when it occurs; "0 N" where it is only rounding."""
    force = float(capture.quantity(f"peak_{name}"))
    return "0 N" if force < NEGLIGIBLE["N"] else f"{force:.6g} N{when(at[name])}"


def _stroke(capture: Capture, at: dict[str, float]) -> str:
    stroke, limits = float(capture.stroke), _stroke_limits(capture)
    if stroke < NEGLIGIBLE["m"]:
        return f"0 mm{limits}"
    return f"{1e3 * stroke:.6g} mm{limits}{when(at['stroke'])}"


def _peak(capture: Capture) -> str:
    if not int(capture.impact_count):
        return f"none: the tip touched no {capture.mechanism.view.contact}"
    when = f"{float(capture.peak_force):.6g} N at {float(capture.peak_time):.6g} s"
    return f"{when}, {_contact(capture, capture.peak_contact)}, {_which_impact(capture)}"


def _contact(capture: Capture, number: Any) -> str:
    """Return a contact in words: "upper flank"; "cone" of the only one."""
    view = capture.mechanism.view
    return view.contact_in_words(view.names(capture.design).contact(int(number)))


def _larger(capture: Capture) -> list[str]:
    text = larger_than_contact(capture)
    return [f"                       {text}"] if text else []


def _first_impact(capture: Capture) -> list[str]:
    first, peak = capture.first_impact, float(np.asarray(capture.impacts.peak_force)[0])
    if not int(capture.impact_count):
        return []
    if capture.scenario.start == "free":
        return [f"  first impact         {peak:.6g} N, {_contact(capture, capture.impacts.contact[0])}"]
    return [
        f"  first impact         {peak:.6g} N; closed form {_predicted(capture)} ({float(first.elastic_peak):.4g} N"
        f" without loss): effective mass {float(first.effective_mass):.4g} kg,"
        f" energy {float(first.effective_energy):.4g} J"
    ]


def _of_part(capture: Capture, element: Element) -> list[str]:
    """Return the lines of one part; those of the buffer are lines of the whole."""
    if isinstance(element, Buffer):
        return []
    part = part_of_element(element.name)
    lines = element.report.summary(capture) if part is None else part.summary(capture, element)
    return [f"  {heading:20} {text}" for heading, text in lines]


def _energy_before(capture: Capture) -> str:
    """Return the energy of relative motion at the start, and what parts put in."""
    begin = float(capture.docking.energy_left) / float(capture.docking.relative_energy)
    stored = capture.energy.stored
    put_in = {it.words: -float(np.asarray(stored[it.name])) for it in SUPPLIES if it.name in stored}
    more = "".join(f", {energy:.6g} J put in by {name}" for name, energy in put_in.items() if energy)
    return f"{begin:.6g} J of relative motion at the start{more}"


def _energy_left(capture: Capture) -> str:
    """Return the energy of relative motion left, and the stroke that it may still take."""
    docking, longest = capture.docking, float(capture.design.buffer.longest_stroke)
    share = percent_text(float(docking.relative_energy), ".3g")
    left = f"{energy_text(docking.energy_left)} of relative motion, {share} of that"
    needed = float(docking.arrest_stroke)
    beyond = ", more than the buffer has" if needed > longest else ""
    left = f"at capture, where the run ends, {left}" if capture.outcome == Outcome.captured else left
    return f"{left} at the start; it may take up to {1e3 * needed:.4g} mm of stroke{beyond}"


def _other_losses(capture: Capture) -> str:
    lost = capture.energy.lost
    return "".join(f", {it.place} {float(lost[it.names[-1]]):.3g}" for it in energy_shares(capture))


def _which_impact(capture: Capture) -> str:
    count, listed = int(capture.impact_count), int(capture.impacts.count)
    which = int(capture.peak_impact) + 1
    if count == listed:
        return f"impact {which} of {count}"
    return f"impact {which or f'after the {listed}th'} of {count}, the first {listed} of which are listed"


def _of_parts(capture: Capture) -> str:
    """Return what parts say beside the buffer's force."""
    return "".join(part.buffer_text(capture) for part in parts_of(capture.design, capture.scenario))


def _stroke_limits(capture: Capture) -> str:
    limits = (f", {what} from {1e3 * float(place):.6g} mm on" for what, place in stroke_limits(capture.design))
    return f" of {1e3 * float(capture.design.buffer.longest_stroke):.6g} mm{''.join(limits)}"


def _bottomed(capture: Capture) -> str:
    """Return what would keep the buffer from its end. By how much it is too short is not said: after the end come
    further impacts, of vehicles that are far heavier than the probe, and no number of this run tells of them."""
    longer = capture.design.buffer.end_field
    return f"none: raise {longer}, buffer.k_A or buffer.c_A; only a run that does not bottom says what stroke it needs"


def _margin(capture: Capture) -> str:
    """Return the capture margin with what it is a distance of."""
    margin = float(capture.capture_margin)
    if capture.outcome == Outcome.bottomed:
        return _bottomed(capture)
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


def first_impact_record(capture: Capture) -> dict[str, float]:
    """Return the closed form of the first impact, units in the names."""
    first = capture.first_impact
    return {
        heading("effective_mass", "kg"): float(first.effective_mass),
        heading("effective_energy", "J"): float(first.effective_energy),
        heading("elastic_peak", "N"): float(first.elastic_peak),
        heading("predicted_peak", "N"): float(first.predicted_peak),
    }
