"""Smooth phases of the capture mechanism stepped in equal steps, for orders of convergence."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

import jaxbuffer as jb
from jaxbuffer.hybrid import StepTolerance
from jaxbuffer.hybrid.rungekutta.time_transform import TimeTransform
from jaxbuffer.mechanisms.probe_cone.assembly import assemble

# Weaker dampers than Table 2's, whose 0.8 ms would hide the order of explicit steps in rounding.
SWINGING = {"buffer.c_T": 0.02, "buffer.c_A": 1.0}


def arrays(tree):
    return jax.tree.map(lambda x: jnp.asarray(x, float), tree)


@eqx.filter_jit  # one program in place of its many operations
def started(design, scenario):
    """The mechanism, its state and closed contacts at the start."""
    mechanism = assemble(design, scenario)
    return mechanism, *mechanism.start()


def swing():
    """The mechanism after a push, out of contact: mechanism, state, open contacts."""
    mechanism, state, _ = arrays(started(jb.replace(jb.table2(), SWINGING), jb.Scenario()))
    state = np.array(state)
    state[[14, 17, 20, 18]] = -0.5, 0.8, 0.8, -0.1
    return mechanism, jnp.asarray(state), jnp.zeros(2)


def impact(speed=0.1):
    """The mechanism at its first touchdown: mechanism, state, closed contacts."""
    return arrays(started(jb.table2(), jb.Scenario(approach_speed=speed)))


def single(solver, mechanism, active, columns, rate, transform):
    """One step of a solver within a mode."""

    def field(time, columns):
        return mechanism.derivative(time, columns[:, 0], active)[:, None]

    stiff = mechanism.linearisation(jnp.zeros(()), columns[:, 0], active)
    which = solver.method_for(stiff, transform.length)
    allowance = StepTolerance(1e-13, 1e-13).allowance(columns.T, mechanism).T
    return solver.step(which, field, stiff, jnp.zeros(()), columns, rate, transform, allowance)


def stepper(solver, phase, rooted=False):
    """A function (duration [s], steps) → state after steps equal in time, or in its root, compiled once for all."""
    mechanism, state, active = phase

    @jax.jit
    def advance(duration, steps):
        columns = state[:, None]

        def body(i, carry):
            begin, end = duration * (i / steps) ** 2, duration * ((i + 1) / steps) ** 2
            even = TimeTransform.uniform(duration / steps)
            transform = TimeTransform.after_touchdown(begin, end - begin) if rooted else even
            out = single(solver, mechanism, active, *carry, transform)
            return out.end, out.rate

        rate = mechanism.derivative(jnp.zeros(()), state, active)[:, None]
        return jax.lax.fori_loop(0, steps, body, (columns, rate))[0][:, 0]

    return lambda duration, steps: advance(jnp.asarray(duration, float), jnp.asarray(steps))


def one_step(solver, phase):
    """A function (state, step [s]) → state at the end and estimate of its local error, compiled once."""
    mechanism, _, active = phase

    @jax.jit
    def take(state, step):
        rate = mechanism.derivative(jnp.zeros(()), state, active)[:, None]
        out = single(solver, mechanism, active, state[:, None], rate, TimeTransform.uniform(step))
        return out.end[:, 0], out.error[:, 0]

    return lambda state, step: take(state, jnp.asarray(step, float))
