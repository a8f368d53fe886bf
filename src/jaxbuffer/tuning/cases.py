"""Many cases from few words: a grid over scenario fields, or a sample of an envelope with distributions."""

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from ..errors import InputError, check_choice, check_single, check_type, check_whole, shown
from ..fields import Part, check_path, get, unit
from ..mechanisms import mechanism_named
from ..mechanisms.registry import mechanism_of_scenario
from .problem import Case

KINDS = ("uniform", "normal")
MOST = 100_000  # cases
ONE_NUMBER = "a distribution has two numbers"


@dataclasses.dataclass(frozen=True)
class Distribution:
    """How a number scatters: "uniform" between ``first`` and ``second``, or "normal" with mean and deviation."""

    kind: str
    first: float
    second: float

    def __post_init__(self) -> None:
        check_choice("distribution", self.kind, KINDS)
        check_single(f"{self.kind}, first number", self.first, "-", ONE_NUMBER)
        low: dict[str, Any] = {"low": self.first} if self.kind == "uniform" else {"low": 0.0}
        check_single(f"{self.kind}, second number", self.second, "-", ONE_NUMBER, **low, low_open=True)

    def at(self, share: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
        """Quantiles."""
        from scipy.stats import norm

        if self.kind == "uniform":
            return self.first + share * (self.second - self.first)
        return np.asarray(norm.ppf(share, self.first, self.second))


def grid(fields: Mapping[str, Sequence[float]], base: Part | None = None) -> tuple[Case, ...]:
    """Every combination of the listed values of scenario fields; the others are ``base``'s (default: a capture's)."""
    base = mechanism_named("probe_cone").scenario() if base is None else base
    check_type("grid's fields", fields, Mapping, "grid({'approach_speed': [0.1, 0.2]})")
    for name, values in fields.items():
        check_path(base, name)
        if not isinstance(values, (Sequence, np.ndarray)) or isinstance(values, (str, bytes)):
            raise InputError(f"grid.{name} = {shown(values)} is not a list of values in {unit(base, name)}")
        if not len(values):
            raise InputError(f"grid.{name} is empty; list at least one value in {unit(base, name)}")
    if (count := math.prod(len(values) for values in fields.values())) > MOST:
        raise InputError(f"grid: {count:.4g} combinations of values are too many to tune for; at most {MOST}")
    return tuple(
        Case(dataclasses.replace(base, **dict(zip(fields, values, strict=True))))
        for values in itertools.product(*fields.values())
    )


def sample(
    count: int,
    fields: Mapping[str, Distribution],
    factors: Mapping[str, Distribution] | None = None,
    *,
    seed: int = 0,
    base: Part | None = None,
    design: Part | None = None,
) -> tuple[Case, ...]:
    """Cases drawn from distributions of scenario ``fields`` and of ``factors`` on design numbers (1 is as drawn).

    A Latin hypercube: each distribution is met evenly even by few cases; the same ``seed`` draws the same ones.
    ``design``: to check the paths of ``factors`` with.
    """
    from scipy.stats import qmc

    base, factors = mechanism_named("probe_cone").scenario() if base is None else base, factors or {}
    check_whole("sample.count", count, 1)
    if count > MOST:
        raise InputError(f"sample.count = {count} is out of range; allowed: [1, {MOST}]")
    check_whole("sample.seed", seed, 0)
    if not fields and not factors:
        raise InputError("sample: nothing scatters; give a field of the scenario or of the design a distribution")
    for name, given in (*fields.items(), *factors.items()):
        check_type(f"sample.{name}", given, Distribution, "Distribution('uniform', 0.9, 1.1)")
    for name in fields:
        check_path(base, name)
    for path in factors:
        value = get(mechanism_of_scenario(base).design() if design is None else design, path)
        if value is None or isinstance(value, (str, bool)):
            raise InputError(f"sample: {path} = {value!r} is not a number that can scatter")
    shares = qmc.LatinHypercube(len(fields) + len(factors), rng=seed).random(count).T
    spread = [d.at(s) for d, s in zip((*fields.values(), *factors.values()), shares, strict=True)]
    split = len(fields)
    return tuple(
        Case(
            dataclasses.replace(base, **{name: float(x[k]) for name, x in zip(fields, spread[:split], strict=True)}),
            tuple((path, float(x[k])) for path, x in zip(factors, spread[split:], strict=True)),
        )
        for k in range(count)
    )
