"""Derivatives at maxima, where an instant is never known closely enough."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from in_short import often
from jaxbuffer.hybrid import UNMOVED, ExplicitRungeKutta, Kind, Log
from jaxbuffer.mechanisms.bar_drop import BAR_DROP
from jaxbuffer.run.moving import moving_maxima
from jaxbuffer.run.request import request

DELAYED = {
    "active.mass": 10.079,
    "active.inertia": 671250.0,
    "active.hinge_offset": 0.1365,
    "passive.mass": 48.599,
    "passive.inertia": 7.893,
    "buffer.k_A": 9465.9,
    "buffer.c_A": 13.476,
    "buffer.k_T": 518.75,
    "buffer.c_T": 12.023,
    "buffer.free_length": 0.1365,
    "buffer.cylinder_mass": 0.32171,
    "buffer.cylinder_length": 0.1365,
    "buffer.preload": 13.910,
    "probe.length": 0.2,
    "probe.rod_mass": 0.12673,
    "probe.tip_radius": 0.015,
    "probe.tip_mass": 0.18076,
    "cone.half_angle": 0.57611,
    "cone.offset": 0.096,
    "cone.throat_radius": 0.015,
    "cone.length": 0.0735,
    "contact.restitution": 0.69778,
    "contact.friction": 0.29816,
    "contact.slip_speed": 2.8536e-4,
}


@eqx.filter_jit  # once for all kinds of events
def of_a_delay(kind, guard_rate):
    """A bar's first state, its rate, and which position lies higher; the state at an event that is reached 3 s later a
    unit of the parameter, that position 0.5 m higher beside that, and its derivative."""
    system = request(BAR_DROP, jb.BarDrop(), jb.BarDropScenario(), 0.1).system
    row = system.first_evaluation()[0].state[None]
    contacts, observables = system.contact_count, len(system.observed)
    higher = system.places["q"].start
    rate = system.derivative(jnp.zeros(()), row[0], jnp.zeros(contacts))[None]

    def state(p):
        moved = row - 3.0 * p * rate
        log = Log.empty(2, row, contacts, observables)
        event = (jnp.asarray(x) for x in (True, kind, 0, 0.1))
        now = jnp.zeros(observables), guard_rate, jnp.zeros(contacts)
        log = log.append(*event, *now, moved.at[0, higher].add(0.5 * p), rate, jnp.asarray(False))
        return moving_maxima(system, log).rows[0, 0]

    return row[0], rate[0], higher, *jax.jvp(state, (0.0,), (1.0,))


@pytest.mark.parametrize(
    ("kind", "guard_rate", "left"),
    [(Kind.PEAK, 1.0, 0.0), (Kind.PEAK, UNMOVED, 1.0), (Kind.TOUCHDOWN, 1.0, 1.0), (Kind.RELEASE, 1.0, 1.0)],
    ids=["maximum", "no maximum of its own", "touchdown", "release"],
)
def test_of_a_mere_delay_nothing_is_left(kind, guard_rate, left):
    """All states are reached 3 s later a unit of the parameter, and one position lies 0.5 m higher beside that, which
    the motion does not change."""
    start, rate, higher, value, change = of_a_delay(np.asarray(int(kind)), np.asarray(guard_rate))
    rate = np.asarray(rate)
    assert rate[higher] == 0.0 and np.max(np.abs(rate)) > 1.0
    expected = -3.0 * left * rate
    expected[higher] += 0.5
    assert np.array_equal(value, start)
    assert np.allclose(change, expected, rtol=0.0, atol=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("solver", often(["automatic", "explicit"], "explicit"))
def test_a_hinge_force_of_microseconds_by_what_delays_its_impact(solver):
    """The tip slides across the cone, strikes the other flank after 0.45 s and pulls at the hinge for 8 µs. More
    friction delays that by 0.17 s a unit of its logarithm: within the 1e-13 s to which the maximum's time is known the
    force changes by a per cent of its derivative."""
    design = jb.replace(jb.table2(), DELAYED)
    scenario = jb.Scenario(
        approach_speed=0.18909, contact_distance=0.053214, misalignment=0.062206, passive_rate=-0.016877
    )
    how = {"solver": ExplicitRungeKutta() if solver == "explicit" else None}
    found = jb.sensitivity(design, scenario, wrt=("contact.friction",), duration=0.46, rtol=1e-9, certify="none", **how)
    of = list(found.quantities).index("peak_hinge_force")
    elasticity = found.gradients[of, 0] * 0.29816 / found.results[of]

    def tight(share):
        moved = jb.replace(design, {"contact.friction": 0.29816 * (1.0 + share)})
        return float(jb.simulate(moved, scenario, 0.46, rtol=1e-11, solver=ExplicitRungeKutta()).peak_hinge_force)

    near, far = ((tight(h) - tight(-h)) / (2.0 * h * found.results[of]) for h in (1e-3, 2e-3))
    assert elasticity == pytest.approx(near + (near - far) / 3.0, rel=1e-3)
