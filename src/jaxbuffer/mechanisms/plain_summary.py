"""The summary of a run whose mechanism has none of its own."""

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
    for name in mechanism.meant(lambda path: get(run.design, path)):
        quantity = mechanism.quantities[name]
        lines.append(f"  {quantity.title or name:24} {quantity.in_words(float(np.asarray(quantity.of(run))))}")
    lines += [f"  {heading:24} {text}" for element in run.elements for heading, text in element.summary(run)]
    # NumPy's numbers, so that sums compile nothing.
    energy, balance = jax.tree.map(np.asarray, (run.energy, run.balance))
    lost = ", ".join(f"{name.replace('_', ' ')} {float(value):.3g}" for name, value in energy.lost.items())
    lines += [
        f"  {'energy':24} {float(energy.total):.6g} J, of which dissipated {float(energy.dissipated):.6g} J ({lost})",
        f"  {'numerical balance':24} energy {float(balance.energy):.1e}, constraint drift {float(balance.drift):.1e} m",
        f"  {'steps':24} {int(run.accepted)} accepted of {int(run.attempts)}",
    ]
    return "\n".join([*lines, *(f"  {line}" for line in mechanism.view.warnings(run))])
