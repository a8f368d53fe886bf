"""Summaries and tables for people."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import jax
import numpy as np
from rich.table import Table

from .mechanisms import scenario_label as scenario_label
from .mechanisms import unit
from .outcome import Outcome
from .quantities import is_signed, quantity_unit
from .tables import table as _table
from .tables import text as _text
from .validity import warnings

if TYPE_CHECKING:
    from .capture import Capture
    from .certificate import Certificate
    from .comparison import Comparison
    from .sensitivity import Sensitivity
    from .sweep import Sweep

FLANKS = ("lower", "upper")
UNITS = {
    "peak_force": "N",
    "peak_time": "s",
    "peak_hinge_force": "N",
    "peak_buffer_force": "N",
    "peak_stop_force": "N",
    "stroke": "m",
    "stroke_margin": "m",
    "hinge_angle": "rad",
    "penetration": "m",
    "end_time": "s",
    "contact_time": "s",
    "throat_distance": "m",
    "capture_margin": "m",
}


def summary(capture: "Capture") -> str:
    """A capture in a dozen lines, units included."""
    outcome = capture.outcome
    if outcome.failed:
        where = scenario_label(capture.scenario)
        return f"Capture: {outcome.reason} (after {int(capture.attempts)} steps; {where})"
    flank = FLANKS[int(capture.peak_flank)]
    first = capture.first_impact
    e, b = jax.tree.map(np.asarray, (capture.energy, capture.balance))  # so that sums compile nothing
    lines = [
        f"Capture: {outcome.reason}",
        f"  scenario             {scenario_label(capture.scenario)}",
        f"  end time             {float(capture.end_time):.6g} s, in contact {float(capture.contact_time):.4g} s",
        f"  peak contact force   {float(capture.peak_force):.6g} N at {float(capture.peak_time):.6g} s,"
        f" {flank} flank, {_which_impact(capture)}",
        f"  first impact         {float(np.asarray(capture.impacts.peak_force)[0]):.6g} N; closed form"
        f" {_predicted(capture)} ({float(first.elastic_peak):.4g} N without loss):"
        f" effective mass {float(first.effective_mass):.4g} kg, energy {float(first.effective_energy):.4g} J",
        f"  peak hinge force     {float(capture.peak_hinge_force):.6g} N",
        f"  peak buffer force    {float(capture.peak_buffer_force):.6g} N{_stop(capture)}",
        f"  stroke               {1e3 * float(capture.stroke):.6g} mm{_stroke_limits(capture)}",
        f"  hinge angle          {np.degrees(float(capture.hinge_angle)):.6g} deg",
        f"  penetration          at most {1e6 * float(capture.penetration):.3g} µm into a flank",
        f"  capture margin       {_margin(capture)}",
        f"  energy               {float(e.total):.6g} J, of which dissipated {float(e.dissipated):.6g} J"
        f" (axial damper {float(e.axial_damper):.3g}, torsional {float(e.torsional_damper):.3g},"
        f" contact {float(e.hysteresis):.3g}, friction {float(e.friction):.3g}"
        + (")" if capture.design.buffer.stop_stiffness is None else f", end stop {float(e.stop_damper):.3g})"),
        f"  numerical balance    energy {float(b.energy):.1e}, momentum {float(b.linear_momentum):.1e} linear,"
        f" {float(b.angular_momentum):.1e} angular, constraint drift {float(b.drift):.1e} m",
        f"  steps                {int(capture.accepted)} accepted of {int(capture.attempts)}",
    ]
    return "\n".join([*lines, *(f"  {line}" for line in warnings(capture))])


def _which_impact(capture: "Capture") -> str:
    count, listed = int(capture.impact_count), int(capture.impacts.count)
    which = int(capture.peak_impact) + 1
    if count == listed:
        return f"impact {which} of {count}"
    return f"impact {which or f'after the {listed}th'} of {count}, the first {listed} of which are listed"


def _stop(capture: "Capture") -> str:
    if capture.design.buffer.stop_stiffness is None:
        return ""
    return f", end stop {float(capture.peak_stop_force):.6g} N"


def _stroke_limits(capture: "Capture") -> str:
    buffer = capture.design.buffer
    whole = f" of {1e3 * float(buffer.longest_stroke):.6g} mm"
    return whole if buffer.stop_stiffness is None else f"{whole}, end stop from {1e3 * float(buffer.end):.6g} mm on"


def _margin(capture: "Capture") -> str:
    """The capture margin with what it is a distance of."""
    margin = float(capture.capture_margin)
    if capture.outcome == Outcome.bottomed:
        return f"{1e3 * margin:.4g} mm: about so much stroke is missing"
    if margin == float(capture.stroke_margin):
        return f"{1e3 * margin:.6g} mm of stroke left before the buffer's end"
    return (
        f"{1e3 * margin:.6g} mm beyond the capture plane at the duration,"
        f" coasting on from {1e3 * float(capture.throat_distance):.4g} mm before it at the end time"
    )


def sweep_summary(result: "Sweep") -> str:
    """How many captures ended how, and the range of what they found."""
    codes, counts = np.unique(result.code, return_counts=True)
    ends = ", ".join(f"{count} {Outcome(int(code)).reason}" for code, count in zip(codes, counts, strict=True))
    table = _table(f"Sweep of {len(result)} captures: {ends}")
    for heading in ("quantity", "least", "median", "greatest"):
        table.add_column(heading, justify="left" if heading == "quantity" else "right")
    for name, its_unit in UNITS.items():
        if not hasattr(result, name):
            continue
        values = getattr(result, name)
        known = values[np.isfinite(values)]
        figures = [f"{f(known):.5g}" for f in (np.min, np.median, np.max)] if known.size else ["-"] * 3
        table.add_row(f"{name} [{its_unit}]", *figures)
    return _text(table)


def sensitivity_table(result: "Sensitivity") -> str:
    """Elasticities of every quantity (derivatives of those that can change sign), gradients and the certificate."""
    units = [_parameter_unit(result.capture, path) for path in result.paths]
    signed = [is_signed(name) for name in result.quantities]

    def slope(i: int, k: int) -> str:
        return f"{result.gradients[i, k]:+.5g} {per(quantity_unit(result.quantities[i]), units[k])}"

    elastic = _table("Elasticities: per cent change of a quantity for one per cent more of a parameter")
    _by_parameter(
        elastic, result, np.flatnonzero(np.logical_not(signed)), lambda i, k: f"{result.elasticities[i, k]:+.4f}"
    )
    derivatives = _table("Derivatives of quantities that can change sign")
    _by_parameter(derivatives, result, np.flatnonzero(signed), slope)
    main, certificate = result.quantities[0], result.certificate
    gradient = _table(f"Gradient of {main}")
    for heading in ("parameter", "value", "gradient", "estimated error"):
        gradient.add_column(heading, justify="left" if heading == "parameter" else "right")
    for k, path in enumerate(result.paths):
        error = "not verified" if certificate is None else f"{certificate.error[0, k]:.1e}"
        gradient.add_row(path, f"{result.values[k]:.5g} {units[k]}", slope(0, k), error)
    where = scenario_label(result.capture.scenario)
    tables = ([] if all(signed) else [elastic]) + ([derivatives] if any(signed) else [])
    parts: list[str | Table] = [f"Sensitivity at {where}; {result.capture.outcome.reason}", *tables, gradient]
    if certificate is not None:
        parts.append(certificate_text(certificate, result.quantities))
    if not result.capture.outcome.failed:
        parts.append(_first_impact(result.capture))
    return _text(*parts)


def _by_parameter(table: Table, result: "Sensitivity", which: np.ndarray, cell: Callable[[int, int], str]) -> None:
    """A column for each quantity in ``which``, a row for each parameter."""
    table.add_column("parameter")
    for i in which:
        name = result.quantities[i]
        table.add_column(f"{name}\n{result.results[i]:.5g} {quantity_unit(name)}", justify="right")
    for k, path in enumerate(result.paths):
        table.add_row(path, *(cell(i, k) for i in which))


def certificate_text(certificate: "Certificate", quantities: Sequence[str]) -> str:
    """Verdict, reason, active peak and runner-up, in a line each."""
    lines = [f"Certificate: {certificate.verdict.name.upper()}: {certificate.reason}"]
    less = [f"{n} {v.name}" for n, v in zip(quantities, certificate.verdicts, strict=True) if v]
    if less and len(less) < len(quantities):
        lines.append(f"  not all trusted      {', '.join(less)}; the others are")
    if (peaks := certificate.peaks) is not None:
        lines.append(
            f"  active peak          {peaks.force:.6g} N at {peaks.time:.6g} s, {FLANKS[peaks.flank]} flank,"
            f" impact {peaks.impact + 1}"
        )
        if peaks.runner_up_impact < 0:
            lines.append("  runner-up            none: no other impact")
        else:
            swap = f"; {100.0 * peaks.swap_change:+.3g} % of {peaks.swap_path} would make it the peak (first order)"
            lines.append(
                f"  runner-up            {peaks.runner_up_force:.6g} N, impact {peaks.runner_up_impact + 1},"
                f" {100.0 * peaks.margin:.3g} % below" + (swap if peaks.swap_path else "")
            )
    kind = "a difference for each parameter" if certificate.thorough else "one difference along all parameters together"
    if certificate.solves:
        lines.append(f"  evidence             gradient at another tolerance; {kind}, {certificate.solves} tight solves")
    lines.append("  errors are relative to the elasticity, those below 0.001 counting as 0.001")
    return "\n".join(lines)


def _predicted(capture: "Capture") -> str:
    peak = float(capture.first_impact.predicted_peak)
    return f"{peak:.4g} N" if np.isfinite(peak) else f"unknown for the law {capture.design.contact.law}"


def _first_impact(capture: "Capture") -> str:
    """The simulated first peak beside its closed form."""
    first, seen = capture.first_impact, float(np.asarray(capture.impacts.peak_force)[0])
    return (
        f"First impact: {seen:.6g} N; closed form {_predicted(capture)}, "
        f"{float(first.elastic_peak):.6g} N without loss (T_c {float(first.effective_energy):.5g} J)"
    )


def laws_table(comparison: "Comparison") -> str:
    """Each law's source, delivered restitutions and impact."""
    from .comparison import ASKED

    asked = comparison.restitution
    restitution = _table("Restitution delivered to two free bodies, for the one asked for")
    impact = _table(
        f"Impact of {comparison.mass:.5g} kg at {comparison.speed:.5g} m/s, restitution {asked:g} asked for"
    )
    for table, right, last in (
        (restitution, [f"{e:g}" for e in ASKED], "source"),
        (impact, ["restitution", "penetration [µm]", "peak force [N]", "duration [ms]"], "validity"),
    ):
        table.add_column("law")
        for heading in right:
            table.add_column(heading, justify="right")
        table.add_column(last)
    for entry in comparison.laws:
        restitution.add_row(entry.name, *(f"{e:.4f}" for e in entry.delivered), entry.law.source)
        found = entry.impact
        figures = (found.restitution, 1e6 * found.max_penetration, found.peak_force, 1e3 * found.duration)
        impact.add_row(entry.name, *(f"{x:.5g}" for x in figures), entry.law.validity)
    return _text(restitution, impact)


def per(above: str, below: str) -> str:
    """The unit of a quotient: N/kg, N/(N/m)."""
    return f"{above}/({below})" if {" ", "/"} & set(below) else f"{above}/{below}"


def _parameter_unit(capture: "Capture", path: str) -> str:
    of_scenario = path.startswith("scenario.")
    return unit(capture.scenario, path.removeprefix("scenario.")) if of_scenario else unit(capture.design, path)
