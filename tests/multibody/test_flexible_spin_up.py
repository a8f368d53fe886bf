"""A cantilever on a driven hub (Kane; Simo and Vu-Quoc 1986), through the equations of motion with all their terms."""

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.multibody import GROUND, ConstantSpeed, DrivenAngle, FlexibleBody, Revolute, System
from jaxbuffer.multibody.flexible import Bar, cantilever_bar
from jaxbuffer.plane import cos_sin

TOPIC = "Spin-up of a cantilever"
INDEPENDENT = "an independent program"
LENGTH, LINE_MASS, AXIAL, BENDING = 10.0, 1.2, 2.8e7, 1.4e4
RISE, FINAL = 15.0, 6.0  # s, rad/s


class SpinUp(eqx.Module):
    """θ = Ω/T (t²/2 + (T/2π)² (cos(2πt/T) - 1)), and from T on Ω (t - T/2)."""

    speed: float
    rise: float

    def __call__(self, time):
        turn = 2.0 * jnp.pi / self.rise
        cos = cos_sin(jnp.reshape(turn * time, (1,)))[0][0]
        rising = self.speed / self.rise * (0.5 * time**2 + (cos - 1.0) / turn**2)
        return jnp.where(time < self.rise, rising, self.speed * (time - 0.5 * self.rise))


@eqx.filter_jit  # one program in place of its many operations
def blade(bending=BENDING, interior=4, axial=None, geometric=True):
    second_moment = bending / AXIAL
    return cantilever_bar(Bar(LENGTH, 1.0, second_moment, LINE_MASS, AXIAL), interior, axial, geometric=geometric)


@eqx.filter_jit
def first_modes(body, count):
    """The same body with its first lateral modes alone: those of Craig and Bampton are its natural ones, uncoupled."""
    some, modes = slice(0, count), body.modes
    cut = lambda matrix: None if matrix is None else matrix[some, some]  # noqa: E731
    end = jax.tree.map(lambda x: x[some] if jnp.ndim(x) else x, body.end)
    start = jax.tree.map(lambda x: x[some] if jnp.ndim(x) else x, body.start)
    modes = eqx.tree_at(
        lambda m: (m.mass_matrix, m.stiffness, m.damping, m.translation, m.rotation),
        modes,
        (
            cut(modes.mass_matrix),
            cut(modes.stiffness),
            cut(modes.damping),
            modes.translation[:, some],
            modes.rotation[some],
        ),
    )
    if modes.geometric is not None:
        modes = eqx.tree_at(lambda m: m.geometric, modes, cut(modes.geometric))
    return modes, start, end


def spun_up(modes, start, times):
    """Coordinates and velocities at these times, from rest."""
    q = jnp.zeros(3 + modes.size).at[0].set(0.5 * LENGTH)
    return driven(modes, start, SpinUp(FINAL, RISE), times, (q, jnp.zeros_like(q)))


def driven(modes, start, angle, times, y0):
    """On a hub that turns by this angle, a function of time."""
    joints = (Revolute(GROUND, 0, (0.0, 0.0), start), DrivenAngle(GROUND, 0, angle, second_point=start))
    system = System((FlexibleBody(modes),), joints, (), 0.0)

    def field(time, y, system):
        return y[1], system.motion(system.kinematics(*y, time)).acceleration

    return diffrax.diffeqsolve(
        diffrax.ODETerm(field),
        diffrax.Dopri8(),
        0.0,
        times[-1],
        1e-3,
        y0,
        args=system,
        saveat=diffrax.SaveAt(ts=times),
        stepsize_controller=diffrax.PIDController(rtol=1e-11, atol=1e-13, jump_ts=jnp.array([RISE])),
        adjoint=diffrax.ForwardMode(),
        max_steps=100_000,
    ).ys


@eqx.filter_jit
def deflections(modes, start, end, times):
    q, _ = spun_up(modes, start, times)
    return jnp.sum(q[:, 3:] * end.displacement_y[None, :], axis=1)


AROUND = np.concatenate([np.zeros(1), np.linspace(6.5, 7.0, 251)])
PEAKS = {1: -0.57826, 2: -0.57355, 3: -0.57444, 4: -0.57434, 6: -0.57437}


@pytest.mark.parametrize("count", PEAKS)
def test_the_tips_largest_deflection(count, evidence):
    """By so many natural modes of the cantilever, out of twelve."""
    found = np.asarray(deflections(*first_modes(blade(interior=12), count), AROUND))
    best = int(np.argmin(found))
    claim, told = "peak of the whole equations of motion, 1 to 6 modes", f"{count} modes: {found[best]:.5f} m"
    evidence(TOPIC, claim, abs(found[best] - PEAKS[count]), 1e-5, INDEPENDENT, "m", told)
    if count > 1:
        evidence(TOPIC, "its time, 2 to 6 modes", abs(float(AROUND[best]) - 6.76), 0.01, INDEPENDENT, "s")


def test_craig_and_bamptons_few_modes(evidence):
    """Two modes kept at the end and two or four of the fixed interfaces."""
    for interior in (2, 4):
        body = blade(interior=interior)
        found = float(np.min(np.asarray(deflections(body.modes, body.start, body.end, AROUND))))
        told = f"{interior + 2} modes: {found:.5f} m"
        evidence(TOPIC, "peak by Craig-Bampton modes", abs(found + 0.57437), 1e-4, INDEPENDENT, "m", told)


@eqx.filter_jit
def steady_extension(body):
    """Of the tip where the accelerations of the axial coordinates vanish in the steady spin."""
    system = System((FlexibleBody(body.modes),), (Revolute(GROUND, 0, (0.0, 0.0), body.start),), (), 0.0)
    lateral, size = body.lateral, body.modes.size

    def accelerations(modal):
        q = jnp.zeros(3 + size).at[0].set(0.5 * LENGTH).at[3 + lateral :].set(modal)
        v = jnp.zeros(3 + size).at[2].set(FINAL).at[1].set(FINAL * 0.5 * LENGTH)
        return system.motion(system.kinematics(q, v)).acceleration[3 + lateral :]

    none = jnp.zeros(size - lateral)
    modal = jnp.linalg.solve(jax.jacfwd(accelerations)(none), -accelerations(none))  # they are linear
    return jnp.sum(body.end.displacement_x[lateral:] * modal)


def test_the_blade_stretches_in_a_steady_spin(evidence):
    """ρ A Ω² L³/(3 E A), where the accelerations of all coordinates but the centripetal ones vanish."""
    tip = float(steady_extension(blade(interior=2, axial=6)))
    closed = LINE_MASS * FINAL**2 * LENGTH**3 / (3 * AXIAL)
    evidence(
        TOPIC, "steady extension by the equations of motion, relative", abs(tip / closed - 1.0), 1e-3, "closed form"
    )


@pytest.mark.parametrize("geometric", [False, True])
def test_without_stiffening_a_deflection_grows(geometric, evidence):
    """ω1 = 3.798 rad/s < 6 rad/s: in the steady spin it goes with exp(√(Ω² - ω1²) t), unless tension stiffens."""
    modes, start, _ = first_modes(blade(interior=12, geometric=geometric), 1)
    omega = 1.875104068711961**2 * np.sqrt(BENDING / LINE_MASS) / LENGTH**2
    growth = np.sqrt(FINAL**2 - omega**2)
    q = np.array([0.5 * LENGTH, 0.0, 0.0, 1e-3])
    v = np.array([0.0, 0.5 * LENGTH * FINAL, FINAL, 1e-3 * growth])
    times = np.linspace(0.0, 1.0, 21)
    q, _ = eqx.filter_jit(driven)(modes, start, ConstantSpeed(0.0, FINAL), times, (q, v))
    first = np.asarray(q)[:, 3]
    if geometric:
        assert np.max(np.abs(first)) < 2e-3
    else:
        error = np.max(np.abs(first / (1e-3 * np.exp(growth * times)) - 1.0))
        evidence(TOPIC, "growth without stiffening, relative", error, 1e-5, "exp(√(Ω² - ω1²) t)")


def test_the_peaks_gradient(evidence):
    """By the bending stiffness, at the time of the peak, where the rate is zero: against fourth-order differences."""
    time = 6.76

    @jax.jit
    def both(bending):
        def tip(bending):
            body = blade(bending)
            q, _ = spun_up(body.modes, body.start, jnp.array([0.0, time]))
            return jnp.sum(q[-1, 3:] * body.end.displacement_y)

        return jax.jvp(tip, (bending,), (jnp.ones(()),))

    value, slope = both(BENDING)
    h = 14.0
    points = [float(both(BENDING + k * h)[0]) for k in (-2, -1, 1, 2)]
    differences = (points[0] - 8 * points[1] + 8 * points[2] - points[3]) / (12 * h)
    assert abs(float(slope)) * BENDING > 0.1 * abs(float(value))
    error = abs(float(slope) / differences - 1.0)
    evidence(TOPIC, "gradient of the tip's deflection by EI, relative", error, 1e-7, "central differences")
