"""What combinations are judged by: the problem's objective and limits, and sums of price and mass."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from ..errors import InputError, check_known, check_single
from ..fields import as_typed, in_unit
from ..mechanisms.limit import Limit
from ..mechanisms.quantity import Catalogue, Quantity
from ..tuning.objective import ONE_LIMIT, Objective, quantity_in_words
from ..tuning.problem import Problem
from .catalogue import MASS, PRICE, TOTALS, stands_for
from .combinations import Combinations

DESCRIPTIONS = {PRICE: "sum of the parts' prices", MASS: "sum of the parts' masses"}


@dataclasses.dataclass(frozen=True)
class Criterion:
    """The objective and limits of a choice.

    - ``problem``: its load cases, and the limits on quantities of runs.
    - ``objective``: of those quantities and of price and mass.
    - ``limits``: on price and mass.
    - ``catalogue``: quantities of the problem, price and mass.
    """

    problem: Problem
    objective: Objective
    limits: tuple[Limit, ...]
    catalogue: Catalogue

    @staticmethod
    def of(
        problem: Problem, objective: Objective | None, at_most: Mapping[str, Any] | None, combinations: Combinations
    ) -> "Criterion":
        """Return the criterion of a choice. ``at_most``: upper limits on price and mass.

        **Raises:** `InputError` for quantities that are unknown, and for price or mass of parts that have none.
        """
        units = total_units(combinations)
        given = problem.objective if objective is None else objective.of(problem.main_quantity)
        catalogue = {
            **problem.catalogue,
            **{name: _quantity(name, units[name], combinations.units.get(name, "")) for name in units},
        }
        for where, names in (("objective", given.weights), ("at_most", at_most or {})):
            for name in names:
                if name in TOTALS and name not in units:
                    raise InputError(f"{where}.{name}: no part has a {name}; give each part one, {name} = 12 say")
        check_known(given.weights, (*problem.names, *units), "objective", quantity_in_words)
        check_known(at_most or {}, units, "at_most", lambda name: DESCRIPTIONS[name])
        limits = []
        for name, given_bound in (at_most or {}).items():
            # The unit of a price may be any word, which nothing converts.
            bound = in_unit(f"at_most.{name}", given_bound, units[name]) if name == MASS else given_bound
            check_single(f"at_most.{name}", bound, units[name] or "-", ONE_LIMIT, low=0.0, low_open=True)
            limits.append(Limit(name, float(bound)))
        return Criterion(problem, given, tuple(limits), catalogue)

    @property
    def of_runs(self) -> Objective | None:
        """Return the objective's share that runs decide; None where price and mass alone do."""
        weights = {name: it for name, it in self.objective.weights.items() if name not in TOTALS}
        return dataclasses.replace(self.objective, weights=weights) if weights else None

    def constant(self, totals: Mapping[str, Any]) -> Any:
        """Return what price and mass add to the objective. ``totals``: their sums, numbers or arrays."""
        return sum(self.objective.weights[name] * totals[name] for name in TOTALS if name in self.objective.weights)

    def constants(self, combinations: Combinations) -> Float[np.ndarray, " combinations"]:
        """Return that of every combination."""
        sums = {name: combinations.totals(name) for name in combinations.summed}
        return np.zeros(len(combinations)) + self.constant(sums)

    def allowed(self, combinations: Combinations) -> Bool[np.ndarray, " combinations"]:
        """Return which combinations keep the limits on price and mass."""
        keeps = [limit.keeps(combinations.totals(limit.name)) for limit in self.limits]
        # The row of ones is for a choice without such limits: of nothing `np.all` would make a single truth.
        return np.all([np.ones(len(combinations), bool), *keeps], axis=0)

    def shown(self, value: float) -> tuple[float, str]:
        """Return a value of the objective in the unit that people are shown, and that unit."""
        return self.objective.shown(value, self.catalogue)

    def __str__(self) -> str:
        if self.of_runs is None:
            return " + ".join(f"{w:g} {name}" if w != 1.0 else name for name, w in self.objective.weights.items())
        return self.problem.format(self.objective)


def check_obeyed(problem: Problem, where: Mapping[str, str]) -> None:
    """Raise `InputError` for a part of a problem that a choice cannot obey.

    **Arguments:** ``where``: what sets each path of the design, as messages name it.
    """
    listed = {stands_for(problem.design, path): path for case in problem.cases for path, _ in case.values}
    for path, setter in where.items():
        if (other := listed.get(stands_for(problem.design, path))) is not None:
            raise InputError(f"{setter} sets {path}, and the scenarios list values of {other}; keep one")
    if problem.then is not None:
        raise InputError(
            f"problem.then = {problem.then.objective}: a choice among parts or roundings has one objective; leave out"
            " problem.then, or limit the first objective in problem.constraints and choose by the second"
        )


def total_units(combinations: Combinations) -> dict[str, str]:
    """Return the units of price and mass, of those that the parts have."""
    price = next((it.price_unit for it in combinations.catalogues if PRICE in it.totals), "")
    return {name: {PRICE: price, MASS: "kg"}[name] for name in combinations.summed}


def _quantity(name: str, unit: str, typed: str) -> Quantity:
    factor, symbol = as_typed(1.0, unit, typed)
    # Of runs it has no number: a choice adds the parts' own.
    return Quantity(unit, lambda run: jnp.asarray(jnp.nan), DESCRIPTIONS[name], name, shown=(symbol, factor))
