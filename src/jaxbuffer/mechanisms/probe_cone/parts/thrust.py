"""A thrust that pushes the active vehicle along its axis from the start (M178)."""

from typing import Any

from ....elements import Element, Thrust
from ....errors import InputError
from ....fields import POSITIVE, Number, Part, number, on
from .part import Joined, ProbePart, S, Supply


class ThrustFields(Part):
    """``thrust`` [N], ``thrust_time`` [s]: a force that pushes the active vehicle along its axis from t = 0 on."""

    thrust: Number = number(
        None, "N", doc="force that pushes the active vehicle along its axis from the start; not set: none"
    )
    thrust_time: Number = number(None, "s", **POSITIVE, needs=on("thrust"), doc="how long that force lasts")

    def check_together(self) -> None:
        super().check_together()
        if self.has("thrust") != self.has("thrust_time"):
            given, missing = ("thrust", "thrust_time [s]") if self.has("thrust") else ("thrust_time", "thrust [N]")
            raise InputError(f"scenario.{given} needs scenario.{missing} too")


class ThrustPart(ProbePart):
    """The thrust of a scenario."""

    def elements(self, joined: Joined) -> tuple[Element, ...]:
        return (Thrust(S, joined.scenario.thrust, joined.scenario.thrust_time),)

    def label(self, scenario: Any) -> str:
        return f", thrust {float(scenario.thrust):.4g} N for {float(scenario.thrust_time):.4g} s"

    def summary(self, capture: Any, element: Element) -> list[tuple[str, str]]:
        return []  # what it put in stands in the line of the energy


THRUST = ThrustPart(
    name="thrust",
    path="scenario.thrust",
    supply=Supply("thrust", "the thrust"),
    has_events=True,
)
