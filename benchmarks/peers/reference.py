"""The reference captures: a JSON list of inputs and of what comes out of them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .parameters import Parameters


@dataclass(frozen=True)
class Reference:
    """One capture whose result is known."""

    name: str
    parameters: Parameters
    outcome: str
    end_time: float  # [s]
    peak_force: float  # [N]
    peak_time: float  # [s]
    impacts: int
    elasticity: dict[str, float]  # d ln peak_force / d ln p [-]


def reference_of(case: dict[str, Any], parameters: Any) -> Reference:
    """The reference of a capture as its file has it; ``parameters``: the peer's."""
    return Reference(
        name=case["name"],
        parameters=parameters,
        outcome=case["outcome"],
        end_time=case["end_time"],
        peak_force=case["peak_force"],
        peak_time=case["peak_time"],
        impacts=int(case["impacts"]),
        elasticity=case.get("elasticity", {}),
    )


def load(path: Path) -> list[Reference]:
    """All captures of the file at ``path``."""
    return [reference_of(case, Parameters.from_inputs(case["inputs"])) for case in json.loads(Path(path).read_text())]
