"""Everything a run remembers has the derivative of its closed form: a ball that flies into a floor, and back."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from jaxbuffer import InputError
from jaxbuffer.contact.laws import Hertz, KelvinVoigt
from jaxbuffer.hybrid import ExplicitRungeKutta, Kind, Options, StepTolerance, solve
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.probe_cone.closed_form import HERTZ_DURATION, hertz_peak
from jaxbuffer.multibody import GROUND, Body, FixedAngle, System
from verification.riding import on_floor

MASS, RADIUS, HEIGHT, DURATION = 0.04, 0.015, 1e-4, 5e-3  # kg, m, m above the floor, s
HERE = jnp.asarray(0.1), jnp.asarray(6e9)  # speed [m/s], stiffness [N/m^1.5]
BACK = 2e-4  # m above the floor: where the run ends
OPTIONS = Options(ExplicitRungeKutta(), StepTolerance(1e-11, 1e-11), event_time=1e-14, max_events=16, keep=400)


def ball(speed, law) -> Assembled:
    system = System((Body(MASS, 1e-5),), (FixedAngle(GROUND, 0),))
    return Assembled(
        system,
        jnp.array([0.0, RADIUS + HEIGHT, 0.0]),
        jnp.stack([jnp.zeros(()), -speed, jnp.zeros(())]),
        (on_floor(RADIUS, law),),
        ends=(lambda system, kin: kin.q[1] - RADIUS - BACK,),
        size=(1e-4, 0.1),
    )


def flown(speed, stiffness):
    return solve(lambda *given: ball(given[0], Hertz(given[1])), (speed, stiffness), DURATION, OPTIONS)


@pytest.fixture(scope="module")
def found():
    """The run, and its log and stored steps with derivatives by speed and stiffness."""

    def numbers(*given):
        seen = flown(*given)
        return (seen.log.time, seen.log.values, seen.log.rows[:, 0], seen.steps.rows[:, 0]), seen

    derivatives, result = jax.jit(jax.jacfwd(numbers, (0, 1), has_aux=True))(*HERE)
    return jax.tree.map(np.asarray, (result, *derivatives))


def impact(speed, stiffness):
    """Times of touchdown, peak, release and end [s], and the peak force [N]: Hertz without loss."""
    energy = 0.5 * MASS * speed**2
    lasts = HERTZ_DURATION * (2.5 * energy / stiffness) ** 0.4 / speed
    touch = HEIGHT / speed
    return jnp.stack([touch, touch + lasts / 2, touch + lasts, touch + lasts + BACK / speed]), hertz_peak(
        stiffness, energy
    )


slopes_of_impact = jax.jit(jax.jacfwd(impact, (0, 1)))


@pytest.mark.slow
def test_times_of_events_move(found):
    result, time, *_ = found
    kinds = np.asarray(result.log.kind)[: int(result.log.count)]
    assert kinds.tolist() == [Kind.TOUCHDOWN, Kind.PEAK, Kind.RELEASE, Kind.END]
    for mine, expected in zip(time, slopes_of_impact(*HERE)[0], strict=True):
        assert_allclose(mine[:4], expected, rtol=1e-5)


def test_values_are_differentiated(found):
    _, _, values, *_ = found
    for mine, expected in zip(values, slopes_of_impact(*HERE)[1], strict=True):
        assert_allclose(mine[1, 0], expected, rtol=1e-7)
        assert_allclose(mine[[0, 2, 3], 0], 0.0, atol=1e-6 * abs(float(expected)))


def test_states_move_with_their_events(found):
    """At touchdown and release the ball is at rest on the floor's edge; its speed there is -v and v."""
    _, _, _, rows, _ = found
    for entry, height, speed in ((0, 0.0, -1.0), (2, 0.0, 1.0), (3, 0.0, 1.0)):
        assert_allclose(rows[0][entry, [1, 4]], [height, speed], atol=1e-5)


def test_stored_steps_have_derivatives_at_fixed_times(found):
    """Before the impact y = h - v t, after it h' + v (t - t_release)."""
    result, _, _, _, steps = found
    count, time = int(result.steps.count), np.asarray(result.steps.time)
    touch, release = float(result.log.time[0]), float(result.log.time[2])
    before, after = time[:count] < touch, time[:count] > release
    assert before.sum() > 1 and after.sum() > 1
    assert_allclose(steps[0][:count, 1][before], -time[:count][before], rtol=1e-9, atol=1e-15)
    late = [np.asarray(slope)[2] for slope in slopes_of_impact(*HERE)[0]]
    speed = float(HERE[0])
    assert_allclose(steps[0][:count, 1][after], time[:count][after] - release - speed * float(late[0]), rtol=1e-6)
    assert_allclose(steps[1][:count, 1][after], -speed * float(late[1]), rtol=1e-5)
    assert all(np.all(np.isfinite(step)) for step in steps)


@pytest.mark.slow
def test_a_force_that_jumps_at_touchdown():
    """Kelvin-Voigt's is c v there."""

    def force(speed, damping):
        def build(speed, damping):
            return ball(speed, KelvinVoigt(jnp.asarray(2e7), damping))

        return solve(build, (speed, damping), DURATION, OPTIONS).log.values[0, 0]

    found = jax.jit(jax.jacfwd(force, (0, 1)))(jnp.asarray(0.1), jnp.asarray(1500.0))
    assert_allclose(found, [1500.0, 0.1], rtol=1e-8)


@pytest.mark.long
def test_reverse_mode_meets_no_nan(found):
    """What has no derivative (``guard_rate``: NaN) must not reach what has."""
    time = jax.jit(jax.grad(lambda speed: flown(speed, HERE[1]).log.time[2]))(HERE[0])
    assert_allclose(time, found[1][0][2], rtol=1e-9)
    assert np.isnan(jax.jit(jax.grad(lambda speed: flown(speed, HERE[1]).log.guard_rate[2]))(HERE[0]))


TWICE = {
    "hessian": jax.hessian,
    "grad of grad": lambda f: jax.grad(jax.grad(f)),
    "jacfwd of jacrev": lambda f: jax.jacfwd(jax.jacrev(f)),
    "jacfwd of jacfwd": lambda f: jax.jacfwd(jax.jacfwd(f)),
    "jacrev of jacfwd": lambda f: jax.jacrev(jax.jacfwd(f)),
    "jit of hessian": lambda f: jax.jit(jax.hessian(f)),
    "hessian of jit": lambda f: jax.hessian(jax.jit(f)),
    "vmap of hessian": lambda f: lambda x: jax.vmap(jax.hessian(f))(x[None]),
}


OFTEN = ("hessian", "jacrev of jacfwd", "hessian of jit")  # the outermost of the two by each mode, and around a `jit`


@pytest.mark.parametrize(
    "twice", [pytest.param(TWICE[it], id=it, marks=() if it in OFTEN else pytest.mark.slow) for it in TWICE]
)
def test_second_derivatives_are_refused_in_words(twice):
    with pytest.raises(InputError, match=r"second derivatives are not offered.*take differences of first derivatives"):
        twice(lambda speed: flown(speed, HERE[1]).log.values[1, 0])(HERE[0])


@pytest.mark.parametrize("differentiate", [jax.grad, jax.jacfwd])
def test_derivatives_by_the_duration_are_refused_in_words(differentiate):
    def end(duration):
        return solve(lambda speed: ball(speed, Hertz(6e9)), (HERE[0],), duration, OPTIONS).log.rows[1, 0, 1]

    with pytest.raises(InputError, match=r"can't be differentiated by its duration, rtol or atol"):
        differentiate(end)(DURATION)
