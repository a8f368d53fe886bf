"""Which shocks on the vehicles' equipment are wanted (M180)."""

from typing import Any, ClassVar

import jax
import numpy as np

from ...._types import Scalar
from ....elements import Element, Oscillators
from ....fields import POSITIVE, Number, Part, number, on
from ...quantity import Quantity
from .part import Joined, ProbePart, S, T

VEHICLES = ("active", "passive")
SLOTS = 3  # frequencies of each vehicle
SLOT_NAMES = tuple(f"{vehicle}_{k + 1}" for vehicle in VEHICLES for k in range(SLOTS))


def _frequency(vehicle: str) -> Number:
    return number(None, "Hz", **POSITIVE, doc=f"frequency of an oscillator on the {vehicle} vehicle; not set: none")


class Shock(Part):
    """Frequencies at which the shock on a vehicle's equipment is wanted: the quantities ``active_shock_1`` and so on.

    - ``active_1``, ``active_2``, ``active_3``: of oscillators on the active vehicle [Hz]; None: none.
    - ``passive_1``, ``passive_2``, ``passive_3``: on the passive one [Hz].
    """

    section: ClassVar[str] = "shock"
    active_1: Number = _frequency("active")
    active_2: Number = _frequency("active")
    active_3: Number = _frequency("active")
    passive_1: Number = _frequency("passive")
    passive_2: Number = _frequency("passive")
    passive_3: Number = _frequency("passive")
    damping: Number = number(
        0.05,
        "-",
        low=0.0,
        high=1.0,
        high_open=True,
        needs=on(*SLOT_NAMES),
        doc="damping ratio ζ of the oscillators, the share of the critical one",
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


def _shock(vehicle: str, slot: int) -> Quantity:
    """Return the shock at one of the frequencies that a design names, as a quantity."""
    name, field = f"{vehicle}_shock_{slot}", f"shock.{vehicle}_{slot}"
    return Quantity(
        "m/s²",
        # Put on the device where there is none: any operation would be a program of its own.
        lambda capture: capture.maxima.get(name, jax.device_put(np.full(np.shape(capture.end_time), np.nan))),
        f"largest absolute acceleration, in any direction, of an oscillator of {field} on the {vehicle} vehicle",
        f"shock on the {vehicle} vehicle at {field}",
        swept=True,
        tuned=True,
        part=field,
    )


class ShockPart(ProbePart):
    """The oscillators on the vehicles."""

    def present(self, design: Any, scenario: Any = None) -> bool:
        """Return whether any frequency is set."""
        return hasattr(design, "shock") and bool(design.shock.frequencies)

    def elements(self, joined: Joined) -> tuple[Element, ...]:
        shock, carriers = joined.design.shock, {"active": S, "passive": T}
        names = tuple(shock.frequencies)
        bodies = tuple(carriers[name.partition("_")[0]] for name in names)
        return (Oscillators(bodies, tuple(shock.frequencies.values()), names, shock.damping),)


OF_SHOCK = {f"{vehicle}_shock_{k + 1}": _shock(vehicle, k + 1) for vehicle in VEHICLES for k in range(SLOTS)}
SHOCK = ShockPart(name="oscillators", path="", quantities=OF_SHOCK, recorded=dict.fromkeys(OF_SHOCK, "m/s²"))
