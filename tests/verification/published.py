"""Mechanisms with published numbers, assembled from the project's own bodies, joints and forces."""

import jax.numpy as jnp
import numpy as np

from helpers import four_bar, sprung_slider_crank
from jaxbuffer.elements import Integral
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.multibody import (
    GROUND,
    AppliedForce,
    AppliedTorque,
    AxialSpringDamper,
    Body,
    Kinematics,
    Revolute,
    System,
    assemble,
)


def kinetic_energy(kin: Kinematics, system: System):
    return system.kinetic_energy(kin)


def sundials_slider_crank(stiffness, damping) -> Assembled:
    """SUNDIALS, IDAS example idasSlCrank_FSA_dns, with the integral of its kinetic energy."""
    mechanism = sprung_slider_crank(stiffness, damping)
    energy = Integral(kinetic_energy, mechanism.system, watched=False)
    return Assembled(mechanism.system, mechanism.q, mechanism.v, elements=(energy,))


def spinning_four_bar() -> Assembled:
    mechanism = four_bar()
    return Assembled(mechanism.system, mechanism.q, mechanism.v)


# --- Andrews' squeezing mechanism (test set for IVP solvers, "andrews"; Hairer & Wanner II, VII.7) -------------------

SQUEEZER_NAMES = ("β", "Θ", "γ", "Φ", "δ", "Ω", "ε")
SQUEEZER_START = (
    *(-0.0617138900142764, 0.0, 0.4552798191630704, 0.2226683901658859),
    *(0.4873649795438426, -0.2226683901658859, 1.230547444549821),
)
SQUEEZER_END = (
    *(15.81077119629904, -15.75637105984298, 0.04082224013073101, -0.5347301163226948),
    *(0.5244099658805304, 0.5347301163226948, 1.048080741042263),
)
SQUEEZER_TIME = 0.03  # s


def squeezer() -> Assembled:
    """Seven bodies, ten pins, a spring and a motor; three loops meet in the point P."""
    mass = (0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498)
    inertia = (2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5)
    a, b, c = (-0.06934, -0.00227), (-0.03635, 0.03273), (0.014, 0.072)
    d, da, e, ea, rr, ra = 28e-3, 115e-4, 2e-2, 1421e-5, 7e-3, 92e-5
    ss, sa, sb, sc, sd = 35e-3, 1874e-5, 1043e-5, 18e-3, 2e-2
    ta, tb, u, ua, ub, zf, zt, fa = 2308e-5, 916e-5, 4e-2, 1228e-5, 449e-5, 2e-2, 4e-2, 1421e-5
    # Each body's centre of mass and points, in axes along its own angle from its own pin; then from the centre of mass.
    centres = ((ra, 0.0), (-da, 0.0), (sb, -sa), (0.0, ea - e), (ta, tb), (zf - fa, 0.0), (-ub, -ua))

    def point(body: int, x: float, y: float) -> tuple[float, float]:
        return x - centres[body][0], y - centres[body][1]

    k1, k2, k3, k4, k5, k6, k7 = range(7)
    joints = (
        Revolute(GROUND, k1, (0.0, 0.0), point(k1, 0.0, 0.0)),
        Revolute(k1, k2, point(k1, rr, 0.0), point(k2, 0.0, 0.0)),
        Revolute(GROUND, k3, b, point(k3, 0.0, 0.0)),
        Revolute(k2, k3, point(k2, -d, 0.0), point(k3, 0.0, -ss)),
        Revolute(GROUND, k5, a, point(k5, 0.0, 0.0)),
        Revolute(k5, k4, point(k5, zt, 0.0), point(k4, 0.0, 0.0)),
        Revolute(k2, k4, point(k2, -d, 0.0), point(k4, 0.0, -e)),
        Revolute(GROUND, k7, a, point(k7, 0.0, 0.0)),
        Revolute(k7, k6, point(k7, 0.0, -u), point(k6, 0.0, 0.0)),
        Revolute(k2, k6, point(k2, -d, 0.0), point(k6, zf, 0.0)),
    )
    return _squeezer(mass, inertia, joints, point, centres, (a, b, c), (rr, zt, u), (sc, sd))


def squeezer_angles(q) -> np.ndarray:
    """The test set's seven angles from the bodies' own: β, β+Θ, γ, Φ+δ, δ, Ω+ε, ε."""
    one, two, gamma, four, delta, six, epsilon = np.asarray(q)[2::3]
    return np.array([one, two - one, gamma, four - delta, delta, six - epsilon, epsilon])


def _squeezer(mass, inertia, joints, point, centres, pins, arms, lever) -> Assembled:
    beta, theta, gamma, phi, delta, omega, epsilon = SQUEEZER_START
    angles = (beta, beta + theta, gamma, phi + delta, delta, omega + epsilon, epsilon)
    (rr, zt, u), (a, b, c) = arms, (np.array(pin) for pin in pins)

    def turned(angle, x, y):
        return np.array([np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y])

    tips = turned(beta, rr, 0.0), a + turned(delta, zt, 0.0), a + turned(epsilon, 0.0, -u)
    origins = (np.zeros(2), tips[0], b, tips[1], a, tips[2], a)
    q = []
    for origin, angle, centre in zip(origins, angles, centres, strict=True):
        q += [*(origin + turned(angle, *centre)), angle]
    sc, sd = lever
    forces = (
        AxialSpringDamper(GROUND, 2, tuple(c), point(2, sd, -sc), stiffness=4530.0, damping=0.0, free_length=0.07785),
        AppliedTorque(0, 0.033),
    )
    system = System(tuple(Body(m, i) for m, i in zip(mass, inertia, strict=True)), joints, forces)
    return Assembled(system, jnp.array(q), jnp.zeros(21), size=(1e-2, 10.0))


# --- Slider-crank with translational clearance (Flores, Leine & Glocker 2010) -----------------------------------------

CLEARANCE, HALF = 0.001, (0.05, 0.025)  # m


def loose_slider_crank() -> Assembled:
    """Crank, rod and a slider loose in its guide; the run ends when the first of its corners touches the guide."""
    crank, rod, gravity = 0.153, 0.306, 9.81
    bodies = (Body(0.038, 7.4e-5), Body(0.038, 5.9e-4), Body(0.076, 2.7e-6))
    joints = (
        Revolute(GROUND, 0, second_point=(-crank / 2, 0.0)),
        Revolute(0, 1, (crank / 2, 0.0), (-rod / 2, 0.0)),
        Revolute(1, 2, (rod / 2, 0.0)),
    )
    weights = tuple(AppliedForce(i, (0.0, -gravity * body.mass)) for i, body in enumerate(bodies))
    system = System(bodies, joints, weights)
    q = jnp.array([crank / 2, 0.0, 0.0, crank + rod / 2, 0.0, 0.0, crank + rod, 0.0, 0.0])
    spins = jnp.zeros(9).at[jnp.array([2, 5])].set(jnp.array([150.0, -75.0]))
    pin, lever = 150.0 * crank, -75.0 * rod
    v = spins + jnp.array([0.0, pin / 2, 0.0, 0.0, pin + lever / 2, 0.0, 0.0, pin + lever, 0.0])

    def corner(x: float, y: float):
        def depth(_: System, kin: Kinematics):
            slider = kin.frame(2)
            height = slider.origin.y + slider.sin * x + slider.cos * y
            return jnp.sign(y) * height - HALF[1] - CLEARANCE

        return depth

    ends = tuple(corner(x, y) for x in (-HALF[0], HALF[0]) for y in (-HALF[1], HALF[1]))
    return Assembled(system, *assemble(system, q, v), ends=ends)
