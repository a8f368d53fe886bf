"""A run by `diffrax.diffeqsolve`: events of a ball that bounces off a spring, against closed forms."""

import dataclasses

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

from hybrid.phases import arrays
from jaxbuffer import Diffrax, InputError
from jaxbuffer.hybrid import (
    SOLVER_NAMES,
    ExplicitRungeKutta,
    Kind,
    Options,
    Solver,
    Status,
    StepTolerance,
    solve,
    solver_named,
)
from jaxbuffer.hybrid.diffrax_problem import diffrax_problem
from jaxbuffer.hybrid.system import HybridSystem, Linearisation

GRAVITY, MASS, HEIGHT, STIFFNESS, THROWN = 9.81, 0.2, 0.05, 2e4, 0.7  # m/s², kg, m, N/m, m/s downwards
END = 0.06  # m, rising through this height ends the run
TIGHT = Options(
    solver=Diffrax(diffrax.Tsit5(), max_steps=4096), tolerance=StepTolerance(1e-10, 1e-10), max_events=8, keep=2048
)

LOOSE = dataclasses.replace(TIGHT, tolerance=StepTolerance(1e-8, 1e-8))


class Ball(HybridSystem):
    """A ball thrown down from ``height`` [m] on a spring of ``stiffness`` [N/m]: height and velocity are its state."""

    height: Array
    stiffness: Array

    @property
    def coordinates(self):
        return 1

    def start(self):
        return jnp.stack([self.height, jnp.asarray(-THROWN)]), jnp.zeros(1)

    def derivative(self, time, state, active):
        return jnp.stack([state[1], jnp.sum(self.observables(state, None, active)) / MASS - GRAVITY])

    def gaps(self, state):
        return state[:1]

    def touchdown(self, state, quickening, contact):
        return state

    def terminals(self, state):
        return state[:1] - END

    def observables(self, state, rate, active):
        return self.stiffness * jnp.maximum(-state[:1], 0.0)

    def rate_observables(self):
        return (False,)

    @property
    def observed(self):
        return ("force",)

    def scales(self):
        return jnp.array([HEIGHT, 1.0])

    def linearisation(self, time, state, active):
        return Linearisation.none(1, 1)

    def impact_step(self, state):
        return jnp.sqrt(MASS / self.stiffness) / 15.0


@jax.jit
def expected(height, stiffness):
    """Times of touchdown, largest force, release and end [s], and that force [N]."""
    rate, weight = jnp.sqrt(stiffness / MASS), MASS * GRAVITY / stiffness
    speed = jnp.sqrt(THROWN**2 + 2.0 * GRAVITY * height)
    touch = (speed - THROWN) / GRAVITY
    turn = (jnp.pi - jnp.arctan(speed / (rate * weight))) / rate
    rise = (speed - jnp.sqrt(speed**2 - 2.0 * GRAVITY * END)) / GRAVITY
    times = touch + jnp.stack([0.0 * turn, turn, 2.0 * turn, 2.0 * turn + rise])
    return times, stiffness * (weight + jnp.sqrt(weight**2 + (speed / rate) ** 2))


def run(height=HEIGHT, stiffness=STIFFNESS, duration=1.0, options=TIGHT, allowed=True):
    """Solve with all numbers as arrays, so that one compiled program serves any of them."""
    *numbers, allowed = map(jnp.asarray, (height, stiffness, duration, allowed))
    return _compiled(*numbers, dataclasses.replace(options, tolerance=arrays(options.tolerance)), allowed)


@eqx.filter_jit
def _compiled(height, stiffness, duration, options, allowed):
    return solve(Ball, (height, stiffness), duration, options, allowed)


def events(height, stiffness, options=TIGHT):
    """Their times [s] and the largest force [N], as `expected`."""
    log = run(height, stiffness, options=options).log
    return log.time[:4], log.values[1, 0]


def test_events_are_located_and_in_order():
    result = run()
    assert int(result.status) == 0
    assert int(result.log.count) == 4
    assert [Kind(int(kind)) for kind in result.log.kind[:4]] == [Kind.TOUCHDOWN, Kind.PEAK, Kind.RELEASE, Kind.END]
    for found, exact in zip(events(HEIGHT, STIFFNESS), expected(HEIGHT, STIFFNESS), strict=True):
        np.testing.assert_allclose(found, exact, rtol=1e-7)


@pytest.mark.parametrize("share", [1e-3, 0.01, 0.1])
def test_an_end_that_is_reached_within_one_step_is_found(share):
    """The ball rises above its mark by a small share of the height and falls again, in one step of free flight."""
    above, below = (jnp.asarray(END * part - 0.5 * THROWN**2 / GRAVITY) for part in (1.0 + share, 1.0 - share))
    result = run(above, options=LOOSE)
    assert int(result.status) == 0
    np.testing.assert_allclose(result.log.time[3], expected(above, STIFFNESS)[0][3], rtol=1e-3)
    # the mark is above all that it reaches from there: it bounces until the time is up, or the log's room is full
    assert int(run(below, options=LOOSE).status) == Status.TIMEOUT


def slopes(function, derivative=jax.jacfwd):
    """d/d ln height and d/d ln stiffness of the times and of the force, a row each."""
    times, force = derivative(lambda logs: function(*jnp.exp(logs)))(jnp.log(jnp.array([HEIGHT, STIFFNESS])))
    return np.concatenate([times, force[None]])


@pytest.mark.slow
def test_tangents_are_under_the_same_error_control():
    """Differentiated through the solve, the steps across the touchdown, where the force has a kink, would make the time
    of the end wrong by 6e-3 at rtol 1e-10 and the force by 2e-3."""
    check_slopes(events)


def check_slopes(function, derivative=jax.jacfwd):
    exact = slopes(expected)
    scale = np.max(np.abs(exact), axis=1)
    assert np.max(np.abs(slopes(function, derivative) - exact) / scale[:, None]) < 1e-6


@pytest.mark.slow
def test_tangents_backwards_and_of_our_own_steps():
    """As `test_tangents_are_under_the_same_error_control`."""
    located = Options(solver=ExplicitRungeKutta(), tolerance=StepTolerance(1e-10, 1e-10), max_events=8)
    check_slopes(lambda *given: events(*given, options=located))
    check_slopes(events, jax.jacrev)
    np.testing.assert_allclose(slopes(events, jax.jacrev), slopes(events), rtol=1e-9, atol=1e-12)


def test_a_history_begins_at_the_start_and_ends_at_the_end():
    result = run()
    times = np.asarray(result.steps.time)[: int(result.steps.count)]
    assert times[0] == 0.0
    assert np.all(np.diff(times) > 0.0)
    np.testing.assert_allclose(times[-1], expected(HEIGHT, STIFFNESS)[0][-1], rtol=1e-7)
    np.testing.assert_allclose(result.steps.rows[int(result.steps.count) - 1, 0, 0], END, rtol=1e-7)


@pytest.mark.slow
def test_how_runs_end():
    few = Options(solver=Diffrax(diffrax.Tsit5(), max_steps=3), tolerance=StepTolerance(1e-10, 1e-10), max_events=8)
    assert int(run(options=few).status) == Status.TOO_MANY_STEPS
    assert int(run(stiffness=jnp.asarray(np.nan)).status) == Status.NOT_FINITE
    assert int(run(height=jnp.asarray(np.nan)).status) == Status.NOT_FINITE
    assert int(run(allowed=jnp.asarray(False)).status) == Status.INPUT
    short = run(duration=jnp.asarray(0.05))
    assert int(short.status) == Status.TIMEOUT
    assert Kind(int(short.log.kind[int(short.log.count) - 1])) == Kind.END
    np.testing.assert_allclose(short.log.latest, 0.05)


def solved(problem, tolerance, **options):
    """The problem, integrated until its event."""
    controller = diffrax.PIDController(rtol=tolerance, atol=tolerance * problem.scales)
    given = {"args": problem.args, "event": problem.event, "stepsize_controller": controller} | options
    return diffrax.diffeqsolve(problem.term, diffrax.Tsit5(), 0.0, 1.0, problem.dt0, problem.y0, **given)


def test_the_problem_for_diffeqsolve():
    """Its event ends the solve at the end's time; what is saved are the observables by name."""
    problem = diffrax_problem(Ball, (jnp.asarray(HEIGHT), jnp.asarray(STIFFNESS)))
    times, force = expected(HEIGHT, STIFFNESS)
    solution = solved(
        problem,
        1e-10,
        saveat=diffrax.SaveAt(
            subs=[
                diffrax.SubSaveAt(t1=True),
                diffrax.SubSaveAt(ts=times[1:2], fn=problem.observe),
                diffrax.SubSaveAt(ts=times[1:2], fn=problem.normal_forces),
            ]
        ),
    )
    assert bool(solution.event_mask)
    assert int(problem.ended_by(problem.y0, problem.args)) == 0
    np.testing.assert_allclose(solution.ts[0], times[-1:], rtol=1e-8)
    np.testing.assert_allclose(solution.ys[1]["force"], force, rtol=1e-7)
    np.testing.assert_allclose(solution.ys[2][0], force, rtol=1e-7)


def end_of_problem(stiffness, adjoint):
    """The time [s] of the event that ends the problem."""
    problem = diffrax_problem(Ball, (jnp.asarray(HEIGHT), stiffness))
    return solved(problem, 1e-8, adjoint=adjoint, max_steps=256).ts[0]


def by_jvp(adjoint):
    """The derivative of that time by the stiffness."""
    at = jnp.asarray(STIFFNESS)
    return jax.jvp(lambda x: end_of_problem(x, adjoint), (at,), (jnp.ones(()),))[1]


def by_grad(adjoint):
    """The same."""
    return jax.grad(end_of_problem)(jnp.asarray(STIFFNESS), adjoint)


@pytest.mark.slow
def test_adjoints_of_the_problem():
    """Backwards through checkpoints, forwards and either way: one derivative, of the event's time too."""
    found = by_jvp(diffrax.ForwardMode())
    np.testing.assert_allclose(found, by_grad(diffrax.RecursiveCheckpointAdjoint()), rtol=1e-9)
    for derivative in (by_jvp, by_grad):
        np.testing.assert_allclose(derivative(diffrax.DirectAdjoint()), found, rtol=1e-9)


@pytest.mark.parametrize("name", SOLVER_NAMES)
def test_every_name_gives_a_solver(name):
    solver = solver_named(name)
    assert isinstance(solver, Solver)
    if name.startswith("diffrax:"):
        assert isinstance(solver, Diffrax)
        assert type(solver.method).__name__ == name.removeprefix("diffrax:")


def test_unknown_methods_are_refused_with_those_that_exist():
    with pytest.raises(
        InputError, match=r"diffrax:Kvarno5' is unknown.*diffrax:Tsit5; did you mean diffrax:Kvaerno5\?"
    ):
        solver_named("diffrax:Kvarno5")
    with pytest.raises(InputError, match=r"estimates its error; use .*diffrax\.Kvaerno5\(\)"):
        Diffrax(diffrax.Euler())
    with pytest.raises(InputError, match=r"max_steps = 0 must be a whole number of at least 1"):
        Diffrax(max_steps=0)
