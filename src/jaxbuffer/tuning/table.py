"""A tuning's evaluations as rows of a table."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..fields import unit

if TYPE_CHECKING:
    from .tuned import Tuned


def tuning_history(tuned: "Tuned") -> tuple[list[str], list[Sequence[Any]]]:
    """A row for each evaluated design; worst values over the scenarios. ``unit``: that of the stage's objective."""
    problem = tuned.problem
    plain = ("evaluation", "stage", "search", "step", "accepted", "feasible", "captures", "status", "objective", "unit")
    numbers = {"excess": "-", "radius": "-", "residual": "-"}
    catalogue = problem.catalogue
    worst = {name: catalogue[name].unit for name in problem.names}
    header = [*plain, *(f"{name} [{symbol}]" for name, symbol in numbers.items())]
    header += [f"worst {name} [{symbol}]" for name, symbol in worst.items()]
    header += [f"{v.path} [{unit(problem.design, v.path)}]" for v in problem.variables]
    rows: list[Sequence[Any]] = []
    for it in tuned.records:
        row = [it[name] for name in plain] + [it[name] for name in numbers] + [max(it[name]) for name in worst]
        rows.append([*row, *(it["values"][v.path] for v in problem.variables)])
    return header, rows
