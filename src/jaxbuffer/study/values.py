"""Kinds of values in a study: each says in one place how it is read from TOML, and how editors are told of it.

Schemas are JSON Schema of draft 7 (json-schema.org).
"""

import dataclasses
import functools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError, as_number, check_choice, check_known, check_number, shown
from ..experiments.ranges import SCALES as RANGE_SCALES
from ..fields import (
    POSITIVE,
    SCENARIO,
    Part,
    check_choosing,
    check_path,
    check_units_agree,
    ends_as_typed,
    get,
    in_unit,
    limits_of,
    meaning,
    metadata,
    no_number,
    single_paths,
    typed_unit,
    unit,
)
from ..sweeps.axis import EXAMPLE, SPAN, choices_example, span
from ..tuning.problem.cases import KINDS, MOST, Distribution, grid_address
from ..tuning.problem.variable import SCALES, Variable
from ..value_text import interval_text

TEXT = {"type": "string", "pattern": r"^\s*[-+]?[0-9.]", "description": 'a number with its unit, "0.5 kN/m" say'}
SIDES = ("min", "max")  # of a two-sided limit
Schema = dict[str, Any]
Known = Mapping[str, Any]  # what a field declares of itself


class ValueKind(NamedTuple):
    """A kind of value, or of table.

    - ``read``: returns it from what TOML has, whose address is the first argument; raises `InputError`.
    - ``schema``: returns what an editor checks it by.
    """

    read: Callable[..., Any]
    schema: Callable[..., Schema]


def as_table(where: str, given: Any) -> Mapping[str, Any]:
    """Return what is given as a table. **Raises:** `InputError` where it is none."""
    if not isinstance(given, Mapping):
        raise InputError(f"{where} = {shown(given)} is not a table; write [{where}] and its fields below it")
    return given


def as_tables(where: str, given: Any) -> list[tuple[str, dict[str, Any]]]:
    """Return what is given as a list of tables, each with its name. **Raises:** `InputError` where it is none."""
    if not (isinstance(given, list) and given and all(isinstance(it, dict) for it in given)):
        raise InputError(f"{where} is not a list of tables; write each under its own [[{where}]]")
    return [(f"{where}[{k}]", it) for k, it in enumerate(given, 1)]


def object_schema(properties: Mapping[str, Schema], **others: Any) -> Schema:
    """Return the schema of a table with these names and no others."""
    # Closed, so that an editor marks a name that is misspelt.
    return {"type": "object", "properties": dict(properties), "additionalProperties": False, **others}


def read_value(path: str, given: Any, known: Known) -> Any:
    """Return the value of a field that declares its unit and range, its choices or its least whole number."""
    if "unit" in known:
        return read_number(path, given, known["unit"], **known["limits"])
    check_choosing(path, given, known)
    return given


def read_number(path: str, given: Any, unit: str, **limits: Any) -> float:
    """Read a float from an integer, a float or a text with a unit, in range; everything else TOML knows is an error."""
    number = as_number(in_unit(path, given, unit, **limits))
    if type(number) is not float:
        number = str(given).lower() if isinstance(given, bool) else str(given)  # as TOML spells it
    check_number(path, number, unit, **limits)
    return number


def value_schema(known: Known) -> Schema:
    """Return the schema of a field's value."""
    if "choices" in known:
        return {"enum": list(known["choices"])}
    if "unit" in known:
        return {"anyOf": [number_schema(known), TEXT]}
    if "curve" in known:
        one: Schema = {"anyOf": [number_schema({"limits": POSITIVE}), TEXT]}
        point = {"type": "array", "items": one, "minItems": 2, "maxItems": 2}
        return {"type": "array", "items": point, "minItems": 1}
    if "mesh" in known:
        return {"type": "string"}
    if "pattern" in known:
        return {"type": "string", "pattern": known["pattern"]} if known["pattern"] else {"type": "string"}
    return {"type": "integer", "minimum": known["least"]} if "least" in known else {"type": "boolean"}


def number_schema(known: Known) -> Schema:
    """Return the schema of a number in its field's range."""
    limits, schema = known.get("limits", {}), Schema(type="number")
    # JSON has no infinity: a side without an end is left out.
    if (low := limits.get("low", -math.inf)) > -math.inf:
        schema["exclusiveMinimum" if limits.get("low_open") else "minimum"] = low
    if (high := limits.get("high", math.inf)) < math.inf:
        schema["exclusiveMaximum" if limits.get("high_open") else "maximum"] = high
    return schema


def key_schema(name: str, known: Known) -> Schema:
    """Return the schema of a field with its unit, its meaning in words and its default, if it has one."""
    symbol, words, default = known.get("unit", "-"), known.get("doc") or name.replace("_", " "), known["default"]
    schema = value_schema(known) | {"description": words if symbol == "-" else f"[{symbol}] {words}"}
    return schema if default is None or default is dataclasses.MISSING else schema | {"default": default}


def _read_bounds(where: str, path: str, given: Any, design: Part) -> Variable:
    """Read the bounds of a design variable: [low, high] or [low, high, scale]."""
    # The design does not know such a path, and would call a field unknown that there is.
    if path.startswith(SCENARIO):
        table = where.removesuffix(f".{path}")
        raise InputError(f"{table}: {path} is the scenario's; only numbers of the design can be tuned")
    check_path(design, path)
    symbol, limits = unit(design, path), limits_of(design, path)
    if not symbol:
        raise InputError(f"{where}: {path} is {no_number(design, path)}; only numbers can be tuned")
    parts = [as_number(x) for x in given] if isinstance(given, list) else []
    scale = parts.pop() if len(parts) == 3 else SCALES[0]
    check_units_agree(where, parts)
    parts = [in_unit(where, x, symbol, **limits) for x in parts]
    if len(parts) != 2 or not all(_is_number(x) for x in parts):
        raise InputError(f'{where} = {shown(given)} must be [low, high] in {symbol}, or [low, high, "linear"]')
    check_choice(f"{where}: scale", scale, SCALES)
    low, high = parts
    for bound in (low, high):
        check_number(where, bound, symbol, **limits)
    if not low < high:
        bounds = interval_text(*ends_as_typed(low, high, symbol, typed_unit(given)))
        raise InputError(f"{where} = {bounds}: the low bound must be below the high one")
    return Variable(path, low, high, scale)


def _range_schema(known: Known, scales: Sequence[str]) -> Schema:
    """Return the schema of two ends and a scale."""
    items: Schema = {"anyOf": [number_schema(known), TEXT, {"enum": list(scales)}]}
    words = f"[low, high] in {known['unit']}, or [low, high, scale]"
    return {"type": "array", "items": items, "minItems": 2, "maxItems": 3, "description": words}


def _read_several(where: str, name: str, given: Any, part: Part) -> list[Any]:
    """Read several values of a field of a scenario or a design: numbers, listed or spanned, or some of what a choice
    may be."""
    check_known([name], single_paths(part), where.removesuffix(f".{name}"), lambda path: meaning(part, path))
    symbol, limits = unit(part, name), limits_of(part, name)
    if not symbol:
        return _read_choices(where, name, given, part)
    if isinstance(given, Mapping):
        return [float(x) for x in np.asarray(span(where, given, symbol, MOST))]
    listed = given if isinstance(given, list) else []
    check_units_agree(where, listed)
    read = [in_unit(where, x, symbol, **limits) for x in listed]
    if not read or not all(_is_number(x) for x in read):
        raise InputError(f"{where} = {shown(given)} must be a list of numbers in {symbol}; expected {EXAMPLE}")
    return read


def _read_choices(where: str, name: str, given: Any, part: Part) -> list[Any]:
    if not isinstance(given, list) or not given:
        example = choices_example(metadata(part, name), get(part, name))
        raise InputError(f"{where} = {shown(given)} is not a list of choices; write some of {example}")
    for value in given:
        try:
            check_choosing(grid_address(name), value, metadata(part, name))
        except InputError as error:
            raise error.between("problem.grid: ") from None
        # The same combinations would be run, and weighed in a mean, twice.
        if given.count(value) > 1:
            raise InputError(f"{where} names {value} twice; keep one")
    return list(given)


def _several_schema(known: Known) -> Schema:
    """Return the schema of several values of a field: a list, or of a number the ends of a range and how many."""
    one = value_schema(known)
    listed = {"type": "array", "items": one, "minItems": 1}
    if "unit" not in known:
        return listed
    kinds: Schema = {**dict.fromkeys(SPAN[:2], one), "count": {"type": "integer", "minimum": 1}}
    spanned = object_schema({**kinds, "scale": {"enum": list(RANGE_SCALES)}}, required=list(SPAN[:3]))
    return {"anyOf": [listed, spanned]}


def _one_or_several_schema(known: Known) -> Schema:
    one = value_schema(known)
    if "unit" not in known:
        return {"anyOf": [one, {"type": "array", "items": one, "minItems": 1}]}
    return {"anyOf": [one, *_several_schema(known)["anyOf"]], "description": f"[{known['unit']}]"}


def _read_distribution(where: str, path: str, given: Any, part: Part, symbol: str | None = None) -> Distribution:
    """Read how a number scatters; ``symbol``: the unit of that, by default the field's."""
    check_known([path], single_paths(part), where.removesuffix(f".{path}"), lambda it: meaning(part, it))
    symbol = unit(part, path) if symbol is None else symbol
    if isinstance(given, dict) and len(given) == 1:
        check_known(given, KINDS, where)
        ((kind, numbers),) = given.items()
        if isinstance(numbers, list):
            check_units_agree(where, numbers)
            numbers = [in_unit(where, x, symbol) for x in numbers]
        if isinstance(numbers, list) and len(numbers) == 2 and all(_is_number(x) for x in numbers):
            try:
                return Distribution(kind, *map(as_number, numbers))
            except InputError as error:
                raise error.between(f"{where}: ") from None
    raise InputError(
        f"{where} = {shown(given)} must be {{ uniform = [low, high] }} or {{ normal = [mean, deviation] }}"
    )


def _distribution_schema(words: str) -> Schema:
    """Return the schema of a number that scatters."""
    two: Schema = {"type": "array", "items": {"anyOf": [{"type": "number"}, TEXT]}, "minItems": 2, "maxItems": 2}
    kinds = {kind: two | {"description": f"{words}, {ends}"} for kind, ends in zip(KINDS, ENDS, strict=True)}
    return object_schema(kinds, minProperties=1, maxProperties=1)


def _tolerance_schema(known: Known) -> Schema:
    """Return the schema of a tolerance: a text, of a plain number a number, or a pair of them."""
    one: Schema = {"anyOf": [TEXT, {"type": "number"}]} if known.get("unit") == "-" else {"type": "string"}
    pair = {"type": "array", "items": {"anyOf": [TEXT, {"type": "number"}]}, "minItems": 2, "maxItems": 2}
    words = f'"10 %" of the number, or in {known.get("unit")}; a pair for unequal sides'
    return {"anyOf": [one, pair], "description": words}


def toleranced_schema(known: Known) -> Schema:
    """Return the schema of a number that stands with its tolerance."""
    inner = {"value": value_schema(known), "tolerance": _tolerance_schema(known)}
    return object_schema(inner, required=list(TOLERANCED))


def _as_given(where: str, path: str, given: Any, part: Part) -> Any:
    """Return a value as it is: `sweeps.grid` and `experiments.ranges` read it."""
    return given


ENDS = ("low and high", "mean, deviation")  # the two numbers of each of `KINDS`
BOUNDS = ValueKind(_read_bounds, lambda known: _range_schema(known, SCALES))
SEVERAL = ValueKind(_read_several, _several_schema)
TOLERANCED = ("value", "tolerance")  # keys of a number that stands with its tolerance
TOLERANCE = ValueKind(_as_given, _tolerance_schema)
SWEPT = ValueKind(_as_given, _one_or_several_schema)
RANGE = ValueKind(_as_given, lambda known: _range_schema(known, RANGE_SCALES))
DISTRIBUTION = ValueKind(_read_distribution, lambda known: _distribution_schema(f"[{known['unit']}]"))
FACTOR = ValueKind(
    functools.partial(_read_distribution, symbol="-"), lambda known: _distribution_schema("[-] of the drawn number")
)


def _read_weight(where: str, given: Any, symbol: str) -> Any:
    check_number(where, given, f"N/{symbol}", **POSITIVE)
    return given


def _read_sides(where: str, given: Any, symbol: str) -> dict[str, float]:
    """Read a limit on a quantity, by side: one number is an upper one."""
    name = where.rpartition(".")[2]
    if isinstance(given, list):
        raise InputError(f"{where} = {shown(given)} is a list; write {name} = {{min = 0.1, max = 0.2}}")
    sides = given if isinstance(given, dict) else {"max": given}
    check_known(sides, SIDES, where)
    if not sides:
        raise InputError(f"{where} = {{}} limits nothing; write {name} = 0.1 or {name} = {{min = 0.1, max = 0.2}}")
    check_units_agree(
        where, [sides.get(side) for side in SIDES], lambda low, high: f'{{min = "{low}", max = "{high}"}}'
    )
    read = {side: in_unit(where, text, symbol, **POSITIVE) for side, text in sides.items()}
    for value in read.values():
        check_number(where, value, symbol, **POSITIVE)
    return read


def _sides_schema() -> Schema:
    bound: Schema = {"anyOf": [number_schema({"limits": POSITIVE}), TEXT]}
    return {"anyOf": [bound, object_schema(dict.fromkeys(SIDES, bound), minProperties=1)]}


WEIGHT = ValueKind(_read_weight, lambda: number_schema({"limits": POSITIVE}))
LIMIT = ValueKind(_read_sides, _sides_schema)


def _is_number(value: Any) -> bool:
    # Python counts true and false among the whole numbers.
    return isinstance(value, (int, float)) and not isinstance(value, bool)
