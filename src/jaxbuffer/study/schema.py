"""The JSON Schema of a mechanism's studies, for editors, in draft 7, which taplo and VS Code read (json-schema.org).

It knows names, ranges, choices and units; what must fit together is checked by `jaxbuffer check`.
"""

import dataclasses
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from ..experiments.points import METHODS
from ..fields import POSITIVE, Part, get, meaning, metadata, paths
from ..mechanisms.mechanism import Mechanism
from ..sweeps.axis import SCALES as RANGES
from ..tuning.problem import SCALES, Settings
from .config import KINDS, StudyOptions, sections

DIALECT = "http://json-schema.org/draft-07/schema#"
TEXT = {"type": "string", "pattern": r"^\s*[-+]?[0-9.]", "description": 'a number with its unit, "0.5 kN/m" say'}
Schema = dict[str, Any]


def study_schema(mechanism: Mechanism) -> Schema:
    """Return the schema of a study of the mechanism."""
    design, scenario = mechanism.design(), mechanism.scenario()
    fields = {path: metadata(design, path) for path in paths(design)}
    fields |= {f"scenario.{path}": metadata(scenario, path) for path in paths(scenario)}
    parts = {name: _part(getattr(design, name)) for name in sections(mechanism)}
    properties = {
        "kind": {"const": mechanism.name, "description": f"the mechanism: {mechanism.view.title}"},
        **parts,
        "scenario": _part(scenario),
        "scenarios": {"type": "array", "items": _part(scenario), "minItems": 1},
        "options": _part(StudyOptions()),
        "tune": _part(Settings()),
        "problem": _problem(mechanism, design, scenario),
        "sweep": _by_path(fields, _values),
        "sample": _sample(fields),
    }
    return {
        "$schema": DIALECT,
        "title": f"jaxbuffer study, kind = {mechanism.name}",
        "type": "object",
        "properties": {name: schema for name, schema in properties.items() if name in (*parts, *KINDS)},
        "additionalProperties": False,
    }


def _object(properties: Mapping[str, Schema], **others: Any) -> Schema:
    # Closed, so that an editor marks a name that is misspelt.
    return {"type": "object", "properties": dict(properties), "additionalProperties": False, **others}


def _part(part: Part) -> Schema:
    """Return the schema of a section: each field with its range or choices, its unit and meaning in words."""
    fields = {}
    for name in (field.name for field in dataclasses.fields(part)):
        known, value = metadata(part, name), get(part, name)
        symbol = known.get("unit", "-")
        said = meaning(part, name)
        schema = _field(known) | {"description": said if symbol == "-" else f"[{symbol}] {said}"}
        fields[name] = schema if value is None else schema | {"default": value}
    return _object(fields)


def _field(known: Mapping[str, Any]) -> Schema:
    if "choices" in known:
        return {"enum": list(known["choices"])}
    if "unit" in known:
        return {"anyOf": [_number(known), TEXT]}
    if "curve" in known:
        one: Schema = {"anyOf": [_number({"limits": POSITIVE}), TEXT]}
        point = {"type": "array", "items": one, "minItems": 2, "maxItems": 2}
        return {"type": "array", "items": point, "minItems": 1}
    if "mesh" in known:
        return {"type": "string"}
    return {"type": "integer", "minimum": known["least"]} if "least" in known else {"type": "boolean"}


def _number(known: Mapping[str, Any]) -> Schema:
    limits, schema = known.get("limits", {}), Schema(type="number")
    if (low := limits.get("low", -math.inf)) > -math.inf:
        schema["exclusiveMinimum" if limits.get("low_open") else "minimum"] = low
    if (high := limits.get("high", math.inf)) < math.inf:
        schema["exclusiveMaximum" if limits.get("high_open") else "maximum"] = high
    return schema


def _by_path(fields: Mapping[str, Mapping[str, Any]], schema_of: Callable[[Mapping[str, Any]], Schema]) -> Schema:
    """Return the schema of a table of dotted paths, which TOML reads as tables in tables, or quoted as they are:
    ``schema_of`` what each field declares; of a measured curve of its numbers, "force[2]" say."""
    nested, whole, patterns = dict[str, dict[str, Schema]](), dict[str, Schema](), dict[str, Schema]()
    for path, known in fields.items():
        section, _, name = path.partition(".")
        if "curve" in known:
            numbers = {axis: schema_of({"unit": unit, "limits": POSITIVE}) for axis, unit in known["curve"]}
            schema = _object({}, patternProperties={rf"^{axis}\[[0-9]+\]$": it for axis, it in numbers.items()})
            patterns |= {rf"^{re.escape(path)}\.{axis}\[[0-9]+\]$": it for axis, it in numbers.items()}
        else:
            schema = schema_of(known)
        nested.setdefault(section, {})[name] = whole[path] = schema
    sections = {section: _object(inner) for section, inner in nested.items()}
    return _object(sections | whole, **({"patternProperties": patterns} if patterns else {}))


def _numeric(known: Mapping[str, Any]) -> bool:
    """Return whether a field is a number or has numbers: a measured curve's."""
    return "unit" in known or "curve" in known


def _values(known: Mapping[str, Any]) -> Schema:
    """Return the schema of the values of a sweep."""
    if "unit" not in known:
        choice = _field(known)
        return {"anyOf": [choice, {"type": "array", "items": choice, "minItems": 1}]}
    one: Schema = {"anyOf": [_number(known), TEXT]}
    return {"anyOf": [one, *_listed_or_spanned(known)["anyOf"]], "description": f"[{known['unit']}]"}


def _listed_or_spanned(known: Mapping[str, Any]) -> Schema:
    """Return the schema of several values of a field: a list, or of a number the ends of a range and how many."""
    one = _field(known)
    listed = {"type": "array", "items": one, "minItems": 1}
    if "unit" not in known:
        return listed
    span = {"from": one, "to": one, "count": {"type": "integer", "minimum": 1}, "scale": {"enum": ["linear", "log"]}}
    return {"anyOf": [listed, _object(span, required=["from", "to", "count"])]}


def _sample(fields: Mapping[str, Mapping[str, Any]]) -> Schema:
    ranges = {path: known for path, known in fields.items() if _numeric(known)}
    whole = {"count": {"type": "integer", "minimum": 1}, "seed": {"type": "integer", "minimum": 0}}
    return _object(
        {**whole, "method": {"enum": list(METHODS)}, "ranges": _by_path(ranges, lambda known: _range(known, RANGES))}
    )


def _range(known: Mapping[str, Any], scales: Sequence[str]) -> Schema:
    """Return the schema of two ends and a scale."""
    items: Schema = {"anyOf": [_number(known), TEXT, {"enum": list(scales)}]}
    words = f"[low, high] in {known['unit']}, or [low, high, scale]"
    return {"type": "array", "items": items, "minItems": 2, "maxItems": 3, "description": words}


def _scatter(numbers: Mapping[str, Mapping[str, Any]], scenario: Mapping[str, Mapping[str, Any]]) -> Schema:
    """Return the schema of how the cases of a tuning scatter."""
    fields = {path: _distribution(f"[{known['unit']}]") for path, known in scenario.items() if "unit" in known}
    parts: dict[str, Schema] = {
        "count": {"type": "integer", "minimum": 1, "description": "samples of each scenario; their worst is no bound"},
        "seed": {"type": "integer", "minimum": 0, "description": "the same seed draws the same samples"},
        "scenario": _object(fields, description="how the scenario's fields scatter"),
        "factors": _by_path(numbers, lambda known: _distribution("[-] of the drawn number"))
        | {"description": "tolerances: factors on the design's numbers, 1 being as drawn"},
    }
    return _object(parts, description="robust designs: samples of scenarios and tolerances that a tuning serves")


def _distribution(words: str) -> Schema:
    """Return the schema of a number that scatters."""
    two: Schema = {"type": "array", "items": {"anyOf": [{"type": "number"}, TEXT]}, "minItems": 2, "maxItems": 2}
    uniform, normal = (
        two | {"description": f"{words}, low and high"},
        two | {"description": f"{words}, mean, deviation"},
    )
    return _object({"uniform": uniform, "normal": normal}, minProperties=1, maxProperties=1)


def _problem(mechanism: Mechanism, design: Part, scenario: Part) -> Schema:
    numbers = {path: metadata(design, path) for path in paths(design) if _numeric(metadata(design, path))}
    listed = {path: _listed_or_spanned(metadata(scenario, path)) for path in paths(scenario)}
    weights = _quantities(mechanism, mechanism.tuned, {"type": "number", "exclusiveMinimum": 0})
    bound: Schema = {"anyOf": [{"type": "number", "exclusiveMinimum": 0}, TEXT]}
    sides: Schema = {"anyOf": [bound, _object({"min": bound, "max": bound}, minProperties=1)]}
    over: dict[str, Schema] = {"over": {"enum": ["worst", "mean", "cvar"]}, "level": {"type": "number", "minimum": 0}}
    limits: dict[str, Schema] = {"require_success": {"type": "boolean"}, "impacts": {"type": "integer", "minimum": 1}}
    limits |= {end.name: {"type": "boolean"} for end in mechanism.tuning.ends}
    return _object(
        {
            "variables": _by_path(numbers, lambda known: _range(known, SCALES)),
            "grid": _object(listed),
            "sample": _scatter(numbers, {path: metadata(scenario, path) for path in paths(scenario)}),
            "objective": _open(weights | over),
            "constraints": _open(_quantities(mechanism, mechanism.tuned, sides) | limits),
            "quantities": {
                "type": "object",
                "description": "quantities of your own, by name: Python functions of those above",
                "additionalProperties": _own(),
            },
            "then": _open(weights | over | {"tolerance": {"type": "number", "exclusiveMinimum": 0, "maximum": 1}}),
        }
    )


def _own() -> Schema:
    """Return the schema of a study's own quantity."""
    text: Schema = {"type": "string"}
    file = text | {"pattern": r"\.py:\w+$", "description": "a file beside the study and a name: objectives.py:effort"}
    unit = text | {"description": "of what the function returns, - for none"}
    return _object({"function": file, "unit": unit, "description": text}, required=["function", "unit"])


def _open(properties: Mapping[str, Schema]) -> Schema:
    """Return the schema of an object that may have other names too: those of a study's own quantities."""
    return {"type": "object", "properties": dict(properties)}


def _quantities(mechanism: Mechanism, names: Iterable[str], schema: Schema) -> dict[str, Schema]:
    catalogue = mechanism.quantities
    return {name: schema | {"description": f"[{catalogue[name].unit}] {catalogue[name].description}"} for name in names}
