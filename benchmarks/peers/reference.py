"""The reference captures: a JSON list of inputs and of what comes out of them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from .course import PeerCapture
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

    def errors(self, capture: PeerCapture) -> tuple[float, float]:
        """Relative errors of peak force and end time [-]."""
        return abs(capture.peak_force / self.peak_force - 1.0), abs(capture.end_time / self.end_time - 1.0)

    def alike(self, capture: PeerCapture) -> bool:
        """Whether the capture ends in the same way after as many impacts."""
        return capture.outcome == self.outcome and capture.impacts == self.impacts


def load(path: Path) -> list[Reference]:
    """All captures of the file at ``path``."""
    return [
        Reference(
            name=case["name"],
            parameters=Parameters.from_inputs(case["inputs"]),
            outcome=case["outcome"],
            end_time=case["end_time"],
            peak_force=case["peak_force"],
            peak_time=case["peak_time"],
            impacts=int(case["impacts"]),
            elasticity=case["elasticity"],
        )
        for case in json.loads(Path(path).read_text())
    ]
