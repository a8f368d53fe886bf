"""A pin with play in a bush of another body (M109)."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar
from ..multibody import Kinematics, Load, System
from .ball_contact import BallContact, BallState, ContactForces
from .element import Closed, Element, Own, Switch
from .stiff_terms import ContactTerm


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

    @property
    def switches(self) -> tuple[Switch, ...]:
        return (Switch(self.name),)

    @property
    def jumps(self) -> bool:
        return self.contact.pair.law.jumps

    def evaluate(self, kin: Kinematics, own: Own) -> BallState:
        return self.contact.evaluate(kin)

    def gaps(self, at: BallState) -> list[tuple[Scalar, Scalar]]:
        return [(at.approach.gap[0], at.approach.approach_speed[0])]

    def force(self, at: BallState, closed: Closed) -> Float[Array, " 1"]:
        """Return the force of the bush on the pin [N]."""
        # The law has no memory: the one that it is given means nothing.
        return closed * self.contact.pair.normal_force(at.approach, jnp.ones(1))

    def loads(self, at: BallState, closed: Closed) -> tuple[Load, ...]:
        return self.contact.loads(at, ContactForces(self.force(at, closed), jnp.zeros(1)))

    def stored(self, at: BallState, closed: Closed) -> dict[str, Scalar]:
        return {self.stored_in: self.contact.stored(at, closed)}

    @property
    def loss_names(self) -> tuple[str, ...]:
        return (self.lost_in,)

    def losses(self, at: BallState, closed: Closed) -> dict[str, Scalar]:
        power = self.contact.pair.hysteresis_power(at.approach, self.force(at, closed))
        return {self.lost_in: jnp.sum(closed * power)}

    def recorded(self, at: BallState, closed: Closed) -> dict[str, Scalar]:
        return {f"{self.stored_in}_gap": at.approach.gap[0]}

    def contact_term(self, system: System, at: BallState, closed: Closed) -> ContactTerm:
        return self.contact.term(system, at, jnp.ones(1), closed)

    def stiff_force(self, at: BallState, closed: Closed) -> Scalar:
        return self.force(at, closed)[0]

    @property
    def sudden(self) -> bool:
        return True  # where the pin bounces, the reaction rises from nothing within a step
