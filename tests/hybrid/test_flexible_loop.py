"""The time loop with flexible bodies: orders of convergence, implicit steps for stiff modes, one kernel."""

from functools import cache

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from hybrid.phases import arrays, stepper
from in_short import often
from jaxbuffer.contact import BallPair, LankaraniNikravesh, RegularisedCoulomb, Segment
from jaxbuffer.hybrid import Automatic, DiagonallyImplicit, ExplicitRungeKutta, Options, StepTolerance, solve
from jaxbuffer.mechanisms.assembled import Assembled, BallContact
from jaxbuffer.multibody import GROUND, AppliedForce, Body, FlexibleBody, Revolute, System, assemble
from jaxbuffer.multibody.flexible import Bar, free_bar

TOPIC = "Flexible bodies in the time loop"


@eqx.filter_jit  # one program in place of its many operations
def hanging(bar, contact=False, **modes) -> Assembled:
    """A bar on a pin under its weight, let go level; a ball may lie above its end."""
    body = free_bar(bar, 2, 1, **modes)
    mass, flexible = float(body.bar.mass), FlexibleBody(body.modes)
    system = System(
        (flexible, Body(0.1, 1e-5))[: 1 + contact],
        (Revolute(GROUND, 0, (0.0, 0.0), body.start),),
        (AppliedForce(0, (0.0, -9.81 * mass), flexible.centre_of_mass),),
    )
    q, v = np.zeros((2, system.coordinates))
    q[0] = 0.5 * bar.length
    if not contact:
        return Assembled(system, q, v, size=(1e-2, 1.0))
    q[3:5], v[4] = (0.9 * bar.length, 0.02), -1.0
    pair = BallPair(
        0.01, Segment(-1.0, 0.0, 1.0, 0.0, 2.0), -1.0, LankaraniNikravesh(1e6, 0.8), RegularisedCoulomb(0.1, 1e-3)
    )
    return Assembled(system, q, v, (BallContact(1, 0, pair, carrier_point=body.end),), size=(1e-2, 1.0))


SOFT = Bar.rectangle(0.5, 0.02, 0.01, 2700.0, 7e6)
STEEL = Bar.rectangle(0.5, 0.02, 0.01, 7800.0, 2.1e11)


@cache
def swinging():
    """The soft bar on its way: mechanism, state, no contacts."""
    mechanism = arrays(hanging(SOFT, damping_ratio=0.01))
    state = np.array(eqx.filter_jit(mechanism.start)()[0])
    state[10:12] += 5.0, 20.0
    return mechanism, jnp.asarray(state), jnp.zeros(0)


@cache
def exact(duration):
    return np.asarray(stepper(ExplicitRungeKutta(diffrax.Dopri8()), swinging())(duration, 3000))


SOLVERS = {
    "Tsit5": (ExplicitRungeKutta(diffrax.Tsit5()), 5, (48, 96)),
    "DOP853": (ExplicitRungeKutta(), 8, (12, 24)),
    "KenCarp4": (DiagonallyImplicit(), 4, (24, 48)),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SOLVERS)
def test_order_on_a_smooth_phase(name, evidence):
    solver, theory, counts = SOLVERS[name]
    advance = stepper(solver, swinging())
    duration = 0.02
    errors = [np.max(np.abs(np.asarray(advance(duration, n)) - exact(duration))[:18]) for n in counts]
    observed = np.log(errors[0] / errors[1]) / np.log(counts[1] / counts[0])
    told = f"{observed:.2f} against {theory}, errors {errors[0]:.1e} and {errors[1]:.1e}"
    allowed = 0.3 if theory == 8 else 0.15
    evidence(TOPIC, f"{name}: order with a flexible body", abs(observed - theory), allowed, "its theory", detail=told)


def itself(mechanism):
    return mechanism


@eqx.filter_jit
def run(mechanism, duration, solver):
    options = Options(
        solver=solver, tolerance=StepTolerance(1e-6, 1e-6), event_time=1e-9, max_events=32, max_steps=200_000
    )
    return solve(itself, (mechanism,), duration, options)


@pytest.mark.slow
def test_implicit_steps_pass_over_stiff_modes(evidence):
    """A steel bar swings for half a second; its modes along it have 10 and 21 kHz, and are damped well.

    Explicit steps must follow them, implicit ones must not; the automatic solver finds that out."""
    mechanism = arrays(hanging(STEEL, damping_ratio=0.05))
    solvers = {"explicit": ExplicitRungeKutta(), "implicit": DiagonallyImplicit(), "automatic": Automatic()}
    found = {name: run(mechanism, jnp.asarray(0.5), solver) for name, solver in solvers.items()}
    steps = {name: int(result.attempts) for name, result in found.items()}
    ends = {name: np.asarray(result.log.rows[int(result.log.count) - 1, 0]) for name, result in found.items()}
    told = ", ".join(f"{name} {count}" for name, count in steps.items())
    claim = "implicit steps over explicit ones, steel bar on a pin"
    evidence(TOPIC, claim, steps["implicit"] / steps["explicit"], 0.1, "stiff modes", detail=told)
    claim = "automatic steps over explicit ones, steel bar on a pin"
    evidence(TOPIC, claim, steps["automatic"] / steps["explicit"], 0.1, "stiff modes", detail=told)
    for name in ("implicit", "automatic"):
        error = np.max(np.abs(ends[name][:3] - ends["explicit"][:3]))
        evidence(TOPIC, f"{name} against explicit steps, the bar's place", error, 1e-5, "explicit steps", "m, rad")


@pytest.mark.slow
@pytest.mark.parametrize(
    "solver",
    often([Automatic(), ExplicitRungeKutta(), DiagonallyImplicit()], "Automatic", names=lambda it: type(it).__name__),
)
def test_the_loop_stays_one_kernel(solver):
    """XLA leaves out any loop that holds a call into a library."""
    mechanism = arrays(hanging(SOFT, contact=True, damping_ratio=0.02))
    program = run.lower(mechanism, jnp.asarray(0.1), solver).compile().compiled.as_text()
    assert " while(" in program
    inside = [line for line in program.splitlines() if "/while/" in line]
    assert len(inside) > 100
    for forbidden in (" custom-call(", " dot(", " scatter(", " fft(", " sort("):
        assert not [line for line in inside if forbidden in line]


@eqx.filter_jit
def contact_power(mechanism):
    """Contact forces of the ball pressed against the bar's end, and the rates of all that is stored and lost [W]."""
    state, _ = mechanism.start()
    closed = jnp.ones(1)
    n = mechanism.coordinates
    pressed = state.at[4].add(-0.0105).at[6:n].add(1e-4).at[n + 2].set(0.3).at[n + 6 : 2 * n].set(0.2)
    q, v = assemble(mechanism.system, pressed[:n], pressed[n : 2 * n])
    pressed = pressed.at[:n].set(q).at[n : 2 * n].set(v)
    forces = mechanism.contact_forces(mechanism.evaluate(pressed), closed)
    rate = mechanism.derivative(0.0, pressed, closed)
    return forces, jax.jvp(lambda y: mechanism.energy_at(mechanism.evaluate(y), closed), (pressed,), (rate,))[1]


def test_a_ball_pushes_the_bars_end_and_is_pushed(evidence):
    """Pressed together, with friction: what is stored and lost balances."""
    forces, rates = contact_power(arrays(hanging(SOFT, contact=True)))
    assert all(abs(float(force[0])) > 0.1 for pair in forces for force in pair)
    flows = [float(flow) for flow in jax.tree.leaves(rates)]
    assert max(abs(flow) for flow in flows) > 1.0
    evidence(
        TOPIC,
        "power at a contact on a flexible body, relative",
        abs(sum(flows)) / max(map(abs, flows)),
        1e-13,
        "energy balance",
    )
