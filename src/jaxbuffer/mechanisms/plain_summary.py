"""The summary of a run whose mechanism has none of its own."""

from collections.abc import Mapping
from typing import Any

import jax
import numpy as np

from ..fields import get


def plain_summary(run: Any) -> str:
    """Return outcome, the quantities that sweeps have, what the elements say, energy and what numerical error did, in
    lines of text; units included."""
    mechanism, outcome, view = run.mechanism, run.outcome, run.mechanism.view
    if outcome.failed:
        return f"{view.title}: {outcome.reason} (after {int(run.attempts)} steps; {view.label(run.scenario)})"
    lines = [
        f"{view.title}: {outcome.reason}",
        f"  {'scenario':24} {view.label(run.scenario)}",
        f"  {'impacts':24} {int(run.impact_count)}",
    ]
    reports = [element.report for element in run.elements]
    of_elements = dict(line for report in reports for line in report.summary(run))
    observables = {name for report in reports if report.summary(run) for name in report.summary_observables}
    for name in mechanism.meant(lambda path: get(run.design, path)):
        quantity = mechanism.quantities[name]
        title = quantity.title or name
        # An element's own line of the same number says when it was reached besides.
        if name.removeprefix("peak_") not in observables and not of_elements.keys() & {title, name.replace("_", " ")}:
            lines.append(f"  {title:24} {quantity.in_words(float(np.asarray(quantity.of(run))))}")
    lines += [f"  {heading:24} {text}" for heading, text in of_elements.items()]
    # NumPy's numbers, so that sums compile nothing.
    energy, balance = jax.tree.map(np.asarray, (run.energy, run.balance))
    lines += [
        f"  {'energy lost':24} {float(energy.dissipated):.6g} J{_each(energy.lost)}",
        # Of weights and thrusts negative, for they have put energy in: so the total may be less than what is lost.
        f"  {'energy stored at the end':24} {float(energy.total - energy.dissipated):.6g} J{_each(energy.stored)}",
        f"  {'numerical balance':24} energy {float(balance.energy):.1e}, constraint drift {float(balance.drift):.1e} m",
        f"  {'steps':24} {int(run.accepted)} accepted of {int(run.attempts)}",
    ]
    return "\n".join([*lines, *(f"  {line}" for line in mechanism.view.warnings(run))])


def _each(energies: Mapping[str, Any]) -> str:
    """Return energies by name in brackets, those that are exactly zero left out; "" for none."""
    # Of a stop that is never reached, say; rounding may give it a sign.
    acting = {name: float(value) for name, value in energies.items() if float(value) != 0.0}
    texts = ", ".join(f"{name.replace('_', ' ')} {value:.3g}" for name, value in acting.items())
    return f" ({texts})" if texts else ""
