"""What a dataset says of its origin."""

from typing import Any

from ..labelled.record import part_json
from ..version import version
from .mechanism import Mechanism


def attributes(mechanism: Mechanism, design: Any, scenario: Any) -> dict[str, Any]:
    """Return what a dataset says of its origin: with it a file stands on its own."""
    return {
        "title": mechanism.view.title,
        "kind": mechanism.name,
        "design": part_json(design),
        "scenario": part_json(scenario),
        "jaxbuffer": version(),
    }
