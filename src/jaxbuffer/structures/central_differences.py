"""Explicit time stepping by central differences (M126, M127), in blocks of steps between searches for contact."""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import equinox.internal as eqxi
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .._types import Scalar
from .acoustics import Liquid
from .contact.forces import NodeContactForces, contact_forces
from .perforated import Through
from .structure import Resistance
from .system import Energies, FiniteElementSystem, Instant, Near, State

T = TypeVar("T")
BLOCK = 50  # steps between two searches
KEPT = 512  # states between blocks that a backward run goes back to, at most


def advance(system: FiniteElementSystem, state: State, step: Scalar, near: Near) -> tuple[State, Instant]:
    """Take one step by central differences (M126).

    **Arguments:** ``system``; ``state`` at t; ``step`` [s]; ``near``: the contacts' candidates
    (see `FiniteElementSystem.search`).

    **Returns:** the state at t + step, and what is known of t.
    """
    positions = system.positions + state.displacement
    resistances = tuple(
        group.resist(state.displacement, history)
        for group, history in zip(system.elements, state.histories, strict=True)
    )
    mass = system.mass
    weight = mass * system.gravity[None]
    constant = weight if system.load is None else weight + system.load
    residual = constant - sum((part.forces for part in resistances), jnp.zeros_like(positions))
    pressure, resistance = state.pressure, jnp.zeros(0)
    if (liquid := system.liquid) is not None:
        pressure = liquid.met(pressure, state.displacement, state.raised)
        if liquid.plate is not None:
            resistance = liquid.plate.resistance(state.velocity, state.through, step)
        residual = _with_liquid(residual, system, liquid, pressure, resistance, positions)
    if system.gas is not None:
        residual = residual + system.gas.push(positions)
    # Contacts come last, because what closes a pair within the step depends on all other forces (M140).
    layers, contacts, pressing = _pressing(system, state, positions, residual, step, near)
    velocity = state.velocity + step * (system.inverse_mass * (residual + pressing))
    # Velocities stand half a step beside the displacements: their mean is that of the instant.
    between = 0.5 * (state.velocity + velocity)
    wet, holes = _liquid_after(liquid, state, step, pressure, resistance, positions, velocity)
    energies = Energies(
        # The velocities half a step before and after, not a square: their energies add up to a constant (M127).
        kinetic=0.5 * jnp.sum(mass * state.velocity * velocity),
        stored=_sum(resistances, "stored"),
        plastic=_sum(resistances, "plastic"),
        # This instant's forces have done half of their work over the step before, and do half over the next one (M127).
        contact=state.contact_work - 0.5 * step * jnp.sum(pressing * state.velocity),
        liquid=_liquid_energy(system, state, pressure, wet.impulse) + holes.kinetic,
        potential=-jnp.sum(constant * state.displacement),
        released=state.released,
        holes=state.lost + holes.half,
    )
    known = state.time, state.displacement, between
    instant = Instant(*known, resistances, contacts, layers, pressure, energies)
    after = State(
        state.time + step,
        state.displacement + step * velocity,
        velocity,
        tuple(part.history for part in resistances),
        *wet,
        holes.after,
        tuple(forces.over_step for forces in contacts),
        state.contact_work - step * jnp.sum(pressing * between),
        state.released + _sum(resistances, "released"),
        state.lost + holes.whole,
    )
    return after, instant


class Wet(NamedTuple):
    """A liquid after a step: see `State`."""

    pressure: Float[Array, " liquid"]
    rate: Float[Array, " liquid"]
    impulse: Float[Array, " liquid"]
    raised: Float[Array, " surface"]


def _pressing(
    system: FiniteElementSystem, state: State, positions: Array, residual: Array, step: Scalar, near: Near
) -> tuple[tuple[NodeContactForces, ...], tuple[NodeContactForces, ...], Float[Array, "nodes 2"]]:
    """Return the forces of each layer and of each contact, one after the other, and all of them on the nodes [N]."""
    layers = tuple(layer.forces(positions, state.velocity) for layer in system.layers)
    pressing, contacts = sum((forces.nodes for forces in layers), jnp.zeros_like(positions)), list[NodeContactForces]()
    for contact, candidates, before in zip(system.contacts, near, state.pressed, strict=True):
        forces = contact_forces(
            contact, positions, state.velocity, residual + pressing, system.inverse_mass, step, candidates, before
        )
        contacts.append(forces)
        pressing = pressing + forces.nodes
    return layers, tuple(contacts), pressing


def _with_liquid(
    forces: Array, system: FiniteElementSystem, liquid: Liquid, pressure: Array, resistance: Array, positions: Array
) -> Float[Array, "nodes 2"]:
    """Add the forces of the liquid on wall and plate [N]."""
    static, nodes = system.static_pressure, len(positions)
    if liquid.follows:
        forces = forces + liquid.push(pressure, nodes, positions)
        # On the wall at rest the static pressure is a constant force, whose work is known in closed form.
        forces = forces if static is None else forces + liquid.push(static, nodes)
    else:
        forces = forces + liquid.push(pressure if static is None else pressure + static, nodes)
    if liquid.cover is not None:
        forces = forces + liquid.cover.push(pressure[liquid.cover.surface], nodes)
    if liquid.plate is not None:
        forces = forces + liquid.plate.push(pressure, resistance, nodes)
    return forces


def _liquid_after(
    liquid: Liquid | None,
    state: State,
    step: Scalar,
    pressure: Array,
    resistance: Array,
    positions: Array,
    velocity: Array,
) -> tuple[Wet, Through]:
    """Return the liquid after a step, and what has flown through a plate in it."""
    holes = Through.none(state.through)
    if liquid is None:
        return Wet(pressure, state.pressure_rate, state.impulse, state.raised), holes
    impulse = state.impulse + step * pressure
    if liquid.plate is not None:
        holes = liquid.plate.flow(pressure, resistance, state.through, (state.velocity, velocity), step)
    if liquid.follows:  # half a step later: with the wall half way, the area that it sweeps is exact
        rate = liquid.rate(impulse, velocity, holes.after, positions + 0.5 * step * velocity)
    else:
        # The accelerations at t, by M126 from the velocities half a step before and after.
        wall, through = (velocity - state.velocity) / step, (holes.after - state.through) / step
        rate = state.pressure_rate + step * liquid.acceleration(pressure, wall, through)
    raised = state.raised + step * liquid.rising(impulse, velocity, holes.after)
    return Wet(pressure + step * rate, rate, impulse, raised), holes


def _sum(resistances: tuple[Resistance, ...], name: str) -> Float[Array, ""]:
    """Sum a number over all groups of elements."""
    return sum((getattr(part, name) for part in resistances), jnp.zeros(()))


def _liquid_energy(system: FiniteElementSystem, state: State, pressure: Array, impulse: Array) -> Float[Array, ""]:
    """Return the energy of the liquid, of what its static pressure has done, and of the gas above it [J]."""
    own = jnp.zeros(()) if system.gas is None else system.gas.energy(system.positions + state.displacement)
    if system.liquid is None:
        return own
    own = own + system.liquid.energy(pressure, state.impulse, impulse)
    if system.static_pressure is None:
        return own
    return own - jnp.sum(system.liquid.push(system.static_pressure, len(system.positions)) * state.displacement)


def march(
    system: FiniteElementSystem,
    start: State,
    step: Scalar,
    blocks: Int[Array, ""] | int,
    observe: Callable[[T, Instant], T],
    observations: T,
    *,
    until: Callable[[T], Bool[Array, ""]] = lambda observations: jnp.asarray(False),
    backwards: bool = False,
) -> tuple[State, T]:
    """Take many steps, and search for contact between blocks of them.

    **Arguments:**

    - ``system``, ``start``: what moves, and from where.
    - ``step``: [s], below `FiniteElementSystem.stable_step`.
    - ``blocks``: how many blocks of steps.
    - ``observe``: (observations so far, an instant) → observations with those of the instant; ``observations``: the
      first ones.
    - ``until``: (observations) → whether they are enough; called after each block.
    - ``backwards``: whether reverse derivatives will be asked for, and no forward ones. States are then kept between
      blocks, all of them up to `KEPT` blocks, and within a block before each step; the steps are taken again.

    **Returns:** the state after the last step, and the observations. A state that is not finite ends the loop.
    """

    def one(carry: tuple[State, T], near: Near) -> tuple[State, T]:
        state, observations = carry
        after, instant = advance(system, state, step, near)
        return after, observe(observations, instant)

    again = jax.checkpoint(one) if backwards else one

    def body(carry: tuple[Array, State, T]) -> tuple[Array, State, T]:
        done, state, observations = carry
        near = jax.lax.stop_gradient(system.search(state.displacement))  # a choice has no derivative
        state, observations = jax.lax.scan(lambda c, _: (again(c, near), None), (state, observations), length=BLOCK)[0]
        return done + 1, state, observations

    def going(carry: tuple[Array, State, T]) -> Array:
        done, state, observations = carry
        return (done < blocks) & jnp.all(jnp.isfinite(state.displacement)) & ~until(observations)

    first: Any = (jnp.asarray(0), start, observations)
    # JAX's own `while_loop` has no reverse derivative.
    if backwards:
        _, state, observations = eqxi.while_loop(going, body, first, kind="checkpointed", checkpoints=KEPT)
    else:
        _, state, observations = jax.lax.while_loop(going, body, first)
    return state, observations
