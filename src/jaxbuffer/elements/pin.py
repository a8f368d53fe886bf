"""A pin with play in a bush of another body (M109)."""

import math
from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar
from ..basis import AnyBasis
from ..contact import Hole
from ..contact.laws import BEYOND_LAW
from ..multibody import Kinematics, Load, System
from .ball_contact import BallContact, BallState
from .element import Closed, ContactForces, Element, Own, Switch
from .picture import Level, Panel, PanelCurve
from .report import EnergyShare, Report
from .stiff_terms import ContactTerm
from .telling import BY_HOW_MUCH, largest

SMALL = 0.1  # of the pin's radius squared: up to here the area that it touches counts as small


class Pin(Element):
    """A pin in a bush that it touches again and again, without friction and without a memory of its impacts.

    For a contact whose law needs the speed of its impacts, whose impacts are listed, or that has friction, use
    `BallContact` with a `Hole`.

    - ``contact``: the pin on its body, in a `Hole` of the other one; its law may not use a memory.
    - ``name``: of its switch; ``stored_in``, ``lost_in``: of its energies.
    """

    contact: BallContact
    name: str = eqx.field(static=True, default="pin")
    stored_in: str = eqx.field(static=True, default="hinge")
    lost_in: str = eqx.field(static=True, default="hinge_play")

    def in_mechanism(self, speed: Scalar, basis: AnyBasis) -> "Pin":
        self.contact.in_mechanism(speed, basis)  # says that a bush is of the plane; a pin needs no typical speed
        return self

    @property
    def switches(self) -> tuple[Switch, ...]:
        return (Switch(self.name),)

    @property
    def jumps(self) -> bool:
        return self.contact.pair.law.jumps

    def evaluate(self, kin: Kinematics, own: Own) -> BallState:
        return self.contact.evaluate(kin)  # whose memory means nothing: the law has none

    def gaps(self, at: BallState) -> list[tuple[Scalar, Scalar]]:
        return [(at.approach.gap[0], at.approach.approach_speed[0])]

    def force(self, at: BallState, closed: Closed) -> Float[Array, " 1"]:
        """Return the force of the bush on the pin [N]."""
        return closed * self.contact.pair.normal_force(at.approach, at.memory)

    def loads(self, at: BallState, closed: Closed) -> tuple[Load, ...]:
        return self.contact.loads_of(at, ContactForces(self.force(at, closed), jnp.zeros(1)))

    def stored(self, at: BallState, closed: Closed) -> dict[str, Scalar]:
        return {self.stored_in: self.contact.elastic_energy(at, closed)}

    @property
    def loss_names(self) -> tuple[str, ...]:
        return (self.lost_in,)

    def losses(self, at: BallState, closed: Closed) -> dict[str, Scalar]:
        power = self.contact.pair.hysteresis_power(at.approach, self.force(at, closed))
        return {self.lost_in: jnp.sum(closed * power)}

    def recorded(self, at: BallState, closed: Closed) -> dict[str, Scalar]:
        return {f"{self.stored_in}_gap": at.approach.gap[0]}

    def contact_term(self, system: System, at: BallState, closed: Closed) -> ContactTerm:
        return self.contact.contact_term(system, at, closed)

    def stiff_force(self, at: BallState, closed: Closed) -> Scalar:
        return self.force(at, closed)[0]

    @property
    def has_impulsive_reactions(self) -> bool:
        return True  # where the pin bounces, the reaction rises from nothing within a step

    @property
    def report(self) -> "PinReport":
        return PinReport(self)


class PinReport(Report[Pin]):
    """What is said and drawn of a pin with play."""

    def _sizes(self, run: Any) -> tuple[float, float, float]:
        """Return the radii of pin and bush, and how deep the largest force presses the pin into it, NaN where that is
        not watched [m]."""
        joint = self.element
        pair, force = joint.contact.pair, largest(run, f"{joint.stored_in}_force")
        assert isinstance(pair.shape, Hole)
        depth = float(pair.law.depth(force)) if math.isfinite(force) else math.nan
        return float(pair.radius), float(pair.shape.radius), depth

    def summary(self, run: Any) -> list[tuple[str, str]]:
        pin, bush, depth = self._sizes(run)
        into = f"; the pin goes up to {1e6 * depth:.3g} µm into it" if math.isfinite(depth) else ""
        return [(f"play in the {self.element.stored_in}", f"{1e3 * (bush - pin):.4g} mm{into}")]

    def panels(self, run: Any) -> list[Panel]:
        joint = self.element
        gap = PanelCurve("", 1e6 * run.history.others[f"{joint.stored_in}_gap"])
        return [
            Panel(f"{joint.stored_in.capitalize()}, from the pin to its bush", "gap [µm]", (gap,), (Level("", 0.0),))
        ]

    def warnings(self, run: Any) -> list[str]:
        """Return a line on how errors grow as the pin bounces, and one if the pin goes beyond Hertz's contact, which
        holds while the radius of the area it touches is small against the pin's: √(R δ) ≤ √(0.1) R_pin, with R of
        M54."""
        bounces = (
            f"errors may grow: the pin bounces in its play, and forces of the {self.element.stored_in} may be off by"
            f" far more than the tolerance; {BY_HOW_MUCH}"
        )
        pin, bush, depth = self._sizes(run)
        square = pin * bush / (bush - pin) * depth
        if not square > SMALL * pin**2:
            return [bounces]
        return [
            bounces,
            f"{BEYOND_LAW}the pin touches its bush on an area with a radius of {1e3 * math.sqrt(square):.3g} mm,"
            f" not small against its own of {1e3 * pin:.3g} mm; the play is too small for Hertz's law",
        ]

    @property
    def shares(self) -> tuple[EnergyShare, ...]:
        joint = self.element
        return (
            EnergyShare(
                f"{joint.stored_in}'s play", f"in the {joint.stored_in}'s play", (joint.stored_in, joint.lost_in)
            ),
        )

    @property
    def balls(self) -> tuple[BallContact, ...]:
        return (self.element.contact,)
