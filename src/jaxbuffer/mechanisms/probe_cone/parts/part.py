"""What an optional part of a probe-cone mechanism says of itself: the protocol of the registry `PARTS`.

A design has a part where one of its numbers is set. Fields, element, quantities, words and pictures of a part stand in
one module; the mechanism asks the parts there are, and names none of them.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ...._types import Scalar
from ....elements import BallContact, Element
from ....multibody import AxialSpringDamper
from ...assembled import Assembled, Observable
from ...layout import Closed, EvaluatedState
from ...mechanism import RequiredEnd
from ...quantity import Quantity
from ...validity import ValidityLimit
from ...view import Caution

S, B, P, T = range(4)  # bodies: active vehicle, cylinder, probe, passive vehicle, in the order of the coordinates


class Joined(NamedTuple):
    """What the elements of parts are joined to.

    - ``design``, ``scenario``.
    - ``tip``: the tip's centre on the probe.
    - ``axial``: the buffer's axial force, by which stops measure their stroke too, so that all of them agree on it.
    - ``throat``: the element with the capture plane.
    - ``contact``: of the tip with the cone.
    """

    design: Any
    scenario: Any
    tip: Any
    axial: AxialSpringDamper
    throat: Any
    contact: BallContact

    @property
    def plane(self) -> Scalar:
        """Return where the capture plane is along the axis of the passive vehicle [m]."""
        return self.throat.plane


class Supply(NamedTuple):
    """Energy that a part puts in from outside: the ``name`` under which it is stored, negative; ``words`` of a summary
    for what puts it in; ``note`` at a figure of energies, or ""."""

    name: str
    words: str
    note: str = ""


class DrawnPart(NamedTuple):
    """A part in a drawing.

    - ``shapes``: of it.
    - ``frames``: how many frames of its own it has, behind those of the bodies and of parts before it.
    - ``with_frames``: adds them to the frames of a history's steps.
    """

    shapes: tuple[Any, ...]
    frames: int = 0
    with_frames: Callable[[np.ndarray, Any], np.ndarray] = lambda frames, history: frames


@dataclasses.dataclass(frozen=True)
class ProbePart:
    """An optional part. Every attribute and method has a default that says nothing.

    What it is:

    - ``name``: of its element.
    - ``path``: the number without which a design lacks it; "scenario.…" for one of the scenario.

    What a mechanism with it has:

    - ``quantities``, and ``recorded``: what a history has besides, with units.
    - ``supply``: energy that it puts in from outside.
    - ``vehicle_force``: what the force is called that it exerts on a vehicle, and the quantity that is its largest.
    - ``holds``: whether it holds the tip behind the capture plane, where a run would end without it.
    - ``has_events``: whether it begins or ends at events that a solver without events cannot locate.

    What calls and studies use:

    - ``defaults`` of designs that have it; ``always``: limits that each tuned design keeps; ``ends`` that a study may
      ask for; ``example``: numbers and limits of an example study.
    - ``limitation``: what is not simulated without it.
    """

    name: str
    path: str
    quantities: Mapping[str, Quantity] = dataclasses.field(default_factory=dict)
    recorded: Mapping[str, str] = dataclasses.field(default_factory=dict)
    supply: Supply | None = None
    vehicle_force: tuple[str, str] | None = None
    holds: bool = False
    has_events: bool = False
    defaults: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    always: Mapping[str, float] = dataclasses.field(default_factory=dict)
    ends: tuple[RequiredEnd, ...] = ()
    example: Mapping[str, float] = dataclasses.field(default_factory=dict)
    example_limits: Mapping[str, float] = dataclasses.field(default_factory=dict)
    example_variables: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    limitation: str = ""

    def present(self, design: Any, scenario: Any = None) -> bool:
        """Return whether a design, or its scenario, has the part."""
        value = scenario if self.path.startswith("scenario.") else design
        for name in self.path.removeprefix("scenario.").split("."):
            # Another mechanism with some of these parts may lack the whole section.
            value = getattr(value, name, None)
        return value is not None

    # --- physics ------------------------------------------------------------------------------------------------------

    def elements(self, joined: Joined) -> tuple[Element, ...]:
        """Return the elements of the part; it is present."""
        return ()

    def observables(self, design: Any) -> tuple[Observable, ...]:
        """Return what is observed of a run beside the elements' own observables; the part is present."""
        return ()

    def history(self, design: Any) -> tuple[Observable, ...]:
        """Return what every history has besides, whether the part is present or not."""
        return ()

    def rest_threshold(self, design: Any) -> Scalar:
        """Return the share of the first energy of relative motion below which the vehicles are at rest, of a part that
        `holds` them."""
        raise NotImplementedError

    def push(self, mechanism: Assembled, at: EvaluatedState, active: Closed) -> Scalar | None:
        """Return the force by which the part resists the buffer's shortening at its end [N], None if it does not."""
        return None

    def stroke_energy(self, mechanism: Assembled) -> Callable[[Array], Array] | None:
        """Return the energy that the part stores at a stroke [J] as a function of it [m], convex, or None."""
        return None

    # --- words --------------------------------------------------------------------------------------------------------

    def label(self, scenario: Any) -> str:
        """Return what a scenario with the part is called besides: ", thrust 1 N for 0.4 s"."""
        return ""

    def cautions(self, design: Any) -> list[str]:
        """Return a line for each thing that is easily left out of a design with the part."""
        return []

    def contradictions(self, design: Any, scenario: Any) -> list[Caution]:
        """Return a `Caution` for each thing that design and scenario rule out for the part, before any computation."""
        return []

    def validity(self, quantities: Mapping[str, Any]) -> list[ValidityLimit]:
        """Return what of it an answer may lie beyond, from the quantities that are known of one run or of many."""
        return []

    def summary(self, capture: Any, element: Element) -> list[tuple[str, str]]:
        """Return the lines of a summary of its element, each as its heading and its text."""
        return element.report.summary(capture)

    def buffer_text(self, capture: Any) -> str:
        """Return what a summary's line of the buffer's force says besides."""
        return ""

    def stroke_limits(self, design: Any) -> list[tuple[str, Scalar]]:
        """Return what limits the buffer's stroke, in words, and from which stroke on [m]."""
        return []

    def warnings(self, capture: Any) -> list[str]:
        """Return a line for each thing to be wary of in a run, beside those of its elements' reports."""
        return []

    def diagnosis(self, capture: Any) -> tuple[Mapping[str, str], str] | None:
        """Return what held a run back, a text by heading, and what to change first, where the part did; else None."""
        return None

    def drawn(self, design: Any, first: int) -> DrawnPart:
        """Return the part in a drawing. ``first``: number of the first frame of its own."""
        return DrawnPart(())

    def end_on(self, design: Any, first: int) -> DrawnPart:
        """Return the part as it is seen along the cone's axis, z to the right and y up; ``first`` as of `drawn`."""
        return DrawnPart(())


def loss(name: str) -> Callable[[Any], Any]:
    """Return how the energy lost in a place is read off, which not every design has."""
    # Times a loss that every capture has, so that the zero has the shape of many runs and is NaN where one failed.
    return lambda capture: capture.energy.lost.get(name, 0.0 * capture.energy.friction)


def time_of(maximum: str, what: str) -> Quantity:
    """Return the time of one of the run's maxima as a quantity, which a finished run alone has."""
    return Quantity(
        "s",
        lambda capture: jnp.asarray(capture.maximum_times.get(maximum, math.nan)),
        f"when {what} is largest, of a finished run",
        differentiable=False,
    )
