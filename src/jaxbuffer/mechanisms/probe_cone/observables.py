"""What is observed of a run beside the elements' own observables."""

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
from jaxtyping import Array

from ..._types import Scalar
from ...elements.element import ROUNDED_LENGTH
from ...plane import Vector
from ..assembled import Assembled, Observable
from ..layout import EvaluatedState
from .bodies import TIP, B, S, T
from .design import Design, Scenario
from .parts import PARTS, holder_of, parts_of

ROUNDED_ACCELERATION = 1e-12  # m/s²: what rounding of positions of a metre makes of it by the constraints' correction


def hinge_force(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return the size of the force that accelerates the active vehicle [N] (M68)."""
    # The vehicle's acceleration tells the force also where the hinge has play, and so no multipliers (M68).
    return _size_of(mechanism.acceleration(rate, S) * mechanism.parts.design.active.mass)


def passive_force(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return the size of the force on the passive vehicle [N]."""
    return _size_of(mechanism.acceleration(rate, T) * mechanism.parts.design.passive.mass)


def _size_of(force: Vector) -> Scalar:
    """Return a force's size, with a derivative also where it is zero."""
    return jnp.sqrt(force.dot(force) + 1e-24)


def hinge_angle(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return the cylinder's angle against the active vehicle [rad]."""
    return at.kin.frame(B).angle - at.kin.frame(S).angle


def _rounded_force(vehicle: str) -> Callable[[Assembled], Scalar]:
    """Return what of the force on a vehicle is rounding, in the spring's force and by the constraints' correction."""

    def of(mechanism: Assembled) -> Scalar:
        mass = getattr(mechanism.parts.design, vehicle).mass
        return ROUNDED_LENGTH * mechanism.element("buffer").stiffness_at_rest + ROUNDED_ACCELERATION * mass

    return of


def rounded_length(mechanism: Assembled) -> Scalar:
    """Return what of a length or an angle is rounding [m, rad]."""
    return ROUNDED_LENGTH


HINGE_FORCE = Observable("hinge_force", hinge_force, of_rate=True, roundoff=_rounded_force("active"))
PASSIVE_FORCE = Observable("passive_force", passive_force, of_rate=True, roundoff=_rounded_force("passive"))
HINGE_ANGLE = Observable("hinge_angle", lambda *at: jnp.abs(hinge_angle(*at)), roundoff=rounded_length)


def observables_of(design: Design, scenario: Scenario) -> tuple[Observable, ...]:
    """Return what is observed of a run beside the elements' own observables."""
    return (HINGE_FORCE, HINGE_ANGLE, *observables_of_parts(design, scenario))


def observables_of_parts(design: Any, scenario: Any) -> tuple[Observable, ...]:
    """Return what is observed of the optional parts, and of the passive vehicle where more than the tip acts on it."""
    of_parts = (observable for part in parts_of(design, scenario) for observable in part.observables(design))
    # Where nothing holds the tip, and from the touch, nothing but the tip acts on the passive vehicle.
    acted_on = holder_of(design) is not None or scenario.start == "free"
    return (*of_parts, *((PASSIVE_FORCE,) if acted_on else ()))


def recorded_of(design: Design) -> tuple[Observable, ...]:
    """Return what a history shows besides; that of which the largest size is observed has its sign there."""
    own = (
        Observable("tip_spin", lambda mechanism, at, rate: mechanism.evaluated(at, TIP).spin),
        Observable("hinge_angle", hinge_angle),
    )
    return (*own, *history_of_parts(design))


def history_of_parts(design: Any) -> tuple[Observable, ...]:
    """Return what a history shows of the optional parts."""
    return tuple(observable for part in PARTS for observable in part.history(design))
