"""What is observed of a docking in space beside the elements' own observables."""

from collections.abc import Callable

import jax.numpy as jnp
from jaxtyping import Array

from ..._types import Scalar
from ..assembled import Assembled, Observable
from ..layout import EvaluatedState
from ..probe_cone.bodies import TIP
from ..probe_cone.observables import HINGE_FORCE, history_of_parts, observables_of_parts, rounded_length
from .design import Design3D, Scenario3D

HINGE = "hinge spring"  # name of the element of both springs and dampers of the cross


def _hinge(which: int) -> Callable[[Assembled, EvaluatedState, Array], Scalar]:
    """Return α or β of the universal joint [rad]."""
    return lambda mechanism, at, rate: mechanism.element(HINGE).force.state(at.kin).angles[which]


def _hinge_angle(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return √(α² + β²) of the universal joint [rad]."""
    alpha, beta = mechanism.element(HINGE).force.state(at.kin).angles
    return jnp.sqrt(alpha**2 + beta**2 + 1e-30)


def _in_cone(axis: str) -> Callable[[Assembled, EvaluatedState, Array], Scalar]:
    """Return y or z of the tip's centre in the axes of the passive vehicle [m]."""
    return lambda mechanism, at, rate: getattr(mechanism.evaluated(at, "throat").tip, axis)


def _tip_spin(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return how fast the tip spins [rad/s]."""
    spin = mechanism.evaluated(at, TIP).spin
    return jnp.sqrt(spin.dot(spin) + 1e-30)


HINGE_ANGLE = Observable("hinge_angle", _hinge_angle, roundoff=rounded_length)
RECORDED = (
    Observable("tip_spin", _tip_spin),
    Observable("hinge_alpha", _hinge(0)),
    Observable("hinge_beta", _hinge(1)),
    Observable("tip_y", _in_cone("y")),
    Observable("tip_z", _in_cone("z")),
)


def shown_of(design: Design3D, scenario: Scenario3D) -> tuple[Observable, ...]:
    """Return what is watched beside the elements' own observables."""
    return (HINGE_FORCE, HINGE_ANGLE, *observables_of_parts(design, scenario))


def recorded_of(design: Design3D) -> tuple[Observable, ...]:
    """Return what a history has besides."""
    return (*RECORDED, *history_of_parts(design))
