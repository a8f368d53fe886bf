"""Whole captures from any start, for statements about what a capture may not depend on.

One compiled program a tip serves every example: designs, scenarios, starts and the stabilisation are traced.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from hypothesis import strategies as st
from jaxtyping import Array, Float

import jaxbuffer as jb
from jaxbuffer.hybrid import Options, Status, StepTolerance, solve
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.energy import Balance
from jaxbuffer.mechanisms.history import History
from jaxbuffer.mechanisms.impacts import Impacts
from jaxbuffer.mechanisms.outcome import outcome_code
from jaxbuffer.mechanisms.probe_cone.assembly import assemble
from jaxbuffer.mechanisms.run import Maxima
from jaxbuffer.run.conservation import balance
from jaxbuffer.run.history import history
from jaxbuffer.run.impacts import impacts
from jaxbuffer.run.maxima import maxima, places_of
from jaxbuffer.run.readings import readings
from jaxbuffer.run.stepper import HISTORY_STEPS
from jaxbuffer.run.survey import survey

RTOL = 1e-10
VECTORS = np.arange(8).reshape(4, 2) + np.arange(4)[:, None]  # where (x, y) of the four bodies are in q
TURNS = np.arange(2, 12, 3)


class Started(Assembled):
    """The capture mechanism from a given state with given contacts."""

    state: Float[Array, " state"] | None = None
    flanks: Float[Array, " flanks"] | None = None

    def first_evaluation(self):
        return self.evaluate(self.state), self.flanks


class Seen(NamedTuple):
    """What a run shows: its outcome, largest values, impacts, conservation, and its accepted steps."""

    outcome: Array
    end: Array
    maxima: Maxima
    impacts: Impacts
    balance: Balance
    steps: History
    count: Array


def started(design, scenario, stabilisation, state, flanks):
    return Started(**vars(assemble(design, scenario, stabilisation)), state=state, flanks=flanks)


@eqx.filter_jit
def _watch(parameters, duration, rtol) -> Seen:
    options = Options(
        tolerance=StepTolerance(rtol, rtol), event_time=0.1 * rtol, keep=HISTORY_STEPS, max_steps=HISTORY_STEPS
    )
    result = solve(started, parameters, duration, options)
    mechanism = started(*parameters)
    log, places, by_guard = result.log, places_of(mechanism, result.log), result.status < Status.TIMEOUT
    read, last = readings(mechanism, None, result.start, log, places.slots, by_guard), jnp.maximum(log.count - 1, 0)
    seen = survey(mechanism, log).with_forces(jnp.append(places.slots, last), read.observables)
    return Seen(
        outcome_code(jb.Outcome, mechanism.end_outcomes, result.status),
        log.time[last],
        maxima(mechanism, log, places, read),
        impacts(mechanism, log, seen),
        balance(mechanism, read, log, seen.drift)[1],
        history(mechanism, result.steps),
        result.accepted,
    )


def start_of(design, scenario):
    """State and closed contacts as the scenario starts them, as NumPy arrays."""
    state, closed = _start(*_arrays((design, scenario)))
    return np.array(state), np.array(closed)


@jax.jit
def _start(design, scenario):
    return assemble(design, scenario).start()


def watch(design, scenario, start=None, duration=8.0, stabilisation=20.0, rtol=RTOL) -> Seen:
    """Run a capture from ``start`` (state, closed contacts; default: the scenario's) and show it."""
    parameters = (design, scenario, stabilisation, *(start_of(design, scenario) if start is None else start))
    seen = _watch(_arrays(parameters), jnp.asarray(duration, float), jnp.asarray(rtol, float))
    ended = (jb.Outcome["captured"], jb.Outcome["escaped"], jb.Outcome["timeout"])
    assert int(seen.outcome) in map(int, ended), "the run failed"
    return seen._replace(steps=jax.tree.map(lambda x: np.asarray(x)[: int(seen.count)], seen.steps))


def _arrays(tree):
    return jax.tree.map(lambda x: jnp.asarray(x, float), tree)


def _log(low, high):
    return st.floats(np.log(low), np.log(high)).map(lambda x: float(np.exp(x)))


@st.composite
def cases(draw, free_tip=False):
    """A design and a scenario over the ranges an engineer would search."""
    design = jb.replace(
        jb.table2(),
        {
            "buffer.k_A": draw(_log(200, 2000)),
            "buffer.c_A": draw(_log(2, 30)),
            "buffer.k_T": draw(_log(100, 1000)),
            "buffer.c_T": draw(_log(0.5, 10)),
            "probe.tip_mass": draw(_log(0.02, 0.2)),
            "probe.free_tip": free_tip,
            "contact.restitution": draw(st.floats(0.5, 1.0)),
            "contact.friction": draw(st.floats(0.0, 0.4)),
        },
    )
    scenario = jb.Scenario(
        approach_speed=draw(st.floats(0.06, 0.25)),
        contact_distance=draw(st.floats(0.015, 0.05)),
        misalignment=draw(st.floats(-0.06, 0.06)),
        passive_rate=draw(st.floats(-0.006, 0.006)),
    )
    return design, scenario


def difference(seen: Seen, expected: Seen, delay=0.0, swapped=False, units=(1.0, 1.0, 1.0)) -> float:
    """Largest relative difference between two runs over outcome, times, impacts and maxima; infinite where outcomes,
    flanks or numbers of impacts differ.

    ``delay`` [s] of ``seen``; ``swapped``: lower for upper flank; ``units``: of time, force and length in ``seen``.
    """
    time, force, length = units
    n = int(expected.impacts.count)
    flank = np.asarray(expected.impacts.contact[:n])
    told = np.asarray(seen.impacts.contact[:n])
    if (
        int(seen.outcome) != int(expected.outcome)
        or int(seen.impacts.count) != n
        or not np.array_equal(told, 1 - flank if swapped else flank)
    ):
        return np.inf
    pairs = [
        (seen.end, time * expected.end + delay),
        (seen.impacts.time[:n], time * expected.impacts.time[:n] + delay),
        (seen.maxima.peak_force, force * expected.maxima.peak_force),
        (seen.maxima.others["hinge_force"], force * expected.maxima.others["hinge_force"]),
        (seen.maxima.others["buffer_force"], force * expected.maxima.others["buffer_force"]),
        (seen.maxima.others["stroke"], length * expected.maxima.others["stroke"]),
        (seen.maxima.others["hinge_angle"], expected.maxima.others["hinge_angle"]),
        (seen.impacts.peak_force[:n], force * expected.impacts.peak_force[:n]),
    ]
    return max(float(np.max(np.abs(a - np.asarray(b))) / np.max(np.abs(b))) for a, b in pairs)
