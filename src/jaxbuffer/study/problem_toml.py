"""The ``[problem]`` section of a study as a `Problem`."""

import dataclasses
from collections.abc import Iterable, Mapping
from pathlib import Path

from ..choosing.catalogue import TOTALS
from ..errors import InputError, meant
from ..fields import Part, as_typed, declared, ends_as_typed, get, unit
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.registry import mechanism_of
from ..tuning.problem.cases import Case, grid
from ..tuning.problem.problem import Limits, Objective, Problem
from ..tuning.problem.tolerances import Tolerance
from ..tuning.problem.variable import Variable
from ..value_text import interval_text, with_unit
from .model import LIMITS, VARIABLES, ProblemTable
from .own_quantities import own_quantities
from .tables import StudyNames


def read_problem(
    table: ProblemTable,
    design: Part,
    base: Part,
    listed: tuple[Part, ...],
    duration: float | None,
    rtol: float,
    folder: Path,
    units: Mapping[str, str],
    tolerances: Mapping[str, Tolerance],
) -> Problem:
    """Return the problem of a study.

    **Arguments:** ``listed``: the study's scenarios, which a grid or a sample here replaces; where both are here, every
    sample is taken at every point of the grid; ``folder``: the study's, beside which its Python files are; ``units``:
    and ``tolerances``: as of `Config`.
    """
    mechanism = mechanism_of(design)
    of_study, own = limits(table, mechanism), table.quantities or {}
    try:
        given = default_variables(mechanism, design) if table.variables is None else table.variables
        variables = tuple(given.values())
        _check_start(design, variables, table.variables is not None, units)
        return Problem(
            design,
            numbered_cases(table, base, listed, design),
            variables,
            objective=table.objective or Objective(),
            limits=of_study,
            then=table.then,
            duration=duration,
            rtol=rtol,
            # Last, since it runs files: whatever is wrong with the table itself is said before.
            quantities=own_quantities(own, mechanism, folder),
            scatter=table.sample,
            units=units,
            tolerances=tolerances,
        )
    except InputError as error:
        # A `Problem` names its own part first: here the place in the file is put in front.
        if not str(error).startswith(tuple(declared(ProblemTable))):
            raise
        symbols = StudyNames(design, base, {name: it.unit for name, it in own.items()}).units
        broken = (name for name in of_study.at_most if str(error).startswith(f"constraints.{name} = "))
        hints = (meant(of_study.at_most[name], symbols[name], low=0.0) for name in broken)
        raise error.between("problem.", next(hints, "")) from None


def check_table(table: ProblemTable, design: Part, base: Part, listed: tuple[Part, ...]) -> None:
    """Raise `InputError` for tables that do not go together, wherever the start may be."""
    for name in ("grid", "sample"):
        if listed and getattr(table, name) is not None:
            raise InputError(f"[[scenarios]] and [problem.{name}] both say which scenarios to tune for; keep one")
    scenarios = numbered_cases(table, base, (), design)
    if table.sample is None:
        return
    for name in table.sample.fields:
        if name in (table.grid or {}):
            raise InputError(f"problem.sample.scenario.{name} and problem.grid.{name} both give {name}; keep one")
    # Drawn only to be checked: samples may leave the fields' ranges.
    table.sample.cases(scenarios, design)


def limits(table: ProblemTable, mechanism: Mechanism) -> Limits:
    """Return the limits of a [problem], by default the mechanism's."""
    if table.constraints is not None:
        # Price and mass are sums over parts, which no run has: `choose` alone limits them.
        at_most = {name: it for name, it in table.constraints.at_most.items() if name not in TOTALS}
        return dataclasses.replace(table.constraints, at_most=at_most)
    names = StudyNames(mechanism.design(), mechanism.scenario())
    # Read like a study's own, since a mechanism gives its limits in the same form.
    read: Limits = LIMITS.read("problem.constraints", mechanism.defaults.limits, names)
    return read


def default_variables(mechanism: Mechanism, design: Part) -> Mapping[str, Variable]:
    """Return the variables of a study that names none, by path."""
    names, usual = StudyNames(design, mechanism.scenario()), mechanism.variables(design)
    read: Mapping[str, Variable] = VARIABLES.read("problem.variables", usual, names) if usual else {}
    return read


def _check_start(design: Part, variables: Iterable[Variable], own: bool, units: Mapping[str, str]) -> None:
    """Raise `InputError` for a start outside its bounds. ``own``: whether the study gives them."""
    for v in variables:
        value, symbol, typed = get(design, v.path), unit(design, v.path), units.get(v.path, "")
        if isinstance(value, float) and not v.low <= value <= v.high:
            bounds = f"bounds {interval_text(*ends_as_typed(v.low, v.high, symbol, typed))}"
            bounds_in_words = (
                f"its {bounds}; widen the bounds in [problem.variables] or change the start"
                if own
                else f"the default {bounds}; give bounds in [problem.variables] or change the start"
            )
            start = with_unit(*as_typed(value, symbol, typed))
            raise InputError(f"the start, {v.path} = {start}, is outside {bounds_in_words}")


def numbered_cases(table: ProblemTable, base: Part, listed: tuple[Part, ...], design: Part) -> tuple[Case, ...]:
    """Return the scenarios in the order of their numbers: the grid's, or the one that samples are taken about, or else
    the study's."""
    if table.grid is not None:
        return grid(table.grid, base, design)
    return tuple(Case(scenario) for scenario in ((base,) if table.sample is not None else listed))
