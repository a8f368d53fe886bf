"""Solvers by name, as studies and the command line write them."""

from collections.abc import Mapping
from typing import Any

import jax

from ...errors import InputError, check_choice
from .diffrax_solver import DIFFRAX_METHODS, Diffrax
from .solvers import AUTOMATIC, Automatic, DiagonallyImplicit, ExplicitRungeKutta, Solver

SOLVERS: Mapping[str, type[Solver]] = {
    "automatic": Automatic,
    "implicit": DiagonallyImplicit,
    "explicit": ExplicitRungeKutta,
}

SOLVER_NAMES = (*SOLVERS, *(f"diffrax:{method}" for method in DIFFRAX_METHODS))


def solver_named(solver: Any) -> Solver:
    """Return the solver of a name in `SOLVER_NAMES`, the automatic one for None; a solver itself stays as it is.
    **Raises:** `InputError` for all else."""
    if isinstance(solver, Solver):
        return solver
    if solver is None:
        return AUTOMATIC
    check_choice("solver", solver, SOLVER_NAMES)
    if solver in SOLVERS:
        return SOLVERS[solver]()
    import diffrax

    return Diffrax(getattr(diffrax, solver.removeprefix("diffrax:"))())


def name_of(solver: Solver) -> str:
    """Return the name by which another process makes a solver for itself: one of diffrax's, pickled, is another one.

    **Raises:** `InputError` for a solver that no name makes.
    """
    kinds = [name for name, kind in SOLVERS.items() if type(solver) is kind]
    names = kinds or [name for name in SOLVER_NAMES if name not in SOLVERS]
    for name in names:
        other = solver_named(name)
        alike: bool = jax.tree.structure(solver) == jax.tree.structure(other)  # type: ignore[operator]
        if alike and jax.tree.leaves(solver) == jax.tree.leaves(other):
            return name
    raise InputError(f"solver {solver!r} cannot be sent to another process; name one of {', '.join(SOLVER_NAMES)}")
