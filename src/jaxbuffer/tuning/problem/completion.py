"""A problem's data as they are given, checked and completed: what was left out, numbers read from their units."""

import dataclasses
from collections.abc import Iterable, Mapping

from ...errors import InputError, check_known, check_single, check_type, shown
from ...fields import check_path, get, typed_unit
from ...run.request import TOLERANCES
from .cases import Scatter
from .custom_quantity import check_custom_quantities
from .objective import ONE_LIMIT, Limits, Objective, SecondObjective, in_units, quantity_in_words
from .problem_data import ProblemData
from .tolerances import check_ends, read_tolerances
from .variable import Variable, check_variables


def completed(given: ProblemData) -> ProblemData:
    """Return a problem's data checked and completed.

    **Raises:** `InputError` for what cannot be read, for names that are unknown or another mechanism's, and for numbers
    that contradict one another.
    """
    own = check_custom_quantities(given.quantities, given.mechanism.quantities)
    given = dataclasses.replace(given, quantities=own)
    _check_types(given)
    given = _with_objectives(dataclasses.replace(given, scenarios=tuple(given.scenarios)))
    _check_quantities(given)
    if given.scatter is not None and given.scenarios:
        check_type("scatter", given.scatter, Scatter, "Scatter(24, {'approach_speed': Distribution(...)})")
    if not given.drawn:
        raise InputError("scenarios is empty; tuning needs at least one")
    given = _with_units(given)
    check_variables(given.design, given.variables, given.units)
    # A load case sets no number that is tuned.
    for path in dict.fromkeys(path for case in given.drawn for path, _ in case.values):
        check_path(given.design, path)
        if path in given.paths:
            raise InputError(
                f"{path} is tuned, and the scenarios list values of it; keep one, or give it a tolerance instead"
            )
    return _with_tolerances(given)


def _check_types(given: ProblemData) -> None:
    for name, values, example in (
        ("scenarios", given.scenarios, "[Scenario(approach_speed=0.2)]"),
        ("variables", given.variables, "[Variable('buffer.k_A', 100.0, 2000.0)]"),
    ):
        if not isinstance(values, Iterable) or isinstance(values, (str, bytes, Mapping)):
            raise InputError(f"{name} = {shown(values)} is not a list; write {example}")
    check_type("objective", given.objective, Objective, "Objective({'peak_force': 1.0})")
    check_type("limits", given.limits, Limits, "Limits(at_most={'stroke': 0.025})")
    if given.then is not None:
        check_type("then", given.then, SecondObjective, "SecondObjective(Objective({'stroke': 1.0}))")
    check_single("duration", given.duration, "s", ONE_LIMIT, low=0.0, low_open=True)
    check_single("rtol", given.rtol, "-", ONE_LIMIT, **TOLERANCES)


def _with_objectives(given: ProblemData) -> ProblemData:
    """Let an objective without weights be the main quantity alone."""
    if not given.names:
        raise InputError(
            f"{given.mechanism.name} has no quantity that an objective may use: declare one with tuned=True, or give"
            " quantities of your own"
        )
    main, then = given.main_quantity, given.then
    if then is not None:
        then = dataclasses.replace(then, objective=then.objective.of(main))
    return dataclasses.replace(given, objective=given.objective.of(main), then=then)


def _check_quantities(given: ProblemData) -> None:
    """Raise `InputError` where a quantity is another mechanism's, or a limit above what always holds."""
    mechanism, design = given.mechanism, given.design
    given.limits.check(mechanism, lambda path: get(design, path), given.quantities)
    uses: dict[str, Iterable[str]] = {"objective": given.objective.weights, "constraints": given.limits.names}
    uses |= {} if given.then is None else {"then": given.then.objective.weights}
    for where, names in uses.items():
        for name in names:
            if name in mechanism.tuned and not mechanism.has(name, design):
                part = mechanism.quantities[name].part
                raise InputError(f"{where}.{name} needs {part}, which the design has not; give it, or leave it out")
        check_known(names, given.names, where, quantity_in_words)
    for name, high in mechanism.always(design).items():
        limit, unit = given.limits.at_most.get(name, high), given.catalogue[name].unit
        check_single(f"constraints.{name}", limit, unit, ONE_LIMIT, low=0.0, low_open=True, high=high)


def _with_units(given: ProblemData) -> ProblemData:
    """Read bounds and limits that were given with a unit; people are shown the numbers in those units."""
    variables, own = tuple(given.variables), {name: derived.unit for name, derived in given.quantities.items()}
    for variable in variables:
        check_type("variable", variable, Variable, "Variable('buffer.k_A', 100.0, 2000.0)")
        check_path(given.design, variable.path)
    # Units are read before the bounds become numbers, which no longer tell.
    typed = {it.path: symbol for it in variables if (symbol := typed_unit((it.low, it.high)))}
    at_most, at_least = in_units(given.limits.at_most, own), in_units(given.limits.at_least, own)
    return dataclasses.replace(
        given,
        variables=tuple(it.read(given.design) for it in variables),
        units={**typed, **given.units},
        limits=dataclasses.replace(given.limits, at_most=at_most, at_least=at_least),
    )


def _with_tolerances(given: ProblemData) -> ProblemData:
    tolerances = read_tolerances(given.tolerances, given.design, given.drawn[0].scenario)
    if tolerances:
        bounds = {variable.path: (variable.low, variable.high) for variable in given.variables}
        check_ends(tolerances, given.design, given.drawn, bounds)
        if any(len(row) != len(tolerances) for row in given.signs):
            raise InputError(f"signs: a corner has {len(tolerances)} numbers, one a tolerance")
    return dataclasses.replace(given, tolerances=tolerances)
