"""Momentum of rigid bodies, by hand."""

import jax.numpy as jnp
import numpy as np

from jaxbuffer.multibody import Body, Kinematics, System


def test_momentum_of_two_bodies():
    """Σ m v, and Σ m (x v_y - y v_x) + I ω about the origin."""
    mass, inertia = np.array([2.0, 0.5]), np.array([0.3, 7.0])
    q, v = np.array([[1.0, -2.0, 0.4], [0.3, 5.0, -1.0]]), np.array([[0.7, 0.2, -3.0], [-1.1, 0.9, 0.25]])
    system = System(tuple(Body(m, i) for m, i in zip(mass, inertia, strict=True)), (), ())
    kin = Kinematics(jnp.asarray(q.ravel()), jnp.asarray(v.ravel()))
    np.testing.assert_allclose(system.linear_momentum(kin), mass @ v[:, :2], rtol=1e-14)
    expected = mass @ (q[:, 0] * v[:, 1] - q[:, 1] * v[:, 0]) + inertia @ v[:, 2]
    np.testing.assert_allclose(system.angular_momentum(kin), expected, rtol=1e-14)
