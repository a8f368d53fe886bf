"""Oscillators on bodies, which their motion shakes and which do not act back (M180).

They stand for equipment. What one feels is the largest absolute acceleration of its mass until the run ends.
"""

import dataclasses
from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from ..basis import AnyBasis
from ..errors import InputError
from ..hybrid import PassiveOscillators
from ..multibody import Coordinates, Kinematics
from ..plane import PLANE
from .element import ROUNDED_LENGTH, Closed, Element, Magnitudes, Own
from .report import Report
from .telling import largest


class OscillatorState(NamedTuple):
    """All oscillators at one instant, an entry for each and each axis there is.

    - ``deflection``: [m].
    - ``velocity``: absolute velocity of the mass [m/s].
    - ``base``: velocity of what carries it [m/s].
    """

    deflection: Float[Array, " axes"]
    velocity: Float[Array, " axes"]
    base: Float[Array, " axes"]


class Oscillators(Element):
    """Oscillators on the centres of mass of bodies, each swinging in any direction of the plane, or of space.

    - ``bodies``: which body carries each.
    - ``frequencies``: of each [Hz].
    - ``names``: of each, as the quantity that is watched.
    - ``damping``: ζ of all, the share of the critical one [-].
    - ``basis``: of the mechanism, which says it.
    """

    bodies: tuple[int, ...] = eqx.field(static=True)
    frequencies: tuple[Scalar, ...]
    names: tuple[str, ...] = eqx.field(static=True)
    damping: Scalar = 0.05
    basis: AnyBasis = PLANE
    name: str = eqx.field(static=True, default="oscillators")

    def __check_init__(self) -> None:
        """Raise `InputError` where an oscillator has no body that can move."""
        if any(body < 0 for body in self.bodies):
            raise InputError("an oscillator is on the ground, which does not move: name a body that does")

    def in_mechanism(self, speed: Scalar, basis: AnyBasis) -> "Oscillators":
        return dataclasses.replace(self, basis=basis)

    @property
    def rates_of_axes(self) -> Float[Array, " axes"]:
        """Return ω of each oscillator, once for each axis [rad/s]."""
        return 2.0 * jnp.pi * stacked([it for it in self.frequencies for _ in range(self.basis.dimensions)])

    @property
    def axes(self) -> int:
        """Return the number of deflections; as many velocities follow."""
        return self.basis.dimensions * len(self.bodies)

    @property
    def variables(self) -> tuple[str, ...]:
        axes = [f"{name}_{axis}" for name in self.names for axis in "xyz"[: self.basis.dimensions]]
        return (*(f"{it}_deflection" for it in axes), *(f"{it}_velocity" for it in axes))

    def start(self, kin: Kinematics) -> Own:
        # At t = 0 an oscillator is at rest on its body (M180).
        return jnp.concatenate([jnp.zeros(self.axes), self._base(kin)])

    def scales(self, size: Magnitudes) -> list[Scalar]:
        # A base whose speed jumps by v deflects an oscillator by v/ω.
        return [*(size.speed / self.rates_of_axes), *[size.speed] * self.axes]

    def _base(self, kin: Kinematics) -> Float[Array, " axes"]:
        return stacked([speed for body in self.bodies for speed in kin.frame(body).velocity])

    def evaluate(self, kin: Kinematics, own: Own) -> OscillatorState:
        return OscillatorState(own[: self.axes], own[self.axes :], self._base(kin))

    def acceleration(self, at: OscillatorState) -> Float[Array, " axes"]:
        """Return the absolute accelerations of the masses [m/s²] (M180)."""
        rates = self.rates_of_axes
        return -rates * (2.0 * self.damping * (at.velocity - at.base) + rates * at.deflection)

    def rates(self, at: OscillatorState, closed: Closed) -> list[Scalar]:
        return [*(at.velocity - at.base), *self.acceleration(at)]

    @property
    def observed(self) -> tuple[str, ...]:
        return self.names

    def observables(self, at: OscillatorState, closed: Closed) -> dict[str, Scalar]:
        # The small number below the root keeps its slope finite where nothing moves.
        of, n = self.acceleration(at), self.basis.dimensions
        squares = [[of[k] ** 2 for k in range(first, first + n)] for first in range(0, self.axes, n)]
        sizes = [jnp.sqrt(sum(rest, start=first) + 1e-24) for first, *rest in squares]
        return dict(zip(self.names, sizes, strict=True))

    def roundoff(self) -> dict[str, Scalar]:
        sizes = ROUNDED_LENGTH * self.rates_of_axes[:: self.basis.dimensions] ** 2
        return dict(zip(self.names, sizes, strict=True))

    def followers(self, first: int, order: Coordinates) -> PassiveOscillators:
        shaken_by = tuple(column for body in self.bodies for column in order.columns(body)[: self.basis.dimensions])
        return PassiveOscillators(first, shaken_by, self.rates_of_axes, self.damping)

    @property
    def report(self) -> "OscillatorsReport":
        return OscillatorsReport(self)


class OscillatorsReport(Report[Oscillators]):
    """What is said and drawn of oscillators."""

    def summary(self, run: Any) -> list[tuple[str, str]]:
        oscillators = self.element
        felt = [
            f"{name.partition('_')[0]} {largest(run, name):.4g} m/s² at {float(frequency):.4g} Hz"
            for name, frequency in zip(oscillators.names, oscillators.frequencies, strict=True)
        ]
        return [("shock", ", ".join(felt))]
