"""A capture in a dozen lines, for people."""

import jax
import numpy as np

from ...labelled.record import heading
from ...value_text import percent_text
from ..energy import energy_text
from ..quantity import NEGLIGIBLE
from .assembly import CONTACTS, pin_law
from .bending import bending_frequencies
from .capture import Capture
from .label import scenario_label
from .latch_energy import closing_words
from .law_validity import warnings
from .outcome import Outcome
from .vehicle_forces import larger_than_contact


def summary(capture: Capture) -> str:
    """Return a capture in a dozen lines, units included."""
    outcome = capture.outcome
    if outcome.failed:
        where = scenario_label(capture.scenario)
        return f"Capture: {outcome.reason} (after {int(capture.attempts)} steps; {where})"
    e, b = jax.tree.map(np.asarray, (capture.energy, capture.balance))  # so that sums compile nothing
    at = capture.maximum_times
    lines = [
        f"Capture: {outcome.reason}",
        f"  scenario             {scenario_label(capture.scenario)}",
        f"  end time             {float(capture.end_time):.6g} s, in contact {float(capture.contact_time):.4g} s",
        f"  peak contact force   {_peak(capture)}",
        *_larger(capture),
        *_first_impact(capture),
        f"  peak hinge force     {_force(capture, 'hinge_force')}",
        f"  peak buffer force    {_force(capture, 'buffer_force')}{_stop(capture)}",
        f"  stroke               {_stroke(capture)}",
        f"  hinge angle          {np.degrees(float(capture.hinge_angle)):.6g} deg{_when(at['hinge_angle'])}",
        *_bending(capture),
        *_play(capture),
        *_latch(capture),
        *_shock(capture),
        f"  penetration          at most {1e6 * float(capture.penetration):.3g} µm into a flank",
        f"  capture margin       {_margin(capture)}",
        f"  energy left          {_energy_left(capture)}",
        f"  energy               {_energy_before(capture)}, dissipated {float(e.dissipated):.6g} J"
        f" (axial damper {float(e.axial_damper):.3g}, torsional {float(e.torsional_damper):.3g},"
        f" contact {float(e.hysteresis):.3g}, friction {float(e.friction):.3g}{_other_losses(capture)})",
        f"  numerical balance    energy {float(b.energy):.1e}, momentum {float(b.linear_momentum):.1e} linear,"
        f" {float(b.angular_momentum):.1e} angular, constraint drift {float(b.drift):.1e} m",
        f"  steps                {int(capture.accepted)} accepted of {int(capture.attempts)}",
    ]
    return "\n".join([*lines, *(f"  {line}" for line in warnings(capture))])


def _when(time: float) -> str:
    return f" at {time:.6g} s" if np.isfinite(time) else ""


def _force(capture: Capture, name: str) -> str:
    """Return the largest value of a force and when it occurs; "0 N" where it is only rounding."""
    force = float(capture.quantity(f"peak_{name}"))
    return "0 N" if force < NEGLIGIBLE["N"] else f"{force:.6g} N{_when(capture.maximum_times[name])}"


def _stroke(capture: Capture) -> str:
    stroke, limits = float(capture.stroke), _stroke_limits(capture)
    if stroke < NEGLIGIBLE["m"]:
        return f"0 mm{limits}"
    return f"{1e3 * stroke:.6g} mm{limits}{_when(capture.maximum_times['stroke'])}"


def _peak(capture: Capture) -> str:
    if not int(capture.impact_count):
        return "none: the tip touched no flank"
    flank = CONTACTS[int(capture.peak_contact)]
    when = f"{float(capture.peak_force):.6g} N at {float(capture.peak_time):.6g} s"
    return f"{when}, {flank} flank, {_which_impact(capture)}"


def _larger(capture: Capture) -> list[str]:
    text = larger_than_contact(capture)
    return [f"                       {text}"] if text else []


def _first_impact(capture: Capture) -> list[str]:
    first, peak = capture.first_impact, float(np.asarray(capture.impacts.peak_force)[0])
    if not int(capture.impact_count):
        return []
    if capture.scenario.start == "free":
        return [f"  first impact         {peak:.6g} N, {CONTACTS[int(capture.impacts.contact[0])]} flank"]
    return [
        f"  first impact         {peak:.6g} N; closed form {_predicted(capture)} ({float(first.elastic_peak):.4g} N"
        f" without loss): effective mass {float(first.effective_mass):.4g} kg,"
        f" energy {float(first.effective_energy):.4g} J"
    ]


def _latch(capture: Capture) -> list[str]:
    """Return when the latches closed, what they exerted, and how the tip met them."""
    latch, docking = capture.design.latch, capture.docking
    if latch.stiffness is None or not np.isfinite(float(docking.latch_time)):
        return []
    settled = "" if capture.outcome != Outcome.held else f", held {float(docking.settling_time):.4g} s later"
    strength = "" if latch.strength is None else f" of {float(latch.strength):.6g} N strength"
    return [
        f"  latched              at {float(docking.latch_time):.6g} s{settled}; latch force at most"
        f" {float(capture.peak_latch_force):.6g} N{strength}{_when(capture.maximum_times.get('latch_force', np.nan))}",
        f"  tip at the latches   {1e3 * float(docking.lateral_miss):.4g} mm off the axis,"
        f" {np.degrees(float(docking.attitude_miss)):.4g} deg against it",
        *(f"  energy of the latch  {text}" for text in (closing_words(capture),) if text),
    ]


def _shock(capture: Capture) -> list[str]:
    """Return what equipment on the vehicles feels, if its frequencies are named."""
    felt = [
        f"{name.partition('_')[0]} {float(capture.quantity(name)):.4g} m/s² at {float(frequency):.4g} Hz"
        for name, frequency in capture.design.shock.frequencies.items()
    ]
    return [f"  shock                {', '.join(felt)}"] if felt else []


def _energy_before(capture: Capture) -> str:
    """Return the energy of relative motion at the start, and what latches and thrust put in."""
    begin = float(capture.docking.energy_left) / float(capture.docking.relative_energy)
    put_in = {
        name: -float(np.asarray(capture.energy.stored[key]))
        for name, key in (("the closing of the latches", "latch_closing"), ("the thrust", "thrust"))
        if key in capture.energy.stored
    }
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


def _bending(capture: Capture) -> list[str]:
    probe = capture.design.probe
    if probe.bending_stiffness is None:
        return []
    frequencies = np.asarray(bending_frequencies(capture.design))
    return [
        f"  bending              at most {1e3 * float(capture.bending):.4g} mm at the tip; {probe.bending_modes} modes,"
        f" {frequencies[0]:.4g} to {frequencies[-1]:.4g} Hz, the first damped to"
        f" {percent_text(np.pi * frequencies[0] * float(probe.bending_damping), '.3g')}"
    ]


def _play(capture: Capture) -> list[str]:
    hinge = capture.design.hinge
    if hinge.play is None:
        return []
    depth = float(pin_law(capture.design).depth(capture.peak_hinge_force))
    return [f"  play in the hinge    {1e3 * float(hinge.play):.4g} mm; the pin goes up to {1e6 * depth:.3g} µm into it"]


def _other_losses(capture: Capture) -> str:
    energy, design = capture.energy, capture.design
    there = {
        "end stop": (design.buffer.stop_stiffness, "stop_damper"),
        "hinge's play": (design.hinge.play, "hinge_play"),
        "bending": (design.probe.bending_stiffness, "bending"),
        "buffer's friction": (design.buffer.friction, "buffer_friction"),
        "rebound stop": (design.buffer.rebound_stiffness, "rebound_damper"),
        "latch": (design.latch.stiffness, "latch_damper"),
    }
    return "".join(
        f", {name} {float(getattr(energy, loss)):.3g}" for name, (given, loss) in there.items() if given is not None
    )


def _which_impact(capture: Capture) -> str:
    count, listed = int(capture.impact_count), int(capture.impacts.count)
    which = int(capture.peak_impact) + 1
    if count == listed:
        return f"impact {which} of {count}"
    return f"impact {which or f'after the {listed}th'} of {count}, the first {listed} of which are listed"


def _stop(capture: Capture) -> str:
    if capture.design.buffer.stop_stiffness is None:
        return ""
    return f", end stop {float(capture.peak_stop_force):.6g} N"


def _stroke_limits(capture: Capture) -> str:
    buffer = capture.design.buffer
    whole = f" of {1e3 * float(buffer.longest_stroke):.6g} mm"
    return whole if buffer.stop_stiffness is None else f"{whole}, end stop from {1e3 * float(buffer.end):.6g} mm on"


def _bottomed(capture: Capture) -> str:
    """Return what would keep the buffer from its end. By how much it is too short is not said: after the end come
    further impacts, of vehicles that are far heavier than the probe, and no number of this run tells of them."""
    buffer = capture.design.buffer
    longer = (
        "buffer.free_length" if buffer.max_stroke is None or buffer.stop_stiffness is not None else "buffer.max_stroke"
    )
    return f"none: raise {longer}, buffer.k_A or buffer.c_A; only a run that does not bottom says what stroke it needs"


def _margin(capture: Capture) -> str:
    """Return the capture margin with what it is a distance of."""
    margin = float(capture.capture_margin)
    if capture.outcome == Outcome.bottomed:
        return _bottomed(capture)
    if capture.outcome in (Outcome.held, Outcome.latched):
        return f"{1e3 * float(capture.stroke_margin):.6g} mm of stroke left before the buffer's end"
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
