"""Mechanisms assembled from parts, and how tests integrate them."""

from typing import NamedTuple

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from jaxbuffer.multibody import (
    GROUND,
    AppliedForce,
    AxialSpringDamper,
    Body,
    Kinematics,
    PointOnLine,
    Revolute,
    System,
    Weld,
    assemble,
)

GRAVITY = 9.81  # m/s²


class Mechanism(NamedTuple):
    """A system with consistent initial coordinates and velocities."""

    system: System
    q: jax.Array
    v: jax.Array


def phi(system: System, q):
    """Φ(q), from the joints' own rows."""
    return system.constraints(Kinematics(q, jnp.zeros_like(q))).phi


def integrate(mechanism: Mechanism, times, tolerance=1e-13):
    """Coordinates and velocities at ``times``, by an eighth-order method independent of jaxbuffer's own loop."""
    # Arrays in place of floats: mechanisms of one kind then share one compiled program.
    return _integrate(*jax.tree.map(lambda leaf: jnp.asarray(leaf, float), (mechanism, times, tolerance)))


@eqx.filter_jit
def _integrate(mechanism, times, tolerance):
    def field(_, y, system):
        return y[1], system.motion(system.kinematics(*y)).acceleration

    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(field),
        diffrax.Dopri8(),
        t0=0.0,
        t1=times[-1],
        dt0=1e-3,
        y0=(mechanism.q, mechanism.v),
        args=mechanism.system,
        saveat=diffrax.SaveAt(ts=times),
        stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
        max_steps=200_000,
    )
    return solution.ys


def energies(system: System, q, v):
    """Kinetic and stored energy along a trajectory [J]."""

    def energy(q, v):
        kin = system.kinematics(q, v)
        return system.kinetic_energy(kin) + system.stored_energy(kin)

    return jax.vmap(energy)(q, v)


def _weights(*bodies: Body) -> tuple[AppliedForce, ...]:
    return tuple(AppliedForce(i, (0.0, -GRAVITY * body.mass)) for i, body in enumerate(bodies))


def pendulum(angle: float, rate: float = 0.0, mass: float = 1.3, length: float = 0.8) -> Mechanism:
    """A rod hung by its end from the ground, ``angle`` [rad] from hanging at rest."""
    rod = Body(mass, mass * length**2 / 12)
    system = System((rod,), (Revolute(GROUND, 0, second_point=(-length / 2, 0.0)),), _weights(rod))
    heading, half = angle - np.pi / 2, length / 2
    q = jnp.array([half * np.cos(heading), half * np.sin(heading), heading])
    v = rate * jnp.array([-half * np.sin(heading), half * np.cos(heading), 1.0])
    return Mechanism(system, q, v)


def four_bar(stabilisation: float = 20.0) -> Mechanism:
    """Crank 0.2 m, coupler 0.5 m, rocker 0.4 m on a 0.45 m base under gravity, the crank spinning at 20 rad/s."""
    lengths = (0.2, 0.5, 0.4)
    crank, coupler, rocker = bodies = tuple(Body(2.0 * length, length**3 / 6) for length in lengths)
    ends = [(length / 2, 0.0) for length in lengths]
    starts = [(-length / 2, 0.0) for length in lengths]
    joints = (
        Revolute(GROUND, 0, second_point=starts[0]),
        Revolute(0, 1, ends[0], starts[1]),
        Revolute(1, 2, ends[1], ends[2]),
        Revolute(2, GROUND, starts[2], (0.45, 0.0)),
    )
    system = System(bodies, joints, _weights(crank, coupler, rocker), stabilisation)
    guess = jnp.array([0.1, 0.0, 0.1, 0.4, 0.2, 0.8, 0.5, 0.2, 1.3])
    q, v = assemble(system, guess, jnp.zeros(9).at[2].set(1.0))
    return Mechanism(system, q, v * (20.0 / v[2]))


def slider_crank(crank: float = 0.15, rod: float = 0.35, angle: float = 0.4, rate: float = 12.0) -> Mechanism:
    """A crank turning freely about the origin, a rod and a slider on the x axis: no force does work."""
    bodies = (Body(0.8, 0.006), Body(0.6, 0.6 * rod**2 / 12), Body(0.9, 1e-3))
    joints = (
        Revolute(GROUND, 0),
        Revolute(0, 1, (crank, 0.0), (-rod / 2, 0.0)),
        Revolute(1, 2, (rod / 2, 0.0)),
        PointOnLine(GROUND, 2),
        PointOnLine(GROUND, 2, second_point=(0.1, 0.0)),
    )
    system = System(bodies, joints)
    dip = -np.arcsin(crank * np.sin(angle) / rod)
    pin = crank * np.array([np.cos(angle), np.sin(angle)])
    middle, end = pin + rod / 2 * np.array([np.cos(dip), np.sin(dip)]), pin[0] + rod * np.cos(dip)
    q = jnp.array([0.0, 0.0, angle, *middle, dip, end, 0.0, 0.0])
    return Mechanism(system, *assemble(system, q, _crank_motion(crank, rod, angle, dip, rate)))


def _crank_motion(crank, rod, angle, dip, rate):
    """Velocities of crank, rod and slider that belong to the crank's rate."""
    dip_rate = -rate * crank * np.cos(angle) / (rod * np.cos(dip))
    pin = rate * crank * np.array([-np.sin(angle), np.cos(angle)])
    lever = dip_rate * rod * np.array([-np.sin(dip), np.cos(dip)])
    return jnp.array([0.0, 0.0, rate, *(pin + lever / 2), dip_rate, *(pin + lever), 0.0])


def sprung_slider_crank(stiffness=1.0, damping=1.0) -> Mechanism:
    """The slider-crank of SUNDIALS' example idasSlCrank_FSA_dns: the rod's mass sits at the slider, a spring-damper
    joins the middles of crank and rod, and a constant force pulls the rod along x."""
    crank, angle = 0.5, np.pi / 2
    bodies = (Body(1.0, 1.0), Body(1.0, 2.0))
    joints = (Revolute(GROUND, 0), Revolute(0, 1, (crank, 0.0), (-1.0, 0.0)), PointOnLine(GROUND, 1))
    forces = (
        AxialSpringDamper(0, 1, (crank / 2, 0.0), (-0.5, 0.0), stiffness, damping, free_length=1.0),
        AppliedForce(1, (1.0, 0.0), point=(1.0, 0.0)),
    )
    dip = np.arcsin(-crank)
    q = jnp.array([0.0, 0.0, angle, np.cos(dip), 0.0, dip])
    return Mechanism(System(bodies, joints, forces), q, jnp.zeros(6))


def welded_pair(angle: float, first=(0.7, 0.02), second=(1.9, 0.05), offset=(0.3, -0.2), turn=0.6) -> Mechanism:
    """Two bodies (mass, inertia) welded together, the second ``offset`` from the first and turned against it, pinned to
    the ground at the first's centre of mass and drawn by a spring; started at rest."""
    bodies = (Body(*first), Body(*second))
    joints = (Revolute(GROUND, 0), Weld(0, 1, first_point=offset, angle=-turn))
    spring = AxialSpringDamper(GROUND, 1, (0.5, 0.4), (0.1, 0.05), stiffness=40.0, damping=0.6, free_length=0.3)
    cos, sin = np.cos(angle), np.sin(angle)
    centre = (cos * offset[0] - sin * offset[1], sin * offset[0] + cos * offset[1])
    q = jnp.array([0.0, 0.0, angle, *centre, angle + turn])
    return Mechanism(System(bodies, joints, (spring,)), q, jnp.zeros(6))


def merged_pair(angle: float, first=(0.7, 0.02), second=(1.9, 0.05), offset=(0.3, -0.2), turn=0.6) -> Mechanism:
    """The same two bodies as one, by the parallel-axis theorem; its axes are the first body's."""
    mass = first[0] + second[0]
    shift = np.array(offset) * second[0] / mass
    apart = first[0] * second[0] / mass * np.dot(offset, offset)
    body = Body(mass, first[1] + second[1] + apart)
    cos, sin = np.cos(turn), np.sin(turn)
    tip = offset - shift + np.array([cos * 0.1 - sin * 0.05, sin * 0.1 + cos * 0.05])
    spring = AxialSpringDamper(GROUND, 0, (0.5, 0.4), tuple(tip), stiffness=40.0, damping=0.6, free_length=0.3)
    system = System((body,), (Revolute(GROUND, 0, second_point=tuple(-shift)),), (spring,))
    cos, sin = np.cos(angle), np.sin(angle)
    q = jnp.array([cos * shift[0] - sin * shift[1], sin * shift[0] + cos * shift[1], angle])
    return Mechanism(system, q, jnp.zeros(3))
