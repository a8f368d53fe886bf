"""What to change first for a run that did not succeed, from the derivatives of the margin that it lacks."""

from typing import TYPE_CHECKING

import numpy as np

from ..fields import unit_at

if TYPE_CHECKING:
    from .sensitivity import Sensitivity

FAR = 0.5  # relative change beyond which first order says little of its size


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
    reachable = np.isfinite(change) & (change > -1.0)
    verdict = "not certified" if result.certificate is None else result.certificate.verdicts[i].name
    now = f"{name} = {result.results[i]:.4g}"
    lines = [f"What to change first, so that {now} becomes positive (to first order, which is {verdict}):"]
    for k in (k for k in np.argsort(np.abs(change)) if reachable[k]):
        far = "; so far that only the direction counts" if abs(change[k]) > FAR else ""
        unit = unit_at(run.design, run.scenario, result.paths[k])
        lines.append(f"  {result.paths[k]:20} {100.0 * change[k]:+.3g} % of {result.values[k]:.5g} {unit}{far}")
    if left := [path for path, would_do in zip(result.paths, reachable, strict=True) if not would_do]:
        lines.append(f"  no value above zero of {', '.join(left)} would do, each alone")
    return lines
