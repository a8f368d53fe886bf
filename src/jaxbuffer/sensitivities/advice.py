"""What to change first for a run that did not succeed, from the derivatives of the margin that it lacks."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .sensitivity import Sensitivity


def advice(result: "Sensitivity") -> list[str]:
    """A line for each parameter, the least relative change first: by how much it would have to change, to first order,
    for the mechanism's margin to be zero; nothing where the margin was not asked for, or the run succeeded.

    The change is -margin / (d margin / d ln parameter); the margin of a successful run is positive.
    """
    run, mechanism = result.run, result.run.mechanism
    name = mechanism.margin
    if name is None or name not in result.quantities or run.outcome.failed or run.outcome.name == mechanism.success:
        return []
    i = result.quantities.index(name)
    per_share = result.gradients[i] * result.values
    with np.errstate(divide="ignore", invalid="ignore"):
        change = -result.results[i] / per_share
    order = [k for k in np.argsort(np.abs(change)) if np.isfinite(change[k])]
    verdict = "not certified" if result.certificate is None else result.certificate.verdicts[i].name
    lines = [
        f"What to change first, so that {name} = {result.results[i]:.4g} becomes positive (first order; {verdict}):"
    ]
    for k in order:
        share = 100.0 * change[k]
        beyond = "" if share > -100.0 else ", which is below zero: this parameter alone will not do"
        lines.append(f"  {result.paths[k]:24} {share:+.3g} %, from {result.values[k]:.5g}{beyond}")
    return lines
