"""Any force element of the multibody system as an element, with names of its own for its energies."""

import equinox as eqx

from .._types import Scalar
from ..multibody import ForceElement, Kinematics, Load, SpringDirection
from .element import Closed, Element


class SpringDamper(Element):
    """A spring-damper, or any other `ForceElement`, whose energies are listed by names of their own.

    - ``force``: such as `TorsionalSpringDamper`.
    - ``stored_in``, ``lost_in``: names of the energies that it stores and loses.
    """

    force: ForceElement
    stored_in: str = eqx.field(static=True, default="spring")
    lost_in: str = eqx.field(static=True, default="damper")
    name: str = eqx.field(static=True, default="spring")

    def loads(self, at: Kinematics, closed: Closed) -> tuple[Load, ...]:
        return self.force.loads(at)

    def stored(self, at: Kinematics, closed: Closed) -> dict[str, Scalar]:
        return {self.stored_in: self.force.energy(at)}

    @property
    def loss_names(self) -> tuple[str, ...]:
        return (self.lost_in,)

    def losses(self, at: Kinematics, closed: Closed) -> dict[str, Scalar]:
        return {self.lost_in: self.force.dissipation(at)}

    def springs(self, at: Kinematics, closed: Closed) -> tuple[SpringDirection, ...]:
        return self.force.springs(at)
