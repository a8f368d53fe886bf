"""Play in the hinge between active vehicle and cylinder (M109)."""

from collections.abc import Iterator
from typing import Any, ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Bool

from ...._types import Scalar
from ....contact import BallPair, Hole, RegularisedCoulomb, socket_stiffness
from ....contact.laws import DampedHertz
from ....elements import BallContact, Element, Pin
from ....errors import check_entries, inside
from ....fields import NON_NEGATIVE, POSITIVE, Number, Part, number, on
from ....suggestions import same_name
from ...quantity import Quantity
from .part import B, Joined, ProbePart, S

same_name("play", "clearance", "gap")


class Hinge(Part):
    """Play in the hinge between active vehicle and cylinder: a pin on the vehicle in a bush on the cylinder.

    Force of the contact: K δ^{3/2} (1 + a δ̇), Hunt and Crossley's, without friction (M109); two free bodies part with
    the restitution 1 - ⅔ a v, while that is near 1.
    """

    section: ClassVar[str] = "hinge"
    play: Number = number(
        None, "m", **POSITIVE, doc="radial clearance, the bush's radius less the pin's; not set: none"
    )
    bush_radius: Number = number(0.005, "m", **POSITIVE, needs=on("play"), doc="radius of the bush")
    damping: Number = number(
        5.0,
        "s/m",
        **NON_NEGATIVE,
        needs=on("play"),
        doc="factor a of the contact's damping; impacts part with about 1 - 2/3 a v",
    )
    young_modulus: Number = number(71.7e9, "Pa", **POSITIVE, needs=on("play"), doc="Young's modulus of pin and bush")
    poisson_ratio: Number = number(
        0.3, "-", low=-1.0, high=0.5, low_open=True, needs=on("play"), doc="Poisson's ratio of pin and bush"
    )

    def check_together(self) -> None:
        if self.has("play"):
            check_entries("hinge.play", self.play, "m", 0.0, self.bush_radius, too_high="; below hinge.bush_radius")

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        if self.has("play"):
            yield inside(self.play, high=self.bush_radius, high_open=True, **POSITIVE)

    @property
    def pin_radius(self) -> Scalar:
        """Return the pin's radius [m], the bush's less the play."""
        return self.bush_radius - (self.play if self.has("play") else 0.0)


class HingePlayPart(ProbePart):
    """The play of the hinge."""

    def elements(self, joined: Joined) -> tuple[Element, ...]:
        return (pin_in_bush(joined.design),)


def pin_in_bush(design: Any) -> Pin:
    """Return the hinge's pin, on the active vehicle, in a bush with play on the cylinder (M109)."""
    hinge = design.hinge
    # Pin and bush have no friction (M109): the slip speed means nothing.
    pair = BallPair(
        hinge.pin_radius, Hole(0.0, 0.0, hinge.bush_radius), jnp.ones(1), pin_law(design), RegularisedCoulomb(0.0, 1.0)
    )
    pin, bush = (design.active.hinge_offset, 0.0), (design.buffer.cylinder_length / 2, 0.0)
    return Pin(BallContact(S, B, pair, pin, bush))


def pin_law(design: Any) -> DampedHertz:
    """Return the law of the pin's contact: a ball in a socket."""
    hinge = design.hinge
    modulus, ratio = hinge.young_modulus, hinge.poisson_ratio
    stiffness = socket_stiffness(hinge.pin_radius, hinge.bush_radius, modulus, ratio, modulus, ratio)
    return DampedHertz(stiffness, hinge.damping)


HINGE_PLAY = HingePlayPart(
    name="hinge",
    path="hinge.play",
    quantities={"play_loss": Quantity("J", lambda c: c.energy.hinge_play, "energy lost in the play of the hinge")},
    recorded={"hinge_gap": "m"},
)
