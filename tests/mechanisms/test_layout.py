"""Where the numbers of elements stand in the state: of balls that spin, a latch, a thrust and a drive, in any order."""

import itertools

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from jaxbuffer.contact import BallPair, RegularisedCoulomb, Segment
from jaxbuffer.contact.laws import Hertz
from jaxbuffer.elements import BallContact, Drive, Latch, Thrust
from jaxbuffer.errors import InputError
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.multibody import Body, DrivenAngle, System

PAIR = BallPair(0.1, Segment(0.0, -3.0, 0.0, 1.0, 6.0), -1.0, Hertz(1e6), RegularisedCoulomb(0.0, 1.0))
PARTS = (
    BallContact(0, 1, PAIR, (0.5, 0.0), spin_inertia=0.2, name="rolling"),
    BallContact(1, 0, PAIR, (0.0, 2.0), name="fixed"),
    Latch(0, 1, (0.0, 0.0), plane=0.3, seat=(0.2, 0.1), stiffness=50.0),
    Thrust(1, 7.0, 2.0),
    Drive(DrivenAngle(0, 1, lambda time: 0.1 * time)),
)
ORDERS = list(itertools.permutations(range(5)))[::17]


@eqx.filter_jit
def mechanism(order):
    system = System((Body(2.0, 0.3), Body(3.0, 0.5)))
    elements = tuple(PARTS[k] for k in order)
    return Assembled(system, jnp.zeros(6), jnp.zeros(6), elements, momentum_size=1.0, rest_threshold=1e-3)


@eqx.filter_jit
def placed(made, own, lost):
    """The state with its elements' numbers; for each element those, the state with others, and the others."""
    layout = made.layout
    state = layout.state(q=jnp.full(6, 200.0), v=jnp.full(6, 300.0), lost=lost, first_energy=400.0, own=own, time=500.0)
    others = [layout.with_own(state, k, mine + 1000.0) for k, mine in enumerate(own)]
    return state, [(layout.own(state, k), other, layout.own(other, k)) for k, other in enumerate(others)]


@pytest.mark.quick
@pytest.mark.parametrize("order", ORDERS, ids=str)
def test_each_number_has_a_place_of_its_own(order):
    made = mechanism(order)
    own = [np.arange(len(element.variables)) + 10.0 * k for k, element in enumerate(made.elements)]
    lost = [100.0] * len(made.loss_names)
    state, elements = placed(made, list(map(jnp.asarray, own)), lost)
    assert sorted(np.asarray(state)) == sorted(
        [200.0] * 6 + [300.0] * 6 + lost + [400.0, 500.0] + [*np.concatenate(own)]
    )
    for mine, (found, other, moved) in zip(own, elements, strict=True):
        assert_array_equal(found, mine)
        assert_array_equal(moved, mine + 1000.0)
        assert np.sum(np.asarray(other) != np.asarray(state)) == len(mine), "no other number has changed"


@pytest.mark.quick
@pytest.mark.parametrize("order", ORDERS, ids=str)
def test_contacts_with_impacts_come_first_and_each_element_finds_its_own(order):
    made = mechanism(order)
    balls = [PARTS[k].name for k in order if k < 2]
    assert made.contact_names[:2] == tuple(balls) == made.observed[:2] and made.impact_contacts == 2
    closed = jnp.asarray(np.arange(5.0))
    for name in made.contact_names:
        owner = next(it for it in made.elements if name in [switch.name for switch in it.switches])
        place = [switch.name for switch in owner.switches].index(name)
        assert float(made.closed_switches(closed, owner.name)[place]) == made.contact_names.index(name)


@pytest.mark.quick
def test_a_memory_that_follows_in_no_time_is_refused():
    with pytest.raises(InputError, match="memory_time of the contact 'contact' is nan s"):
        BallContact(0, 1, PAIR, memory_time=float("nan"))
