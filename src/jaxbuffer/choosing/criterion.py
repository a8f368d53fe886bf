"""What combinations are judged by: the problem's objectives and limits, and sums of price and mass."""

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
from ..tuning.problem.objective import ONE_LIMIT, Objective, SecondObjective, quantity_in_words
from ..tuning.problem.problem import Problem
from .catalogue import MASS, PRICE, TOTALS, stands_for
from .combinations import Combinations
from .order import Second

DESCRIPTIONS = {PRICE: "sum of the parts' prices", MASS: "sum of the parts' masses"}


@dataclasses.dataclass(frozen=True)
class Criterion:
    """The objectives and limits of a choice.

    - ``problem``: its load cases, the limits on quantities of runs, and the runs' share of both objectives.
    - ``objective``: of those quantities and of price and mass.
    - ``limits``: on price and mass.
    - ``catalogue``: quantities of the problem, price and mass.
    - ``then``: what orders combinations that are about as good as the best, or None.
    """

    problem: Problem
    objective: Objective
    limits: tuple[Limit, ...]
    catalogue: Catalogue
    then: SecondObjective | None = None

    @staticmethod
    def of(
        problem: Problem,
        objective: Objective | None,
        at_most: Mapping[str, Any] | None,
        combinations: Combinations,
        then: SecondObjective | None = None,
    ) -> "Criterion":
        """Return the criterion of a choice. ``objective``, ``then``: None for the problem's; ``at_most``: upper limits
        on price and mass.

        **Raises:** `InputError` for quantities that are unknown, and for price or mass of parts that have none.
        """
        units = total_units(combinations)
        main = problem.main_quantity
        given = problem.objective if objective is None else objective.of(main)
        second = problem.then if then is None else dataclasses.replace(then, objective=then.objective.of(main))
        named = {"objective": given.weights, "then": second.objective.weights if second else {}}
        catalogue = dict(problem.catalogue)
        for name, unit in units.items():
            factor, typed = as_typed(1.0, unit, combinations.units.get(name, ""))
            # Of runs it has no number: a choice adds the parts' own.
            none = lambda run: jnp.asarray(jnp.nan)  # noqa: E731
            catalogue[name] = Quantity(unit, none, DESCRIPTIONS[name], name, shown=(typed, factor))
        for where, names in (*named.items(), ("at_most", at_most or {})):
            for name in names:
                if name in TOTALS and name not in units:
                    raise InputError(f"{where}.{name}: no part has a {name}; give each part one, {name} = 12 say")
        for where, weights in named.items():
            check_known(weights, (*problem.names, *units), where, quantity_in_words)
        check_known(at_most or {}, units, "at_most", lambda name: DESCRIPTIONS[name])
        limits = []
        for name, given_bound in (at_most or {}).items():
            # The unit of a price may be any word, which nothing converts.
            bound = in_unit(f"at_most.{name}", given_bound, units[name]) if name == MASS else given_bound
            check_single(f"at_most.{name}", bound, units[name] or "-", ONE_LIMIT, low=0.0, low_open=True)
            limits.append(Limit(name, float(bound)))
        # Corners of tolerances are searched for by the problem's own objectives, so these are what is chosen by.
        problem = dataclasses.replace(
            problem,
            objective=objective_of_runs(given) or problem.objective,
            then=None if second is None else then_of_runs(second),
        )
        return Criterion(problem, given, tuple(limits), catalogue, second)

    @property
    def of_runs(self) -> Objective | None:
        """Return the objective's share that runs decide; None where price and mass alone do."""
        return objective_of_runs(self.objective)

    def constant(self, totals: Mapping[str, Any]) -> Any:
        """Return what price and mass add to the objective. ``totals``: their sums, numbers or arrays."""
        return constant(self.objective, totals)

    def constants(
        self, combinations: Combinations, objective: Objective | None = None
    ) -> Float[np.ndarray, " combinations"]:
        """Return what they add to an ``objective``, by default the first one, for every combination."""
        sums = {name: combinations.totals(name) for name in combinations.summed}
        return np.zeros(len(combinations)) + constant(objective or self.objective, sums)

    def second(self, combinations: Combinations) -> Second | None:
        """Return the second objective of every combination; None where there is none."""
        then = self.then
        if then is None:
            return None
        return Second(objective_of_runs(then.objective), self.constants(combinations, then.objective), then.ceiling)

    def allowed(self, combinations: Combinations) -> Bool[np.ndarray, " combinations"]:
        """Return which combinations keep the limits on price and mass."""
        keeps = [limit.keeps(combinations.totals(limit.name)) for limit in self.limits]
        # The row of ones is for a choice without such limits: of nothing `np.all` would make a single truth.
        return np.all([np.ones(len(combinations), bool), *keeps], axis=0)

    def shown(self, value: float) -> tuple[float, str]:
        """Return a value of the objective in the unit that people are shown, and that unit."""
        return self.objective.shown(value, self.catalogue)

    def in_words(self, objective: Objective) -> str:
        """Return an objective in words; of sums alone there is nothing to put together over scenarios."""
        if objective_of_runs(objective) is None:
            return " + ".join(f"{w:g} {name}" if w != 1.0 else name for name, w in objective.weights.items())
        return self.problem.format(objective)

    def __str__(self) -> str:
        return self.in_words(self.objective)


def objective_of_runs(objective: Objective) -> Objective | None:
    """Return an objective's share that runs decide; None where price and mass alone do."""
    weights = {name: it for name, it in objective.weights.items() if name not in TOTALS}
    return dataclasses.replace(objective, weights=weights) if weights else None


def then_of_runs(then: SecondObjective) -> SecondObjective | None:
    """Return a second objective's share that runs decide; None where price and mass alone do."""
    share = objective_of_runs(then.objective)
    return None if share is None else dataclasses.replace(then, objective=share)


def constant(objective: Objective, totals: Mapping[str, Any]) -> Any:
    """Return what price and mass add to an objective. ``totals``: their sums, numbers or arrays."""
    return sum(objective.weights[name] * totals[name] for name in TOTALS if name in objective.weights)


def check_obeyed(problem: Problem, where: Mapping[str, str]) -> None:
    """Raise `InputError` for a number of the design that both the choice and the scenarios set.

    **Arguments:** ``where``: what sets each path of the design, as messages name it.
    """
    listed = {stands_for(problem.design, path): path for case in problem.cases for path, _ in case.values}
    for path, setter in where.items():
        if (other := listed.get(stands_for(problem.design, path))) is not None:
            raise InputError(f"{setter} sets {path}, and the scenarios list values of {other}; keep one")


def total_units(combinations: Combinations) -> dict[str, str]:
    """Return the units of price and mass, of those that the parts have."""
    price = next((it.price_unit for it in combinations.catalogues if PRICE in it.totals), "")
    return {name: {PRICE: price, MASS: "kg"}[name] for name in combinations.summed}
