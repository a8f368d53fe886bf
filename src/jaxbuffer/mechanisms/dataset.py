"""What a dataset says of its origin."""

from typing import Any

from ..fields.record import json_record
from ..version import version
from .mechanism import Mechanism


def attributes(mechanism: Mechanism, design: Any, scenario: Any) -> dict[str, Any]:
    """Return what a dataset says of its origin: with it a file stands on its own."""
    return {
        "title": mechanism.view.title,
        "kind": mechanism.name,
        "design": json_record(design),
        "scenario": json_record(scenario),
        "jaxbuffer": version(),
    }
