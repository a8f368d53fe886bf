"""Shock on the vehicles at named frequencies: oscillators by closed form, in implicit steps, and in a whole run."""

import dataclasses
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import Akima1DInterpolator
from scipy.signal import lsim

from docking.states import mechanism
from jaxbuffer import replace, simulate, table2
from jaxbuffer.elements import Oscillators
from jaxbuffer.hybrid import Linearisation
from jaxbuffer.hybrid.rungekutta.newton import NewtonMatrix
from jaxbuffer.shock import largest_response, shock_spectrum

RATIO = 1.3  # duration of a pulse over the oscillator's period; the largest response is then within the pulse
DIRECTION = np.array([0.6, -0.8])
NAMED = {"active_shock_1": (0, 20.0), "passive_shock_1": (3, 60.0), "passive_shock_2": (3, 300.0)}  # body, Hz
TOPIC = "Docking until held"
STEP = 1e-5  # s


def test_a_half_sine_in_any_direction_by_closed_form():
    """Undamped: the pulse's peak times its published response, whatever the direction."""
    oscillators = Oscillators((3,), (RATIO,), ("shock",), damping=0.0)

    def moving(time):
        """A body 3 that a half-sine of 1 s and 2 m/s² pushes."""
        speed = 2.0 / np.pi * (1.0 - jnp.cos(np.pi * time)) * DIRECTION
        return SimpleNamespace(frame=lambda body: SimpleNamespace(velocity=tuple(speed)) if body == 3 else None)

    at = lambda time, states: oscillators.evaluate(moving(time), states)  # noqa: E731
    rate = jax.jit(lambda time, states: jnp.stack(oscillators.rates(at(time, states), jnp.zeros(0))))
    start = np.asarray(jax.jit(lambda: oscillators.start(moving(0.0)))())
    times = np.linspace(0.0, 1.0, 2001)
    found = solve_ivp(lambda t, y: np.asarray(rate(t, y)), (0.0, 1.0), start, rtol=1e-8, atol=1e-10, t_eval=times)
    size = lambda time, states: oscillators.observables(at(time, states), jnp.zeros(0))["shock"]  # noqa: E731
    sizes = np.asarray(jax.jit(jax.vmap(size))(found.t, found.y.T))
    largest = jax.jit(lambda: largest_response("half-sine", RATIO))()
    assert np.max(sizes) == pytest.approx(2.0 * float(largest), rel=1e-5)


@pytest.mark.slow
def test_implicit_steps_know_them():
    """Newton's matrix with the oscillators alone, against a dense solve with their Jacobian."""
    built = mechanism({"shock.active_1": 20.0, "shock.passive_3": 150.0, "shock.damping": 0.2})
    state, active = built.start()
    n, oscillators = built.coordinates, built.element("oscillators")
    frames = lambda v: SimpleNamespace(frame=lambda k: SimpleNamespace(velocity=(v[3 * k], v[3 * k + 1])))  # noqa: E731
    swinging = built.layout.places[f"element {built.elements.index(oscillators)}"]
    at = lambda y: oscillators.evaluate(frames(y[n : 2 * n]), y[swinging])  # noqa: E731
    rates = lambda y: jnp.stack(oscillators.rates(at(y), jnp.zeros(0)))  # noqa: E731
    jacobian = np.zeros((len(state), len(state)))
    jacobian[swinging] = np.asarray(jax.jacfwd(rates)(state))
    jacobian[:n, n : 2 * n] = np.eye(n)
    shift, right = 0.013, np.random.default_rng(3).standard_normal((len(state), 2))
    followers = jax.jit(lambda y: built.linearisation(0.0, y, active).followers)(state)
    alone = dataclasses.replace(Linearisation.none(n, n), followers=followers)
    found = NewtonMatrix.of(alone, jnp.asarray(shift)).solve(jnp.asarray(right))
    np.testing.assert_allclose(found, np.linalg.solve(np.eye(len(state)) - shift * jacobian, right), rtol=1e-10)


@pytest.mark.long
def test_the_shocks_of_a_run_are_those_of_its_history(evidence):
    """By SciPy's linear systems in both axes, and by Smallwood's filter in the direction of the largest."""
    fields = {f"shock.{name.replace('_shock', '')}": frequency for name, (_, frequency) in NAMED.items()}
    run = simulate(replace(table2(), fields), rtol=1e-9, history=True)
    np.testing.assert_allclose(run.peak_force, 253.13153, rtol=1e-7, err_msg="they act on nothing")
    instants, first = np.unique(np.asarray(run.history.time), return_index=True)
    motion = Akima1DInterpolator(instants, np.asarray(run.history.velocity)[first])
    times = np.arange(0.0, instants[-1], STEP)
    for name, (body, frequency) in NAMED.items():
        rate, damper = 2.0 * np.pi * frequency, 0.1 * 2.0 * np.pi * frequency
        system = [[0.0, 1.0], [-(rate**2), -damper]], [[-1.0], [damper]], [[-(rate**2), -damper]], [[damper]]
        changes = motion(times)[:, body, :2] - motion(0.0)[body, :2]
        felt = np.stack([lsim(system, changes[:, axis], times)[1] for axis in range(2)])
        top = np.argmax(np.linalg.norm(felt, axis=0))
        largest = np.linalg.norm(felt[:, top])
        off = abs(float(run.quantity(name)) / largest - 1.0)
        evidence(TOPIC, "shock at a frequency, rtol 1e-9", off, 1e-4, "the history by SciPy's lsim", detail=name)
        along = motion(np.clip(np.append(times, np.inf) - 0.5 * STEP, 0.0, times[-1]))[:, body, :2] @ (
            felt[:, top] / largest
        )
        filtered = shock_spectrum(np.diff(along) / STEP, STEP, np.array([frequency]))[0]
        off = abs(float(run.quantity(name)) / float(filtered) - 1.0)
        evidence(TOPIC, "shock at a frequency, rtol 1e-9", off, 1e-3, "the history by Smallwood's filter", detail=name)
