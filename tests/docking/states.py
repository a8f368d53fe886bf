"""Docking mechanisms at an instant, without a run, and what they conserve there."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from jaxbuffer import Scenario, replace, table2
from jaxbuffer.mechanisms.assembled import Assembled
from mechanisms.states import capture

LATCH = {
    "latch.stiffness": 2e4,
    "latch.damping": 100.0,
    "latch.preload": 3.0,
    "latch.turn_stiffness": 50.0,
    "latch.turn_damping": 2.0,
}
REAL_BUFFER = {
    "buffer.preload": 1.5,
    "buffer.c_A2": 20.0,
    "buffer.rebound_factor": 3.0,
    "buffer.friction": 0.2,
    "buffer.rebound_stiffness": 2e4,
    "buffer.rebound_damping": 20.0,
}
CURVES = {
    "buffer.spring_curve": [[0.005, 2.0], [0.01, 6.0], [0.02, 20.0]],
    "buffer.damper_curve": [[0.02, 0.2], [0.05, 0.4], [0.2, 0.9]],
}


@eqx.filter_jit  # once for all states of a mechanism
def rates(assembled, state, active):
    """The state's rate, those of linear and angular momentum, and those of all energies."""
    rate = assembled.derivative(0.0, state, active)
    energy_at = lambda state: assembled.energy_at(assembled.evaluate(state), active)  # noqa: E731
    momentum, energy = (jax.jvp(of, (state,), (rate,))[1] for of in (assembled.momentum, energy_at))
    return rate, momentum, energy


class Instant(NamedTuple):
    """A mechanism in a state with its closed contacts, 1 and 0."""

    mechanism: Assembled
    state: jax.Array
    active: jax.Array

    @property
    def rate(self):
        return np.asarray(rates(*self)[0])

    def momentum_rates(self):
        """Rates of linear and angular momentum less what a thrust puts in, [N] and [N m]."""
        return rates(*self)[1]

    def energy_rate(self):
        """Rate of everything stored and lost less what is put in [W], and the largest of these flows."""
        flows = [float(flow) for flow in jax.tree.leaves(rates(*self)[2])]
        return sum(flows), max(map(abs, flows))


def own(assembled, state, name):
    """The numbers that the element of a name has in a state, or their rates in its rate, by their names."""
    k = [element.name for element in assembled.elements].index(name)
    return dict(zip(assembled.elements[k].variables, np.asarray(state)[assembled.places[f"element {k}"]], strict=True))


def mechanism(values=None, **scenario):
    """Table 2 with other ``values`` by path."""
    return capture(replace(table2(), values or {}), Scenario(**scenario))


def moving(assembled, stroke=0.004, stroke_rate=-0.06, ahead=0.0005, closed=(), **extras):
    """The mechanism in a state in which everything moves, on its constraints: the tip has crossed the capture plane by
    ``ahead`` [m], off the axis, the stroke is as given; ``closed``: names of closed contacts; ``extras`` by name."""
    design, probe = assembled.parts.design, assembled.parts.probe
    cylinder = design.buffer
    turned, spin = 0.03, 0.2  # of cylinder and probe
    along, across = np.array([np.cos(turned), np.sin(turned)]), np.array([-np.sin(turned), np.cos(turned)])
    half, a = cylinder.cylinder_length / 2, design.active.hinge_offset
    hinge, hinge_velocity = np.array([-0.4, 0.01]), np.array([0.11, -0.02])
    s_angle, s_spin = -0.02, -0.1
    s_along, s_across = np.array([np.cos(s_angle), np.sin(s_angle)]), np.array([-np.sin(s_angle), np.cos(s_angle)])
    s, s_velocity = hinge - a * s_along, hinge_velocity - a * s_spin * s_across
    b, b_velocity = hinge - half * along, hinge_velocity - half * spin * across
    reach = -half + cylinder.free_length - stroke + probe.rear  # of the probe's centre of mass before the cylinder's
    p, p_velocity = b + reach * along, b_velocity + reach * spin * across - stroke_rate * along
    tip = p + probe.front * along
    t_angle, t_spin = 0.05, -0.3
    turn = np.array([[np.cos(t_angle), -np.sin(t_angle)], [np.sin(t_angle), np.cos(t_angle)]])
    plane = -design.cone.offset - design.probe.tip_radius * np.sin(np.pi / 4)
    t = tip - turn @ np.array([plane + ahead, 0.0007])
    q = [*s, s_angle, *b, turned, *p, turned, *t, t_angle]
    v = [*s_velocity, s_spin, *b_velocity, spin, *p_velocity, spin, 0.01, 0.02, t_spin]
    rest = np.zeros(max(place.stop for place in assembled.places.values()) - 26)
    if assembled.spins:
        rest[0] = 0.7
    state = np.array([*q, *v, *rest, 0.1, 0.1])
    for k, element in enumerate(assembled.elements):
        for i, name in enumerate(element.variables):
            if name in extras:
                state[assembled.places[f"element {k}"].start + i] = extras[name]
    active = np.array([float(name in closed) for name in assembled.contact_names])
    return Instant(assembled, jnp.asarray(state), jnp.asarray(active))
