"""A force and a moment from outside on a body, in the plane and in space, against the textbook."""

import equinox as eqx
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from jaxbuffer.elements import Wrench
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.multibody import Body, System
from jaxbuffer.plane import PLANE
from jaxbuffer.space import SPACE

MASS, ANGLE = 2.0, 0.3


@eqx.filter_jit
def rates(basis, inertia, q, v, wrench):
    """Acceleration, power, and the rates of impulse and angular impulse that the element has."""
    system = System((Body(MASS, inertia),), stabilisation=0.0, basis=basis)
    mechanism = Assembled(system, q, v, (wrench,), momentum_size=1.0, energy_size=1.0)
    state, active = mechanism.start()
    rate = mechanism.derivative(0.0, state, active)
    return rate[mechanism.places["v"]], rate[mechanism.places["element 0"]]


@pytest.mark.parametrize("turning", [False, True])
def test_a_force_and_a_moment_in_the_plane(turning):
    place, speed, spin, inertia = np.array([0.7, -0.4]), np.array([0.2, 0.5]), -1.3, 0.4
    wrench = Wrench(0, (3.0, -1.0), (0.8,), turning)
    moved, own = rates(PLANE, inertia, np.array([*place, ANGLE]), np.array([*speed, spin]), wrench)
    turn = np.array([[np.cos(ANGLE), -np.sin(ANGLE)], [np.sin(ANGLE), np.cos(ANGLE)]])
    force = turn @ [3.0, -1.0] if turning else np.array([3.0, -1.0])
    assert_allclose(moved, [*(force / MASS), 0.8 / inertia], rtol=1e-13)
    about = place[0] * force[1] - place[1] * force[0] + 0.8
    assert_allclose(own, [force @ speed + 0.8 * spin, *force, about], rtol=1e-13)


@pytest.mark.parametrize("turning", [False, True])
def test_a_force_and_a_moment_in_space(turning):
    place, speed, spin = np.array([0.7, -0.4, 1.1]), np.array([0.2, 0.5, -0.1]), np.array([0.3, -0.2, 0.6])
    inertia, force, moment = np.array([0.4, 0.7, 0.5]), np.array([3.0, -1.0, 0.5]), np.array([0.8, 0.1, -0.3])
    turn = Rotation.from_rotvec(ANGLE * np.array([0.48, -0.6, 0.64]))
    wrench = Wrench(0, tuple(force), tuple(moment), turning)
    q, v = np.array([*place, *turn.as_quat(scalar_first=True)]), np.array([*speed, *spin])
    moved, own = rates(SPACE, tuple(inertia), q, v, wrench)
    if turning:
        force, moment = turn.apply(force), turn.apply(moment)
    tensor = turn.as_matrix() @ np.diag(inertia) @ turn.as_matrix().T
    turned = np.linalg.solve(tensor, moment - np.cross(spin, tensor @ spin))  # Euler's equations
    assert_allclose(moved, [*(force / MASS), *turned], rtol=1e-12)
    assert_allclose(own, [force @ speed + moment @ spin, *force, *(np.cross(place, force) + moment)], rtol=1e-12)
