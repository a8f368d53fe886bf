"""Which shocks on the vehicles' equipment are wanted (M180)."""

from typing import ClassVar

from ..._types import Scalar
from ...fields import POSITIVE, Number, Part, number, on

VEHICLES = ("active", "passive")
SLOTS = 3  # frequencies of each vehicle
SLOT_NAMES = tuple(f"{vehicle}_{k + 1}" for vehicle in VEHICLES for k in range(SLOTS))


def _frequency(vehicle: str) -> Number:
    return number(None, "Hz", **POSITIVE, doc=f"frequency of an oscillator on the {vehicle} vehicle; not set: none")


class Shock(Part):
    """Frequencies at which the shock on a vehicle's equipment is wanted: the quantities ``active_shock_1`` and so on.

    - ``active_1``, ``active_2``, ``active_3``: of oscillators on the active vehicle [Hz]; None: none.
    - ``passive_1``, ``passive_2``, ``passive_3``: on the passive one [Hz].
    - ``damping``: ζ of all of them, the share of the critical one [-].
    """

    section: ClassVar[str] = "shock"
    active_1: Number = _frequency("active")
    active_2: Number = _frequency("active")
    active_3: Number = _frequency("active")
    passive_1: Number = _frequency("passive")
    passive_2: Number = _frequency("passive")
    passive_3: Number = _frequency("passive")
    damping: Number = number(
        0.05, "-", low=0.0, high=1.0, high_open=True, needs=on(*SLOT_NAMES), doc="damping ratio of the oscillators"
    )

    @property
    def frequencies(self) -> dict[str, Scalar]:
        """Return the frequencies that are set [Hz], by the names of their quantities."""
        slots = [(vehicle, k + 1) for vehicle in VEHICLES for k in range(SLOTS)]
        return {
            f"{vehicle}_shock_{slot}": getattr(self, f"{vehicle}_{slot}")
            for vehicle, slot in slots
            if self.has(f"{vehicle}_{slot}")
        }
