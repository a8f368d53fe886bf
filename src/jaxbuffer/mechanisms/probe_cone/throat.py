"""Where the tip is in the cone, and the ends of a run that follow: captured behind the throat, or escaped (M65)."""

from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array

from ..._types import Scalar
from ...elements import Element
from ...multibody import Kinematics, Point
from ...plane import Vector
from .design import DockingDesign, Meeting

LEAST = 1e-30  # m²: keeps the slope of a distance from the axis finite on it


class ThroatState(NamedTuple):
    """The tip's centre in the cone at one instant.

    - ``before``: how far it is before the capture plane [m].
    - ``receding``: how fast that grows [m/s].
    - ``tip``: in the axes of the cone [m].
    - ``off_rim``: how much farther than the cone's rim it is from the axis [m]; below zero within.
    """

    before: Scalar
    receding: Scalar
    tip: Vector
    off_rim: Scalar


class Throat(Element):
    """The capture plane behind the throat, and the way back out of the cone; it exerts nothing.

    - ``design``, ``scenario``: whose cone, tip and start it is.
    - ``cone_body``, ``tip_body``, ``tip_point``: the bodies, and the tip's centre on its body.
    - ``holder``: name of the element that holds the tip behind the throat; None: the run ends there, captured.
    """

    design: DockingDesign[Any]
    scenario: Meeting
    tip_point: Point
    tip_body: int = eqx.field(static=True)
    cone_body: int = eqx.field(static=True)
    holder: str | None = eqx.field(static=True)
    name: str = eqx.field(static=True, default="throat")

    @property
    def plane(self) -> Scalar:
        """Return where the capture plane is along the axis of the cone [m]."""
        return -self.design.cone.offset - self.design.probe.tip_radius * jnp.sin(self.design.cone.half_angle)

    def evaluate(self, kin: Kinematics, own: Array) -> ThroatState:
        frame: Any = kin.frame(self.cone_body)  # of the plane or of space
        centre, cone = kin.point(self.tip_body, self.tip_point), self.design.cone
        tip = frame.unturn(centre.place - frame.origin)
        moves = frame.unturn(centre.velocity - frame.velocity)
        # The cone turns with its vehicle: to the relative velocity comes that of its turning axes.
        if kin.basis.dimensions == 2:
            turning, aside = frame.spin * tip.y, jnp.abs(tip.y)
        else:
            spin = frame.unturn(frame.spin)
            turning, aside = spin.z * tip.y - spin.y * tip.z, jnp.sqrt(tip.y**2 + tip.z**2 + LEAST)
        return ThroatState(
            before=self.plane - tip.x,
            receding=-jnp.asarray(moves.x + turning),
            tip=tip,
            off_rim=aside - (cone.throat_radius + cone.length * jnp.sin(cone.half_angle)),
        )

    @property
    def outcomes(self) -> tuple[str, ...]:
        return ("captured", "escaped") if self.holder is None else ("escaped",)

    def guards(self, at: ThroatState) -> list[Scalar]:
        cone, free = self.design.cone, self.scenario.start == "free"
        # From the capture plane to x = -L_T - 2 L_c, where the tip has escaped (M66).
        retreat = 2.0 * cone.length - self.design.probe.tip_radius * jnp.sin(cone.half_angle)
        escaped = at.before - (retreat + self.scenario.standoff if free else retreat)
        # Past the mouth outside the rim the tip has missed the cone, or has left it and drifts past.
        mouth = -cone.offset - cone.length * jnp.cos(cone.half_angle)
        escaped = jnp.where(jnp.asarray(at.off_rim) > 0.0, jnp.maximum(escaped, at.tip.x - mouth), escaped)
        return [-at.before, escaped] if self.holder is None else [escaped]

    def recorded(self, at: ThroatState, closed: Array) -> dict[str, Scalar]:
        return {"throat_distance": at.before}
