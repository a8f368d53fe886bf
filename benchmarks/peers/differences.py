"""The gradient a peer's user gets: central differences of the peak force in the logarithm of each design number."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from .parameters import Parameters
from .solvers import solve

INPUTS = ("k_A", "c_A", "k_T", "c_T", "tip_mass")


@dataclass(frozen=True)
class Differences:
    """Elasticities d ln peak_force / d ln p [-] by name, and what they cost."""

    elasticities: Mapping[str, float]
    seconds: float  # [s] all captures together
    captures: int
    same_peak: bool  # outcome, impacts and the peak's flank are those of every capture: else they mean nothing


def elasticities(
    peer: str,
    parameters: Parameters,
    rtol: float,
    atol: float,
    step: float = 1e-3,
    inputs: Sequence[str] = INPUTS,
) -> Differences:
    """Central differences over a ``step`` in ln p, two captures for each of the ``inputs``.

    A short step divides the solver's error by little, a long one leaves the impact the peak belongs to: the caller
    weighs one against the other together with the tolerances.
    """
    found = {}
    kinds = set()
    begin = time.perf_counter()
    for name in inputs:
        value = getattr(parameters, name)
        if value <= 0.0:
            raise ValueError(f"{name} = {value}: an elasticity needs a positive number")
        up, down = (
            solve(peer, replace(parameters, **{name: value * math.exp(shift)}), rtol, atol) for shift in (step, -step)
        )
        found[name] = (math.log(up.peak_force) - math.log(down.peak_force)) / (2.0 * step)
        kinds |= {(run.outcome, run.impacts, run.peak_flank) for run in (up, down)}
    seconds = time.perf_counter() - begin
    return Differences(found, seconds, 2 * len(found), len(kinds) == 1)
