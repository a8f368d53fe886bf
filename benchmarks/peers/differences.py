"""The gradient a peer's user gets: central differences of the peak force in the logarithm of each design number.

A short step divides the solver's error by little, a long one leaves the impact the peak belongs to. `search` finds what
a user with patience would end up with, knowing the exact answer even: for each number the step, and for all the
tolerance, that are within the target most cheaply.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial

from ..accuracy import Setting, measured
from .parameters import Parameters
from .solvers import ABSOLUTE, solve, tolerances

INPUTS = ("k_A", "c_A", "k_T", "c_T", "tip_mass")
STEPS = (3e-2, 1e-2, 3e-3, 1e-3, 3e-4)  # [-] half the distance in ln p
RTOLS = tuple(10.0 ** (-10.5 + k / 2) for k in range(11))  # tight to loose


@dataclass(frozen=True)
class Differences:
    """Elasticities d ln peak_force / d ln p [-] by name, and the value they belong to."""

    peak_force: float  # [N]
    elasticities: Mapping[str, float]

    def errors(self, exact: Mapping[str, float]) -> dict[str, float]:
        """Relative error [-] of each elasticity."""
        return {name: abs(self.elasticities[name] / exact[name] - 1.0) for name in self.elasticities}


def value_and_elasticities(
    peer: str, parameters: Parameters, rtol: float, parts: tuple[float, float], steps: Mapping[str, float]
) -> Differences:
    """One capture for the value and two for each of the inputs that ``steps`` in ln p names."""

    def peak(**values: float) -> float:
        return solve(peer, replace(parameters, **values), rtol, tolerances(rtol, parts)).peak_force

    elasticities = {}
    for name, step in steps.items():
        value = getattr(parameters, name)
        up, down = (peak(**{name: value * math.exp(shift)}) for shift in (step, -step))
        elasticities[name] = math.log(up / down) / (2.0 * step) if min(up, down) > 0.0 else math.inf
    return Differences(peak(), elasticities)


def search(
    peer: str,
    parameters: Parameters,
    exact: Mapping[str, float],
    target: float,
    parts: tuple[float, float] = ABSOLUTE[0],
    steps: tuple[float, ...] = STEPS,
) -> Iterator[Setting]:
    """Settings, tight to loose, of which each input has a step within ``target`` [-] here and at all tighter ones."""
    alive = {name: steps for name in INPUTS}
    for rtol in RTOLS:
        off: dict[str, dict[float, float]] = {name: {} for name in INPUTS}
        for step in steps:
            names = [name for name in INPUTS if step in alive[name]]
            tried = value_and_elasticities(peer, parameters, rtol, parts, dict.fromkeys(names, step))
            for name, error in tried.errors(exact).items():
                off[name][step] = error
        alive = {name: tuple(step for step in alive[name] if off[name][step] <= target) for name in INPUTS}
        if not all(alive.values()):
            return
        chosen = {name: min(alive[name], key=off[name].__getitem__) for name in INPUTS}
        run = partial(value_and_elasticities, peer, parameters, rtol, parts, chosen)
        label = f"rtol {rtol:.0e}, atol {parts[0]:g} and {parts[1]:g} of it, steps " + ", ".join(
            f"{chosen[name]:g}" for name in INPUTS
        )
        yield measured(f"{peer}, central differences", label, run, partial(Differences.errors, exact=exact))
