"""Sensors and integrals: quantities of the motion that are watched, shown in a history, or summed up over time."""

import inspect
import math
from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array

from .._types import Scalar
from ..errors import InputError
from ..multibody import Kinematics
from .ball_contact import BallContact
from .element import Closed, Element, Magnitudes, Own


class Sensor(Element):
    """A quantity of the motion whose largest value is wanted, and which a history shows.

    - ``of``: its value, called as ``of(kin, numbers)`` with the bodies' `Kinematics`; of a sensor ``of_acceleration``
      as ``of(kin, acceleration, numbers)`` with the accelerations q̈. A function that a module defines: programs are
      compiled for it.
    - ``numbers``: arrays, or parts of the mechanism, that the function needs; what a derivative may be taken by belongs
      here.
    - ``of_acceleration``: whether it depends on the accelerations.
    - ``watched``: whether its largest value is wanted; if not, a history alone shows it.
    - ``least``: what the largest value is at least, as a depth is 0 where nothing touches.
    - ``rounding``: the value that is rounding where nothing acts; None if every value counts, also a negative one.
    - ``name``: of the quantity.
    """

    of: Callable[..., Scalar] = eqx.field(static=True)
    numbers: Any = None
    of_acceleration: bool = eqx.field(static=True, default=False)
    watched: bool = eqx.field(static=True, default=True)
    least: float = eqx.field(static=True, default=-math.inf)
    rounding: Scalar | None = None
    name: str = eqx.field(static=True, default="sensor")

    def __check_init__(self) -> None:
        """Raise `InputError` for a function that cannot be called as this sensor calls it."""
        if self.of_acceleration and not self.watched:
            raise InputError(f"{self.name}: a sensor of_acceleration cannot be watched=False: a history alone has none")
        check_call(self.name, self.of, *(("kin", "acceleration") if self.of_acceleration else ("kin",)), "numbers")

    @property
    def observed(self) -> tuple[str, ...]:
        return (self.name,) if self.watched and not self.of_acceleration else ()

    @property
    def observed_of_rate(self) -> tuple[str, ...]:
        return (self.name,) if self.watched and self.of_acceleration else ()

    def observables(self, at: Kinematics, closed: Closed) -> dict[str, Scalar]:
        return {name: self.of(at, self.numbers) for name in self.observed}

    def observables_of_rate(self, at: Kinematics, acceleration: Array, own_rate: Own) -> dict[str, Scalar]:
        return {name: self.of(at, acceleration, self.numbers) for name in self.observed_of_rate}

    def recorded(self, at: Kinematics, closed: Closed) -> dict[str, Scalar]:
        return {} if self.watched else {self.name: self.of(at, self.numbers)}

    @property
    def lower_bounds(self) -> dict[str, float]:
        return {self.name: self.least} if self.watched else {}

    def roundoff(self) -> dict[str, Scalar]:
        return {self.name: -jnp.inf if self.rounding is None else self.rounding}


class Integral(Element):
    """The integral over time of a quantity of the motion, zero at t = 0.

    - ``of``: the quantity that is integrated, from the bodies' `Kinematics` and ``numbers``, as of a `Sensor`.
    - ``numbers``: as of a `Sensor`.
    - ``scale``: the integral's magnitude below which an error does not matter.
    - ``watched``: whether its largest value is wanted, which is the last one where the quantity is never negative.
    - ``name``: of the integral.
    """

    of: Callable[..., Scalar] = eqx.field(static=True)
    numbers: Any = None
    scale: Scalar = 1.0
    watched: bool = eqx.field(static=True, default=True)
    name: str = eqx.field(static=True, default="integral")

    def __check_init__(self) -> None:
        """Raise `InputError` for a function that cannot be called as this integral calls it."""
        check_call(self.name, self.of, "kin", "numbers")

    @property
    def variables(self) -> tuple[str, ...]:
        return ("integral",)

    def scales(self, size: Magnitudes) -> list[Scalar]:
        return [self.scale]

    def evaluate(self, kin: Kinematics, own: Own) -> tuple[Kinematics, Scalar]:
        return kin, own[0]

    def rates(self, at: tuple[Kinematics, Scalar], closed: Closed) -> list[Scalar]:
        return [self.of(at[0], self.numbers)]

    @property
    def observed(self) -> tuple[str, ...]:
        return (self.name,) if self.watched else ()

    def observables(self, at: tuple[Kinematics, Scalar], closed: Closed) -> dict[str, Scalar]:
        return {name: at[1] for name in self.observed}


def check_call(element: str, function: Callable[..., Scalar], *arguments: str) -> None:
    """Check that an element's function takes as many positional arguments as it is called with.

    **Arguments:** ``element``: its name; ``arguments``: what they are called.

    **Raises:** `InputError` that says how the function is called.
    """
    name = getattr(function, "__name__", repr(function))
    if not callable(function):
        raise InputError(f"{element}: of = {name} is no function; it is called as of({', '.join(arguments)})")
    try:
        inspect.signature(function).bind(*arguments)
    except TypeError:
        given = f"{name}{inspect.signature(function)}"
        raise InputError(f"{element}: of = {given} is called as {name}({', '.join(arguments)})") from None
    except ValueError:  # a built-in function, which has no signature that could be looked at
        return


def deepest(kin: Kinematics, contacts: tuple[BallContact, ...]) -> Scalar:
    """Return the depth of the deepest of some contacts [m], negative where none touches: what a `Sensor` is of whose
    ``numbers`` are the contacts."""
    return -jnp.min(jnp.concatenate([contact.evaluate(kin).approach.gap for contact in contacts]))
