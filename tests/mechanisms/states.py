"""Random states of the capture mechanism with the tip pressed into a flank or a rim."""

import functools

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from jaxbuffer import Scenario, replace, table2
from jaxbuffer.mechanisms.probe_cone.assembly import assemble
from jaxbuffer.multibody import assemble as put_on_constraints

PLACES = ("lower flank", "upper flank", "lower throat rim", "upper mouth rim")
TIPS = {"welded": False, "free": True}
assembled = eqx.filter_jit(put_on_constraints)
capture = eqx.filter_jit(assemble)  # one program in place of its many operations
RANDOM = {"buffer.c_A": 40.0, "buffer.c_T": 6.0, "contact.restitution": 0.6, "contact.friction": 0.4}


@functools.cache
def mechanism(free_tip=False, stabilisation=20.0, **choices):
    """Table 2 with more damping and loss, so that every term counts; ``choices``: paths with _ for the dot."""
    extra = {path.replace("_", ".", 1): value for path, value in choices.items()}
    design = replace(table2(), RANDOM | {"probe.free_tip": free_tip} | extra)
    return capture(design, Scenario(), stabilisation)


def pressed(mechanism, place, seed, consistent=True):
    """A state with the tip up to 20 µm deep at ``place`` and random motion, and its closed contacts.

    ``consistent``: on the constraints, in positions and velocities.
    """
    rng = np.random.default_rng(seed)
    design, cone = mechanism.parts.design, mechanism.parts.design.cone
    q = np.zeros(12)
    q[:3] = rng.normal(scale=0.1, size=3)
    reach = design.active.hinge_offset + design.buffer.cylinder_length / 2
    q[3:6] = q[0] + reach, q[1], rng.normal(scale=0.1)
    q[6:9] = q[3] + 0.15, q[4], rng.normal(scale=0.1)
    v = rng.normal(size=12) * np.tile([0.1, 0.1, 0.5], 4)
    if consistent:
        q, v = (np.array(x) for x in assembled(mechanism.system, jnp.asarray(q), jnp.asarray(v)))

    # The passive vehicle is put where its cone meets the tip.
    side = 1.0 if place.startswith("lower") else -1.0
    cos, sin = np.cos(cone.half_angle), np.sin(cone.half_angle)
    along, inward = np.array([-cos, -side * sin]), np.array([-sin, side * cos])
    slant, lean = rng.uniform(0.01, 0.06), 0.0
    if place.endswith("throat rim"):
        slant, lean = 0.0, -0.4
    elif place.endswith("mouth rim"):
        slant, lean = cone.length, 0.4
    away = np.cos(lean) * inward + np.sin(lean) * along
    edge = np.array([-cone.offset, -side * cone.throat_radius])
    local = edge + slant * along + (design.probe.tip_radius - rng.uniform(2e-6, 2e-5)) * away
    angle = rng.normal(scale=0.2)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    tip = q[6:8] + mechanism.parts.probe.front * np.array([np.cos(q[8]), np.sin(q[8])])
    q[9:12] = *(tip - turn @ local), angle
    spin = rng.normal(scale=3.0, size=mechanism.spins)
    memory = rng.uniform(0.3, 0.6, size=2)
    state = np.concatenate([q, v, spin, np.zeros(4), memory])
    return jnp.asarray(state), jnp.array([side > 0, side < 0], float)
