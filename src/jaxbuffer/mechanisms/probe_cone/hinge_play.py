"""Play in the hinge: a pin on the active vehicle in a bush on the cylinder (M109)."""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar
from ...contact import Approach, BallPair, Hole, RegularisedCoulomb, socket_stiffness
from ...contact.laws import DampedHertz
from ...multibody import Kinematics, Load, MaterialPoint, System
from ..ball_contact import BallContact
from ..linearisation import ContactTerm, contact_directions, contact_slopes
from .assembly import B, S
from .design import Design


class PinPosture(NamedTuple):
    """The pin in its bush: geometry and relative motion, an entry long; the pin's centre and the bush's."""

    approach: Approach
    centre: MaterialPoint
    origin: MaterialPoint


class HingePlay(eqx.Module):
    """A hinge with play; ``closed``: 1 while the pin touches the bush, 0 while it does not."""

    contact: BallContact

    def __init__(self, design: Design):
        hinge = design.hinge
        pair = BallPair(
            hinge.pin_radius,
            Hole(0.0, 0.0, hinge.bush_radius),
            jnp.ones(1),
            pin_law(design),
            RegularisedCoulomb(0.0, 1.0),
        )
        pin, bush = (design.active.hinge_offset, 0.0), (design.buffer.cylinder_length / 2, 0.0)
        self.contact = BallContact(S, B, pair, pin, bush)

    def posture(self, kin: Kinematics) -> PinPosture:
        """Where the pin is in its bush."""
        return PinPosture(*self.contact.approach(kin))

    def force(self, at: PinPosture, closed: Scalar) -> Float[Array, " 1"]:
        """(1,) F of the bush on the pin [N]."""
        return closed * self.contact.pair.normal_force(at.approach, jnp.ones(1))

    def loads(self, at: PinPosture, closed: Scalar) -> tuple[Load, ...]:
        """On pin and bush."""
        return self.contact.loads(*at, self.force(at, closed), jnp.zeros(1))

    def stored(self, at: PinPosture, closed: Scalar) -> Scalar:
        """Energy stored in the contact [J]."""
        return jnp.sum(closed * self.contact.pair.stored_energy(at.approach))

    def loss(self, at: PinPosture, closed: Scalar) -> Scalar:
        """Power lost in the contact [W]."""
        return jnp.sum(closed * self.contact.pair.hysteresis_power(at.approach, self.force(at, closed)))

    def term(self, system: System, at: PinPosture, closed: Scalar, spins: int) -> ContactTerm:
        """Its share of the linearisation; ``spins``: how many velocities follow the coordinates'."""
        columns = contact_directions(system, at.approach, jnp.ones(1), at.centre, at.origin)
        normals, tangents = (jnp.pad(column, ((0, spins), (0, 0))) for column in columns)
        slopes = contact_slopes(self.contact.pair, at.approach, jnp.ones(1), jnp.reshape(closed, (1,)))
        return ContactTerm(normals, tangents, *slopes)


def pin_law(design: Design) -> DampedHertz:
    """The law of the pin's contact: a ball in a socket."""
    hinge = design.hinge
    modulus, ratio = hinge.young_modulus, hinge.poisson_ratio
    stiffness = socket_stiffness(hinge.pin_radius, hinge.bush_radius, modulus, ratio, modulus, ratio)
    return DampedHertz(stiffness, hinge.damping)
