"""The ``[problem]`` section of a study: from TOML tables to a `Problem`."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, as_number, check_choice, check_known, check_number, check_whole, meant, shown
from ..fields import (
    SCENARIO,
    Part,
    as_typed,
    by_path,
    check_alone,
    check_path,
    check_units_agree,
    ends_as_typed,
    get,
    in_unit,
    limits_of,
    meaning,
    metadata,
    no_number,
    paths,
    single_paths,
    typed_unit,
    unit,
)
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.registry import mechanism_of
from ..suggestions import Meaning, listed
from ..sweeps.axis import EXAMPLE, choices_example, span
from ..tuning.cases import KINDS, MOST, Case, Distribution, Scatter, grid
from ..tuning.objective import quantity_in_words
from ..tuning.problem import SCALES, Limits, Objective, Problem, SecondObjective, Variable
from ..value_text import interval_text, with_unit
from .own_quantities import named_quantities, own_quantities

SECTIONS = ("variables", "grid", "sample", "objective", "constraints", "then", "quantities")
SIDES = ("min", "max")  # of a two-sided limit
OPTIONS = ("over", "level")  # of an objective, beside its weights
SAMPLE = ("count", "seed", "scenario", "factors")


def read_problem(
    table: Mapping[str, Any],
    design: Part,
    base: Part,
    listed: tuple[Part, ...],
    duration: float | None,
    rtol: float,
    folder: Path,
    units: Mapping[str, str],
) -> Problem:
    """Read a problem from its TOML table.

    **Arguments:** ``listed``: the study's scenarios, which a grid or a sample here replaces; where both are here, every
    sample is taken at every point of the grid; ``folder``: the study's, beside which its Python files are; ``units``:
    as of `Config`.
    """
    mechanism = mechanism_of(design)
    try:
        parts = _parts(table, design, base, listed)
        _check_start(design, parts["variables"], "variables" in table, units)
        # Last, since it runs files: whatever is wrong with the table itself is said before.
        own = own_quantities(table, mechanism, folder)
        return Problem(design, **parts, duration=duration, rtol=rtol, quantities=own, units=units)
    except InputError as error:
        # A `Problem` names its own part first: here the place in the file is put in front.
        if not str(error).startswith(SECTIONS):
            raise
        at_most, symbols = limits(table, mechanism).at_most, _units(table, mechanism)
        broken = (name for name in at_most if str(error).startswith(f"constraints.{name} = "))
        hints = (meant(at_most[name], symbols[name], low=0.0) for name in broken)
        raise error.between("problem.", next(hints, "")) from None


def check_table(table: Mapping[str, Any], design: Part, base: Part) -> None:
    """Raise `InputError` for whatever is wrong with the table in itself, wherever the start may be."""
    parts = _parts(table, design, base, ())
    # Drawn only to be checked: samples may leave the fields' ranges.
    if (scatter := parts["scatter"]) is not None:
        scatter.cases(parts["scenarios"], design)


def _parts(table: Mapping[str, Any], design: Part, base: Part, listed: tuple[Part, ...]) -> dict[str, Any]:
    """Read what the table says of a `Problem`, but for the own quantities, whose functions are in files."""
    check_known(table, SECTIONS, "problem")
    mechanism = mechanism_of(design)
    symbols = _units(table, mechanism)
    return {
        "variables": _variables_of(table, mechanism, design),
        "scatter": _scatter(table, design, base),
        "scenarios": _scenarios(table, base, listed),
        "objective": _objective(_table(table, "objective", {}), "objective", symbols),
        "limits": limits(table, mechanism),
        "then": _then(_table(table, "then", {}), symbols) if "then" in table else None,
    }


def _units(table: Mapping[str, Any], mechanism: Mechanism) -> dict[str, str]:
    """Return the units of all quantities that objectives and limits may use, the study's own ones among them."""
    own = {name: own.unit for name, own in named_quantities(table, mechanism).items()}
    return {name: mechanism.quantities[name].unit for name in mechanism.tuned} | own


def _variables_of(table: Mapping[str, Any], mechanism: Mechanism, design: Part) -> tuple[Variable, ...]:
    """Read the variables of a [problem], by default the mechanism's."""
    bounds = _table(table, "variables", mechanism.variables(design))
    if not bounds:
        raise InputError("problem.variables is empty; name a field and its bounds, such as buffer.k_A = [100, 2000]")
    by_name = by_path(bounds, where="problem.variables", fields=single_paths(design))
    return tuple(_variable(path, given, design) for path, given in by_name.items())


def _check_start(design: Part, variables: Sequence[Variable], own: bool, units: Mapping[str, str]) -> None:
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


def _variable(path: str, given: Any, design: Part) -> Variable:
    if path.startswith(SCENARIO):
        raise InputError(f"problem.variables: {path} is the scenario's; only numbers of the design can be tuned")
    check_path(design, path)
    where, symbol = f"problem.variables.{path}", unit(design, path)
    if not symbol:
        raise InputError(f"{where}: {path} is {no_number(design, path)}; only numbers can be tuned")
    parts = [as_number(x) for x in given] if isinstance(given, list) else []
    scale = parts.pop() if len(parts) == 3 else SCALES[0]
    check_units_agree(where, parts)
    parts = [in_unit(where, x, symbol, **limits_of(design, path)) for x in parts]
    if len(parts) != 2 or not all(_is_number(x) for x in parts):
        raise InputError(f'{where} = {shown(given)} must be [low, high] in {symbol}, or [low, high, "linear"]')
    check_choice(f"{where}: scale", scale, SCALES)
    low, high = parts
    for bound in (low, high):
        check_number(where, bound, symbol, **limits_of(design, path))
    if not low < high:
        bounds = interval_text(*ends_as_typed(low, high, symbol, typed_unit(given)))
        raise InputError(f"{where} = {bounds}: the low bound must be below the high one")
    return Variable(path, low, high, scale)


def _scenarios(table: Mapping[str, Any], base: Part, listed: tuple[Part, ...]) -> tuple[Case, ...]:
    """Read the scenarios: the grid's, or the one that samples are taken about, or else the study's."""
    if "grid" in table:
        fields = _table(table, "grid", {})
        check_known(fields, tuple(paths(base)), "problem.grid", _meanings(base))
        return grid({name: _grid_values(name, values, base) for name, values in fields.items()}, base)
    return tuple(Case(scenario) for scenario in ((base,) if "sample" in table else listed))


def _grid_values(name: str, values: Any, base: Part) -> list[Any]:
    """Read the values of one field of a grid: numbers, listed or spanned, or some of what a choice may be."""
    where, symbol, limits = f"problem.grid.{name}", unit(base, name), limits_of(base, name)
    if not symbol:
        return _grid_choices(where, name, values, base)
    if isinstance(values, Mapping):
        return [float(x) for x in np.asarray(span(where, values, symbol, MOST))]
    listed = values if isinstance(values, list) else []
    check_units_agree(where, listed)
    read = [in_unit(where, x, symbol, **limits) for x in listed]
    if not read or not all(_is_number(x) for x in read):
        raise InputError(f"{where} = {shown(values)} must be a list of numbers in {symbol}; expected {EXAMPLE}")
    return read


def _grid_choices(where: str, name: str, values: Any, base: Part) -> list[Any]:
    if not isinstance(values, list) or not values:
        example = choices_example(metadata(base, name), get(base, name))
        raise InputError(f"{where} = {shown(values)} is not a list of choices; write some of {example}")
    for value in values:
        try:
            check_alone(base, base, f"{SCENARIO}{name}", value)
        except InputError as error:
            raise error.between("problem.grid: ") from None
        if values.count(value) > 1:
            raise InputError(f"{where} names {value} twice; keep one")
    return list(values)


def _scatter(table: Mapping[str, Any], design: Part, base: Part) -> Scatter | None:
    """Read how scenarios and design scatter; None where they do not."""
    if "sample" not in table:
        return None
    sample, spanned = _table(table, "sample", {}), _table(table, "grid", {})
    check_known(sample, SAMPLE, "problem.sample")
    fields, factors = (
        _distributions(_table(sample, name, {}), single_paths(part), f"problem.sample.{name}", _meanings(part))
        for name, part in (("scenario", base), ("factors", design))
    )
    for name in fields:
        if name in spanned:
            raise InputError(f"problem.sample.scenario.{name} and problem.grid.{name} both give {name}; keep one")
    seed = sample.get("seed", 0)
    check_whole("problem.sample.seed", seed, 0)
    read = lambda name, given, symbol: _distribution(f"problem.sample.{name}", given, symbol)  # noqa: E731
    return Scatter(
        sample.get("count", 16),
        {name: read(f"scenario.{name}", given, unit(base, name)) for name, given in fields.items()},
        {path: read(f"factors.{path}", given, "-") for path, given in factors.items()},
        seed,
    )


def _meanings(part: Part) -> Meaning:
    return lambda path: meaning(part, path)


def _distributions(table: Mapping[str, Any], known: tuple[str, ...], where: str, means: Meaning) -> dict[str, Any]:
    """Read distributions by path. **Raises:** `InputError` for an unknown path or kind, with the nearest one."""
    by_name = by_path(table, KINDS, where, known)
    check_known(by_name, known, where, means)
    for path, given in by_name.items():
        if isinstance(given, Mapping) and len(given) == 1:
            check_known(given, KINDS, f"{where}.{path}")
    return by_name


def _distribution(where: str, given: Any, unit: str) -> Distribution:
    if isinstance(given, dict) and len(given) == 1:
        ((kind, numbers),) = given.items()
        if isinstance(numbers, list):
            check_units_agree(where, numbers)
            numbers = [in_unit(where, x, unit) for x in numbers]
        if kind in KINDS and isinstance(numbers, list) and len(numbers) == 2 and all(_is_number(x) for x in numbers):
            try:
                return Distribution(kind, *map(as_number, numbers))
            except InputError as error:
                raise InputError(f"{where}: {error}") from None
    raise InputError(
        f"{where} = {shown(given)} must be {{ uniform = [low, high] }} or {{ normal = [mean, deviation] }}"
    )


def _objective(table: Mapping[str, Any], where: str, units: Mapping[str, str]) -> Objective:
    options = {name: table[name] for name in OPTIONS if name in table}
    weights = {name: weight for name, weight in table.items() if name not in options}
    check_known(weights, (*units, *OPTIONS), f"problem.{where}", quantity_in_words)
    for name, weight in weights.items():
        check_number(f"problem.{where}.{name}", weight, f"N/{units[name]}", low=0.0, low_open=True)
    return Objective(weights, **options) if weights else Objective(**options)


def limits(table: Mapping[str, Any], mechanism: Mechanism) -> Limits:
    """Read the limits of a [problem], by default the mechanism's."""
    units, ends = _units(table, mechanism), tuple(end.name for end in mechanism.tuning.ends)
    table = _table(table, "constraints", mechanism.defaults.limits)
    of_ends = {name: value for name, value in table.items() if name in ends}
    check_known(table, ("require_success", *ends, "impacts", *units), "problem.constraints", quantity_in_words)
    at_most, at_least = dict[str, float](), dict[str, float]()
    for name, given in table.items():
        if name not in units:
            continue
        where, symbol = f"problem.constraints.{name}", units[name]
        if isinstance(given, list):
            raise InputError(f"{where} = {shown(given)} is a list; write {name} = {{min = 0.1, max = 0.2}}")
        sides = given if isinstance(given, dict) else {"max": given}
        check_known(sides, SIDES, where)
        if not sides:
            raise InputError(f"{where} = {{}} limits nothing; write {name} = 0.1 or {name} = {{min = 0.1, max = 0.2}}")
        check_units_agree(
            where, [sides.get("min"), sides.get("max")], lambda low, high: f'{{min = "{low}", max = "{high}"}}'
        )
        for side, text in sides.items():
            value = in_unit(where, text, symbol, low=0.0, low_open=True)
            check_number(where, value, symbol, low=0.0, low_open=True)
            (at_most if side == "max" else at_least)[name] = value
    return Limits(table.get("require_success", True), at_most, table.get("impacts"), at_least, **of_ends)


def _then(table: Mapping[str, Any], units: Mapping[str, str]) -> SecondObjective:
    check_known(table, (*units, *OPTIONS, "tolerance"), "problem.then", quantity_in_words)
    if not set(table) & set(units):
        raise InputError(f"problem.then names no quantity; choose some of {listed(units)}")
    objective = {name: value for name, value in table.items() if name != "tolerance"}
    return SecondObjective(_objective(objective, "then", units), table.get("tolerance", SecondObjective.tolerance))


def _table(data: Mapping[str, Any], name: str, default: Mapping[str, Any]) -> Mapping[str, Any]:
    table = data.get(name, default)
    if not isinstance(table, dict):
        raise InputError(
            f"problem.{name} = {shown(table)} is not a table; write [problem.{name}] and its fields below it"
        )
    return table


def _is_number(value: Any) -> bool:
    # Python counts true and false among the whole numbers.
    return isinstance(value, (int, float)) and not isinstance(value, bool)
