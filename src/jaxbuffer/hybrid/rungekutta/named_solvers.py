"""Solvers by name, as studies and the command line write them."""

from collections.abc import Mapping
from typing import Any

import diffrax

from ...errors import check_choice
from .diffrax_solver import DIFFRAX_METHODS, Diffrax
from .solvers import Automatic, DiagonallyImplicit, ExplicitRungeKutta, Solver

SOLVERS: Mapping[str, type[Solver]] = {
    "automatic": Automatic,
    "implicit": DiagonallyImplicit,
    "explicit": ExplicitRungeKutta,
}

SOLVER_NAMES = (*SOLVERS, *(f"diffrax:{method}" for method in DIFFRAX_METHODS))


def solver_named(solver: Any) -> Solver:
    """The solver of a name in `SOLVER_NAMES`; a solver itself stays as it is. **Raises:** `InputError` for all else."""
    if isinstance(solver, Solver):
        return solver
    check_choice("solver", solver, SOLVER_NAMES)
    if solver in SOLVERS:
        return SOLVERS[solver]()
    return Diffrax(getattr(diffrax, solver.removeprefix("diffrax:"))())
