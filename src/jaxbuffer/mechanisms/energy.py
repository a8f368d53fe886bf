"""The energies of a run, and what numerical error did to what the motion conserves."""

from typing import Any

import numpy as np
from jaxtyping import Array, Float

from ..fields import Portable, numbers_text
from ..value_text import unit_by_size, with_unit

MUCH = 0.01  # of the energy, beyond which a run says that it is off


class Energy(Portable):
    """The energies at one instant or, with an axis, along a history.

    ``stored`` [J] by name, such as "kinetic", "spring", "contact"; ``lost`` [J] so far by name, such as "friction".
    Each is an attribute of its own too: ``energy.kinetic``.
    """

    stored: dict[str, Float[Array, "..."]]
    lost: dict[str, Float[Array, "..."]]

    def __getattr__(self, name: str) -> Any:
        for part in ("stored", "lost"):
            # An object without fields yet, as one that is being unpickled, would call this method for ever by
            # `self.stored`.
            energies = object.__getattribute__(self, part)
            if name in energies:
                return energies[name]
        raise AttributeError(f"{type(self).__name__} has no {name!r}")

    def __repr__(self) -> str:
        parts = {**self.stored, **{f"lost by {name}": value for name, value in self.lost.items()}, "total": self.total}
        return numbers_text("Energies", {name: (value, "J", 1.0) for name, value in parts.items()})

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of all energies, and "total"."""
        return (*self.stored, *self.lost, "total")

    @property
    def dissipated(self) -> Float[Array, "..."]:
        """Return the energy lost so far [J]."""
        return _sum(self.lost)

    @property
    def total(self) -> Float[Array, "..."]:
        """Return stored and lost energy together [J]: constant in time."""
        return _sum(self.stored) + _sum(self.lost)

    @property
    def size(self) -> Float[Array, "..."]:
        """Return the sum of the energies' magnitudes [J], of which rounding errors are a share."""
        return _sum({name: abs(energy) for name, energy in {**self.stored, **self.lost}.items()})


def _sum(energies: dict[str, Float[Array, "..."]]) -> Any:
    """Return the sum of energies; that of NumPy's arrays is one, so that nothing is compiled to print a run."""
    return sum(energies.values(), start=np.zeros(()))


class Balance(Portable):
    """What should not change, and by how much it did over the run. These numbers have no derivatives.

    ``energy`` [-]: change of the total over the initial energy (or the system's scale, if that is larger);
    ``linear_momentum``, ``angular_momentum`` [-]: change over the system's momentum, the latter's at an arm of 1 m (NaN
    where the ground takes part); ``drift`` [m, rad]: largest error of a constraint at any located event.
    """

    energy: Float[Array, ""]
    linear_momentum: Float[Array, ""]
    angular_momentum: Float[Array, ""]
    drift: Float[Array, ""]

    @property
    def warnings(self) -> list[str]:
        """Return a line where energy is off so far that nothing else of a solved run can be right."""
        off = abs(float(self.energy))
        if not off > MUCH:
            return []
        return [
            f"energy is off by {off:.2g} times what there is: no number of this run can be trusted; try a smaller rtol,"
            " and look whether a part passes where the model ends, such as behind a flank"
        ]

    def __repr__(self) -> str:
        units = {"drift": "m or rad"}
        return numbers_text(
            "What numerical error did to what is conserved, relative but for the drift",
            {name: (value, units.get(name, "-"), 1.0) for name, value in vars(self).items()},
        )


ENERGY_UNITS = (("kJ", 1e-3), ("J", 1.0), ("mJ", 1e3), ("µJ", 1e6))


def energy_unit(largest: Any) -> tuple[str, float]:
    """Return the unit in which energies up to ``largest`` [J] are read best, and how many of it a joule is."""
    return unit_by_size(float(largest), ENERGY_UNITS, 1.0)


def energy_text(energy: Any) -> str:
    """Return an energy [J] in words: "4.495 J", "1.43 kJ"."""
    unit, many = energy_unit(energy)
    return with_unit(many * float(energy), unit, 4)
