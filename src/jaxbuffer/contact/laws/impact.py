"""Two free bodies colliding under a law alone: m δ̈ = -F from touchdown to separation, integrated by SciPy.

For laws without a closed form, and for force-penetration loops.
"""

from typing import NamedTuple, Protocol

import jax
import jax.numpy as jnp
import numpy as np

from ..._types import Scalar, Values


class ForceLaw(Protocol):
    """What an impact needs of a contact law; see `ContactLaw`."""

    def force(self, penetration: Values, approach_speed: Values, touchdown_speed: Values) -> Values: ...
    def time_scale(self, mass: Scalar, speed: Scalar) -> Scalar: ...


class FreeImpact(NamedTuple):
    """An impact of two free bodies, and its course at a number of points.

    - ``restitution``: speed of separation over speed of approach [-].
    - ``max_penetration``: [m].
    - ``peak_force``: [N].
    - ``duration``: [s].
    - ``time``: (points,) since touchdown [s].
    - ``penetration``: (points,) δ [m].
    - ``speed``: (points,) δ̇ [m/s].
    - ``force``: (points,) F_n [N].
    """

    restitution: float
    max_penetration: float
    peak_force: float
    duration: float
    time: np.ndarray
    penetration: np.ndarray
    speed: np.ndarray
    force: np.ndarray


def free_impact(law: ForceLaw, mass: float, speed: float, points: int = 400) -> FreeImpact:
    """Integrate the impact of two free bodies, with tolerances of 1e-11.

    **Arguments:**

    - ``law``: the contact law.
    - ``mass``: effective mass [kg].
    - ``speed``: of approach [m/s].
    - ``points``: how many points of the course to return.
    """
    # Imported here, since it takes long and most laws have a closed form.
    from scipy.integrate import solve_ivp

    # In units of the law's own time and of the touchdown speed all impacts look alike to the integrator.
    tau = float(law.time_scale(mass, speed))
    compiled = jax.jit(lambda depth, rate: law.force(depth, rate, jnp.asarray(speed)))

    def force(depth, rate):
        return np.asarray(compiled(depth * speed * tau, rate * speed))

    def field(_, y):
        return [y[1], -float(force(y[0], y[1])) * tau / (mass * speed)]

    def apart(_, y):
        return y[0]

    def deepest(_, y):
        return y[1]

    # Falling only, since the penetration is zero at touchdown as well.
    apart.terminal, apart.direction = True, -1  # type: ignore[attr-defined]
    run = solve_ivp(
        field, (0.0, 1e9), [0.0, 1.0], "DOP853", events=(apart, deepest), rtol=1e-11, atol=1e-13, dense_output=True
    )
    end = run.t_events[0][-1]
    course = np.linspace(0.0, end, points)
    depth, rate = run.sol(course)
    forces = force(depth, rate)
    top = int(np.argmax(forces))  # the peak lies between two points of the course
    around = np.linspace(course[max(top - 1, 0)], course[min(top + 1, points - 1)], points)
    return FreeImpact(
        restitution=float(-run.y_events[0][-1][1]),
        max_penetration=float(run.y_events[1][0][0] * speed * tau),
        peak_force=float(np.max(force(*run.sol(around)))),
        duration=float(end * tau),
        time=course * tau,
        penetration=depth * speed * tau,
        speed=rate * speed,
        force=forces,
    )
