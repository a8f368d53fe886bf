"""A real buffer along the cylinder: preload, quadratic damping, rebound factor, friction and measured curves.

By the stroke s and its rate ṡ it pushes the probe out with F_s(s) + F_d(ṡ) + F_f tanh(ṡ/v_f) (M171 to M173).
"""

import jax
import jax.numpy as jnp

from ..._types import Scalar
from ...fields import MonotoneCubic
from ...multibody import AxialSpringDamper, Kinematics, Load, SpringDirection, load_at
from .buffer import Buffer


class BufferForce(AxialSpringDamper):
    """The axial element of a buffer that is more than a linear spring and damper; see `parts.Buffer` for its numbers.

    Its stroke is that of `AxialSpringDamper`: s = l_0 - L.
    """

    spring_curve: MonotoneCubic | None = None
    damper_curve: MonotoneCubic | None = None
    preload: Scalar | None = None
    preload_length: Scalar = 1e-4
    quadratic: Scalar | None = None
    rebound_factor: Scalar | None = None
    friction: Scalar | None = None
    friction_speed: Scalar = 1e-3

    def stroke(self, kin: Kinematics) -> tuple[Scalar, Scalar]:
        """Return s [m] and ṡ [m/s]."""
        at = self.state(kin)
        return self.free_length - at.length, -at.rate

    def spring_force(self, stroke: Scalar) -> Scalar:
        """Return F_s [N] (M171, M173)."""
        force = self.stiffness * stroke if self.spring_curve is None else self.spring_curve.value(stroke)
        if self.preload is not None:
            force = force + self.preload * stroke / jnp.sqrt(stroke**2 + self.preload_length**2)
        return force

    def spring_energy(self, stroke: Scalar) -> Scalar:
        """Return the energy stored in the spring [J], the integral of F_s."""
        curve = self.spring_curve
        energy = 0.5 * self.stiffness * stroke**2 if curve is None else curve.integral(stroke)
        if self.preload is not None:
            length = self.preload_length
            energy = energy + self.preload * (jnp.sqrt(stroke**2 + length**2) - length)
        return energy

    def damper_force(self, speed: Scalar) -> Scalar:
        """Return F_d [N] (M172, M173)."""
        size = jnp.where(speed < 0.0, -speed, speed)  # whose derivative at zero, unlike that of abs, is 1
        force = self.damping * size if self.damper_curve is None else self.damper_curve.value(size)
        if self.quadratic is not None:
            force = force + self.quadratic * size * size
        outwards = force if self.rebound_factor is None else self.rebound_factor * force
        return jnp.where(speed < 0.0, -outwards, force)

    def friction_force(self, speed: Scalar) -> Scalar:
        """Return F_f tanh(ṡ/v_f) [N] (M172)."""
        return 0.0 if self.friction is None else self.friction * jnp.tanh(speed / self.friction_speed)

    def friction_loss(self, kin: Kinematics) -> Scalar:
        """Return the power lost in friction [W]."""
        _, speed = self.stroke(kin)
        return self.friction_force(speed) * speed

    # --- as a force element -------------------------------------------------------------------------------------------

    def springs(self, kin: Kinematics) -> tuple[SpringDirection, ...]:
        direction = super().springs(kin)[0]
        stroke, speed = (jnp.asarray(x, float) for x in self.stroke(kin))
        one = jnp.ones(())
        stiffness = jax.jvp(lambda s: jnp.asarray(self.spring_force(s)), (stroke,), (one,))[1]
        dissipative = lambda v: jnp.asarray(self.damper_force(v) + self.friction_force(v))  # noqa: E731
        return (direction._replace(stiffness=stiffness, damping=jax.jvp(dissipative, (speed,), (one,))[1]),)

    def tension(self, kin: Kinematics) -> Scalar:
        stroke, speed = self.stroke(kin)
        return -(self.spring_force(stroke) + self.damper_force(speed) + self.friction_force(speed))

    def loads(self, kin: Kinematics) -> tuple[Load, ...]:
        at = self.state(kin)
        pull = at.along * self.tension(kin)
        return load_at(at.first, pull), load_at(at.second, -pull)

    def energy(self, kin: Kinematics) -> Scalar:
        return self.spring_energy(self.stroke(kin)[0])

    def dissipation(self, kin: Kinematics) -> Scalar:
        _, speed = self.stroke(kin)
        return self.damper_force(speed) * speed + self.friction_loss(kin)


def is_plain(buffer: Buffer) -> bool:
    """Whether a buffer is the paper's linear spring and damper."""
    more = (buffer.spring_curve, buffer.damper_curve, buffer.preload, buffer.c_A2, buffer.rebound_factor)
    return all(part is None for part in (*more, buffer.friction))
