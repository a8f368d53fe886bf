"""Oscillators on the vehicles, which their shocks shake and which do not act back (M180).

They stand for equipment. What one feels is the largest absolute acceleration of its mass until the run ends.
"""

from collections.abc import Mapping
from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..._types import Scalar, stacked
from ...fields import POSITIVE, Number, Part, number, on
from ...hybrid import Followers
from ...multibody import Kinematics

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
        """The frequencies that are set [Hz], by the names of their quantities."""
        slots = [(vehicle, k + 1) for vehicle in VEHICLES for k in range(SLOTS)]
        known = {f"{vehicle}_shock_{slot}": getattr(self, f"{vehicle}_{slot}") for vehicle, slot in slots}
        return {name: frequency for name, frequency in known.items() if frequency is not None}


class Oscillators(eqx.Module):
    """All oscillators of a design, each swinging in any direction of the plane.

    Their states are the deflections (x, y) of one after the other [m], then their absolute velocities [m/s].

    - ``bodies``: which body carries each.
    - ``rates``: ω of each, twice, for both axes [rad/s].
    - ``damping``: ζ [-].
    """

    bodies: tuple[int, ...] = eqx.field(static=True)
    rates: Float[Array, " axes"]
    damping: Scalar

    def __init__(self, shock: Shock, vehicles: Mapping[str, int]):
        self.bodies = tuple(vehicles[name.partition("_")[0]] for name in shock.frequencies)
        self.rates = 2.0 * jnp.pi * stacked([f for f in shock.frequencies.values() for _ in range(2)])
        self.damping = shock.damping

    @property
    def axes(self) -> int:
        """Number of deflections; as many velocities follow."""
        return 2 * len(self.bodies)

    def base(self, kin: Kinematics) -> Float[Array, " axes"]:
        """Return the velocities of what carries them, the vehicles' centres of mass [m/s]."""
        return jnp.concatenate([jnp.zeros(0), *(kin.v[3 * body : 3 * body + 2] for body in self.bodies)])

    def start(self, kin: Kinematics) -> Float[Array, " states"]:
        """Return their states at rest on the vehicles."""
        return jnp.concatenate([jnp.zeros(self.axes), self.base(kin)])

    def acceleration(self, kin: Kinematics, states: Float[Array, " states"]) -> Float[Array, " axes"]:
        """Return their absolute accelerations [m/s²] (M180)."""
        deflection, velocity = states[: self.axes], states[self.axes :]
        relative = velocity - self.base(kin)
        return -self.rates * (2.0 * self.damping * relative + self.rates * deflection)

    def derivative(self, kin: Kinematics, states: Float[Array, " states"]) -> Float[Array, " states"]:
        """Return the rates of their states."""
        return jnp.concatenate([states[self.axes :] - self.base(kin), self.acceleration(kin, states)])

    def sizes(self, kin: Kinematics, states: Float[Array, " states"]) -> list[Scalar]:
        """Return the size of each one's absolute acceleration [m/s²]."""
        of = self.acceleration(kin, states)
        return [jnp.sqrt(of[k] ** 2 + of[k + 1] ** 2 + 1e-24) for k in range(0, self.axes, 2)]

    def scales(self, speed: Scalar) -> Float[Array, " states"]:
        """Return the magnitudes of their states where the vehicles' velocities change by about ``speed`` [m/s]."""
        return jnp.concatenate([speed / self.rates, jnp.full(self.axes, speed)])

    def followers(self, first: int) -> Followers:
        """Return them for implicit steps. ``first``: of their states, counted from the end of the velocities."""
        shaken_by = tuple(3 * body + axis for body in self.bodies for axis in range(2))
        return Followers(first, shaken_by, self.rates, self.damping)
