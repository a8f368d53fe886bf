"""The names that a shell completes, of all mechanisms."""

from typing import Any

from ...fields import SCENARIO, Part, meaning, metadata, paths
from ...mechanisms import all_mechanisms
from ...mechanisms.mechanism import Mechanism


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
                "differentiable": it.differentiable,
                "swept": it.swept,
                "tuned": it.tuned,
            }
            for name, it in mechanism.quantities.items()
        },
    }


def _field(part: Part, path: str) -> dict[str, Any]:
    known = metadata(part, path)
    words = list(known.get("choices", ())) or (["true", "false"] if "flag" in known else [])
    unit = f" [{known['unit']}]" if "unit" in known else ""
    return {"doc": meaning(part, path) + unit, "words": words, "number": "unit" in known}
