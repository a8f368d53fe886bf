"""The dropped bar and its plate as plane finite elements, from the touch on.

The bar is a rectangle of the round bar's area and second moment, two elements across; so is the plate, on simple
supports. Both are plane stress, each of its own width. The bar's lower corner touches by a penalty of constant
stiffness; nothing is damped. It begins level, at the angular speed of the rigid fall.
"""

import math
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._types import Scalar, stacked
from ...mechanisms.bar_drop import BarDrop, BarDropScenario
from ...structures import Elastic, FiniteElementSystem, Plane, Quads, State, advance, mises
from ...structures.contact import NodeContact, Segments

DURATION = 6e-3  # s
RECORDS = 600  # of a run, each the largest of the steps since the last
STEPS_OF_ELEMENT = 1  # steps of a record for each element along the bar
POISSON = 0.3


class MeshedDrop(NamedTuple):
    """``drop``: the bar drop that is meshed; ``along``: elements along the bar, and along the plate."""

    drop: BarDrop
    along: int = 60


class MeshedRun(NamedTuple):
    """Histories (records,) and numbers of one run.

    ``time`` from the touch [s]; ``height`` of the bar's lower corner above the plate, ``deflection`` of the plate
    under it, and ``slid``, the corner's way along the plate [m]; ``normal``, ``friction`` forces: the largest since
    the record before [N]; ``stress``: the largest of von Mises in the plate [Pa]; ``rise``: how high the bar's mean
    rotation would carry the end from here [m]; ``energy_error``: of all energy at the touch [-].
    """

    design: MeshedDrop
    time: Float[np.ndarray, " records"]
    height: Float[np.ndarray, " records"]
    deflection: Float[np.ndarray, " records"]
    slid: Float[np.ndarray, " records"]
    normal: Float[np.ndarray, " records"]
    friction: Float[np.ndarray, " records"]
    stress: Float[np.ndarray, " records"]
    rise: float
    energy_error: float


def follow(design: MeshedDrop, scenario: BarDropScenario) -> MeshedRun:
    """Follow six milliseconds from the touch on."""
    numbers = jax.tree.map(float, (design.drop, scenario))
    records, rise, share = (np.asarray(x) for x in _followed(*numbers, design.along))
    *histories, energy = records
    if not share < 1.0:
        raise ValueError(f"{design.along} elements along: the step is {share:.3g} of the critical one")
    error = float(np.max(np.abs(energy / energy[0] - 1.0)))
    fields: list[Any] = [design, *histories, float(rise), error]
    return MeshedRun(*fields)


@partial(jax.jit, static_argnames="along")
def _followed(drop: BarDrop, scenario: BarDropScenario, along: int) -> tuple[Array, Array, Array]:
    """Return histories (numbers, records), the rise [m], and the step's share of the critical one, by one compiled
    program."""
    system, start, corner, under = _assembled(drop, scenario, along)
    # The critical step goes with an element's length, so that the number of steps goes with that of elements.
    step = DURATION / (RECORDS * STEPS_OF_ELEMENT * along)

    def record(state: State, _: None) -> tuple[State, Array]:
        # Nothing moves by a segment's length within the 10 µs of a record: one search serves it (see `candidates`).
        near = system.search(state.displacement)

        def one(carry: Any, _: None) -> Any:
            state, normal, friction, stress, _ = carry
            state, instant = advance(system, state, step, near)
            force = instant.contacts[0].nodes[corner]
            # Each material has its part's width in its modulus, because the two differ: stresses are divided by it
            # again.
            worst = jnp.max(mises(instant.resistances[1].stress)) / drop.plate.width
            energy = sum(instant.energies, jnp.zeros(()))
            largest = (normal, force[1]), (friction, jnp.abs(force[0])), (stress, worst)
            return (state, *(jnp.maximum(*pair) for pair in largest), energy), None

        still = (jnp.zeros(()),) * 4
        (state, *numbers), _ = jax.lax.scan(one, (state, *still), length=STEPS_OF_ELEMENT * along)
        moved = state.displacement
        gap, slid = moved[corner, 1] - moved[under, 1], moved[corner, 0] - moved[under, 0]
        return state, jnp.stack([state.time, gap, -moved[under, 1], slid, *numbers])

    last, records = jax.lax.scan(record, start, length=RECORDS)
    rise = _rise(system, last, scenario.gravity, drop.bar.length, 3 * (along + 1))
    # The step's share is computed in the program, so it is judged outside of it.
    return records.T, rise, step / system.stable_step()


def _rise(system: FiniteElementSystem, last: State, gravity: Scalar, length: Scalar, count: int) -> Array:
    """Return how high the mean rotation of the bar, its first ``count`` nodes, would carry its end [m]: v² = 3 g h."""
    mass, at, v = (x[:count] for x in (system.mass[:, 0], system.positions + last.displacement, last.velocity))
    # The hinge is the origin: angular momentum over moment of inertia is the mean rotation's speed.
    spin = jnp.sum(mass * (at[:, 0] * v[:, 1] - at[:, 1] * v[:, 0])) / jnp.sum(mass * jnp.sum(at**2, axis=1))
    sine = jnp.sum(mass * at[:, 1]) / jnp.sum(mass * at[:, 0])
    return length * sine + jnp.sign(spin) * (length * spin) ** 2 / (3.0 * gravity)


def _assembled(drop: BarDrop, scenario: BarDropScenario, along: int) -> tuple[FiniteElementSystem, State, int, int]:
    """Return the system, its start, the bar's lower corner and the plate's node under it."""
    bar, plate = drop.bar, drop.plate
    deep = bar.diameter * math.sqrt(12.0) / 4.0  # of the rectangle with the circle's area and second moment
    wide = math.pi / 4.0 * bar.diameter**2 / deep
    places, corners = block(along)
    first = places * stacked([bar.length, deep])[None]
    second = places * stacked([plate.length, plate.thickness])[None]
    shift = stacked([bar.length - 0.5 * plate.length, -0.5 * (deep + plate.thickness)])
    count, positions = len(places), jnp.concatenate([first, second + shift[None]])
    parts = tuple(
        Plane(
            Quads.of(positions, corners + offset),
            Elastic(part.density * width, part.young_modulus * width, POISSON, "stress"),
        )
        for part, width, offset in ((bar, wide, 0), (plate, plate.width, count))
    )
    fixed = np.zeros((2 * count, 2), bool)
    fixed[1] = fixed[count + 1] = True  # the hinge and a support, in the middle of the thickness
    fixed[-2, 1] = True  # the other support
    mass = sum((part.mass() for part in parts), jnp.zeros(2 * count))
    corner, top = 3 * along, count + 3 * np.arange(along + 1) + 2
    surface = Segments(np.stack([top[1:], top[:-1]], axis=1))  # the plate is on its left
    touch = NodeContact(np.array([corner]), surface, "penalty", drop.impact.stiffness, drop.impact.friction)
    bar_mass = jnp.where(np.arange(2 * count) < count, mass, 0.0)  # the plate has sagged by its weight before
    weight = bar_mass[:, None] * stacked([0.0, -scenario.gravity])[None]
    system = FiniteElementSystem(positions, jnp.where(fixed, 0.0, 1.0 / mass[:, None]), parts, (touch,), load=weight)
    spin = jnp.sqrt(3.0 * scenario.gravity * scenario.height) / bar.length
    turning = spin * jnp.stack([first[:, 1], -first[:, 0]], axis=1)
    return system, system.start(jnp.concatenate([turning, jnp.zeros_like(second)])), corner, int(top[along // 2])


def block(along: int) -> tuple[np.ndarray, np.ndarray]:
    """Mesh a square from (0, -½) to (1, ½) by ``along`` times two elements: places, column by column from below, and
    corners counter-clockwise."""
    square = np.meshgrid(np.linspace(0.0, 1.0, along + 1), np.linspace(-0.5, 0.5, 3), indexing="ij")
    node = np.arange(3 * (along + 1)).reshape(along + 1, 3)
    corners = [node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]]
    return np.stack(square, axis=-1).reshape(-1, 2), np.stack([part.ravel() for part in corners], axis=1)
