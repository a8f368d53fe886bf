"""Summaries and tables for people."""

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING, SupportsFloat

import numpy as np
from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from .mechanisms import Scenario, get, unit
from .outcome import Outcome

if TYPE_CHECKING:
    from .capture import Capture
    from .comparison import Comparison
    from .sensitivity import Sensitivity
    from .sweep import Sweep
    from .tune import Tuned, Variable

FLANKS = ("lower", "upper")
UNITS = {
    "peak_force": "N",
    "peak_time": "s",
    "peak_hinge_force": "N",
    "peak_buffer_force": "N",
    "stroke": "m",
    "hinge_angle": "rad",
    "end_time": "s",
    "contact_time": "s",
}
WIDTH = 118  # characters


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


def sweep_summary(result: "Sweep") -> str:
    """How many captures ended how, and the range of what they found."""
    codes, counts = np.unique(result.code, return_counts=True)
    ends = ", ".join(f"{count} {Outcome(int(code)).reason}" for code, count in zip(codes, counts, strict=True))
    table = _table(f"Sweep of {len(result)} captures: {ends}")
    for heading in ("quantity", "least", "median", "greatest"):
        table.add_column(heading, justify="left" if heading == "quantity" else "right")
    for name, its_unit in UNITS.items():
        values = getattr(result, name)
        known = values[np.isfinite(values)]
        figures = [f"{f(known):.5g}" for f in (np.min, np.median, np.max)] if known.size else ["-"] * 3
        table.add_row(f"{name} [{its_unit}]", *figures)
    return _text(table)


def scenario_label(scenario: Scenario, among: Sequence[Scenario] = ()) -> str:
    """What tells a scenario from the others, approach speed at least: "0.1 m/s, misalignment 0.02 rad"."""
    label = f"{float(scenario.approach_speed):g} m/s"
    for name in ("contact_distance", "misalignment", "passive_rate"):
        if len({float(getattr(other, name)) for other in among}) > 1:
            label += f", {name.replace('_', ' ')} {float(getattr(scenario, name)):g} {unit(scenario, name)}"
    return label


def sensitivity_table(result: "Sensitivity") -> str:
    """Elasticities of every quantity, and the peak force's gradient with its verified error."""
    units = [_parameter_unit(result.capture, path) for path in result.paths]
    elastic = _table("Elasticities: per cent change of a quantity for one per cent more of a parameter")
    elastic.add_column("parameter")
    elastic.add_column("value", justify="right")
    for name, value in zip(result.quantities, result.results, strict=True):
        elastic.add_column(f"{name}\n{value:.5g} {UNITS[name]}", justify="right")
    gradient = _table("Gradient of the peak contact force")
    for heading in ("parameter", "gradient", "error"):
        gradient.add_column(heading, justify="left" if heading == "parameter" else "right")
    peak = result.quantities.index("peak_force")
    for k, path in enumerate(result.paths):
        elastic.add_row(path, f"{result.values[k]:.5g} {units[k]}", *(f"{e:+.4f}" for e in result.elasticities[:, k]))
        error = "not verified" if result.error is None else f"{result.error[k]:.1e}"
        gradient.add_row(path, f"{result.gradients[peak, k]:+.5g} {per('N', units[k])}", error)
    note = "error: relative to central differences of tight solves, elasticities below 0.001 counting as 0.001"
    return _text(f"Sensitivity; {result.capture.outcome.reason}", elastic, gradient, note)


def tuned_table(tuned: "Tuned") -> str:
    """Before and after in every scenario, the variables within their bounds, and the gradient's verification."""
    problem = tuned.problem
    captures = _table(f"Scenarios (stroke limit {1e3 * problem.stroke_limit:g} mm)")
    captures.add_column("scenario")
    for heading in ("peak force [N]", "change", "hinge force [N]", "change", "stroke [mm]", "after"):
        captures.add_column(heading, justify="left" if heading == "after" else "right")
    for scenario, before, after in zip(problem.scenarios, tuned.before, tuned.after, strict=True):
        captures.add_row(
            scenario_label(scenario, problem.scenarios),
            *_change(before.peak_force, after.peak_force),
            *_change(before.peak_hinge_force, after.peak_hinge_force),
            f"{1e3 * float(before.stroke):.4g} → {1e3 * float(after.stroke):.4g}",
            after.outcome.name,
        )
    worst = [max(float(c.peak_force) for c in captures_) for captures_ in (tuned.before, tuned.after)]
    captures.add_section()
    captures.add_row("worst", *_change(*worst), "", "", "", "")
    variables = _table("Variables")
    variables.add_column("field")
    for heading in ("before", "tuned", "low", "high", "unit"):
        variables.add_column(heading, justify="left" if heading == "unit" else "right")
    variables.add_column("")
    for variable in problem.variables:
        start, value = (float(get(design, variable.path)) for design in (problem.design, tuned.design))
        numbers = [f"{x:.5g}" for x in (start, value, variable.low, variable.high)]
        variables.add_row(variable.path, *numbers, unit(problem.design, variable.path), _at_bound(variable, value))
    return _text(
        f"Tuned in {len(tuned.iterations)} iterations, {tuned.message}",
        captures,
        variables,
        "Verification in the tuned design's worst scenario",
        sensitivity_table(tuned.verification),
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


def _change(before: SupportsFloat, after: SupportsFloat) -> tuple[str, str]:
    before, after = float(before), float(after)
    return f"{before:.5g} → {after:.5g}", f"{100.0 * (after / before - 1.0):+.1f} %"


def _at_bound(variable: "Variable", value: float) -> str:
    near = 1e-6 * (variable.high - variable.low)
    return "at low bound" if value <= variable.low + near else "at high bound" if value >= variable.high - near else ""


def _parameter_unit(capture: "Capture", path: str) -> str:
    of_scenario = path.startswith("scenario.")
    return unit(capture.scenario, path.removeprefix("scenario.")) if of_scenario else unit(capture.design, path)


def _table(title: str) -> Table:
    return Table(title=title, title_justify="left", title_style="", box=SIMPLE, pad_edge=False)


def _text(*parts: str | Table) -> str:
    """Plain text, the same on a terminal, in a file and in a notebook."""
    console = Console(file=io.StringIO(), width=WIDTH, color_system=None, force_terminal=False, legacy_windows=False)
    with console.capture() as captured:
        for part in parts:
            console.print(part, markup=False, highlight=False)
    return "\n".join(line.rstrip() for line in captured.get().splitlines())
