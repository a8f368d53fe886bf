"""The names that a shell completes, of all mechanisms."""

from typing import Any

from ...fields import SCENARIO, Part, meaning, metadata, paths
from ...mechanisms import all_mechanisms
from ...mechanisms.mechanism import Mechanism
from ...mechanisms.quantity import OF_IMPACT


def all_names() -> dict[str, Any]:
    """Return fields, by address, and quantities of all mechanisms by kind, of simple types for JSON."""
    return {mechanism.name: _names(mechanism) for mechanism in all_mechanisms()}


def _names(mechanism: Mechanism) -> dict[str, Any]:
    parts = {"": mechanism.design(), SCENARIO: mechanism.scenario()}
    return {
        "title": mechanism.view.title,
        "fields": {prefix + path: _field(part, path) for prefix, part in parts.items() for path in paths(part)},
        "quantities": {
            name: {
                "doc": f"{it.description} [{it.unit}]",
                "unit": it.unit,
                "differentiable": it.differentiable,
                "swept": it.swept,
                "tuned": it.tuned,
            }
            for name, it in mechanism.quantities.items()
        },
        "impacts": {f"impact.N.{field}": unit for field, unit in OF_IMPACT.items()},
    }


def _field(part: Part, path: str) -> dict[str, Any]:
    known = metadata(part, path)
    words = list(known.get("choices", ())) or (["true", "false"] if "flag" in known else [])
    unit = known.get("unit", "")
    shown = f" [{unit}]" if unit else ""
    takes = "points" if "curve" in known else "a whole number"
    return {"doc": meaning(part, path) + shown, "unit": unit, "words": words, "takes": takes, "number": "unit" in known}
