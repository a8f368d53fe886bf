"""From a run's log to the quantities of the model's section 7: each a plain function of located states, differentiable
because the states carry their sensitivities."""

import dataclasses
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .integrate import Kind, Log
from .mechanisms.assembly import N
from .mechanisms.capture import CaptureMechanism
from .multibody import Kinematics

FLANKS = 2
HINGE_FORCE, BUFFER_FORCE, STROKE, HINGE_ANGLE = 2, 3, 4, 5  # observables, after the contact forces of both flanks


class Maxima(NamedTuple):
    """Largest values over a run: contact force [N] with its time [s] and flank, hinge force [N], buffer force [N],
    stroke [m], hinge angle [rad]."""

    peak_force: Float[Array, ""]
    peak_time: Float[Array, ""]
    peak_flank: Int[Array, ""]
    hinge_force: Float[Array, ""]
    buffer_force: Float[Array, ""]
    stroke: Float[Array, ""]
    hinge_angle: Float[Array, ""]


def state_at(log: Log, slot: Int[Array, ""]) -> Float[Array, " state"]:
    """The state at one entry of the log."""
    return log.rows[slot, 0]


def state_of_maximum(mechanism: CaptureMechanism, log: Log, slot: Int[Array, ""]) -> Float[Array, " state"]:
    """The state at one entry of the log, with the derivative that a maximum there has.

    Right after a touchdown with a jump a force may be largest without being stationary: the state's derivative then
    goes with the touchdown.
    """
    state = state_at(log, slot)
    if not mechanism.jumps:
        return state
    touchdown = log.kind[slot] == Kind.TOUCHDOWN
    late = mechanism.time_to_contact(state, log.which[slot] % FLANKS)
    return state + mechanism.derivative(log.time[slot], state, log.active[slot]) * jnp.where(touchdown, late, 0.0)


def maxima(mechanism: CaptureMechanism, log: Log) -> Maxima:
    """The largest values over all located events and the end.

    By the envelope theorem a maximum's derivative needs the state's at fixed time only; its time's needs the slope's.
    """

    def observe(slot: Array) -> tuple[Array, Array]:
        state, active = state_of_maximum(mechanism, log, slot), log.active[slot]
        rate = mechanism.derivative(log.time[slot], state, active)
        return mechanism.observables(state, rate, active), rate

    # Any entry may hold a maximum: of two at one instant only one is logged under its own name, and a quantity may be
    # largest at the end.
    used = jnp.arange(log.kind.shape[0]) < log.count
    contact = jnp.max(log.values[:, :FLANKS], axis=1, keepdims=True)
    candidates = jnp.concatenate([contact, log.values[:, FLANKS:]], axis=1)
    slots = jnp.argmax(jnp.where(used[:, None], candidates, -jnp.inf), axis=0)
    flank = jnp.argmax(log.values[slots[0], :FLANKS])
    columns = jnp.stack([flank, *map(jnp.asarray, (HINGE_FORCE, BUFFER_FORCE, STROKE, HINGE_ANGLE))])
    seen, rates = jax.vmap(observe)(slots)
    value = seen[jnp.arange(5), columns]
    return Maxima(value[0], _peak_time(mechanism, log, slots[0], flank, rates[0]), flank, *value[1:])


def _peak_time(
    mechanism: CaptureMechanism, log: Log, slot: Int[Array, ""], flank: Int[Array, ""], rate: Float[Array, " state"]
) -> Float[Array, ""]:
    """When a contact force is largest, with the derivative -(∂slope/∂p)/(dslope/dt)."""
    state, active = state_at(log, slot), log.active[slot]
    slope = jax.jvp(lambda y: mechanism.contact(mechanism.kinematics(y), y, active).normal, (state,), (rate,))[1]
    its_own = (log.kind[slot] == Kind.PEAK) & (log.which[slot] == flank)
    if mechanism.jumps:
        touchdown = (log.kind[slot] == Kind.TOUCHDOWN) & (log.time[slot] > 0.0)
        slope = jnp.where(touchdown, mechanism.gaps(state), slope)
        its_own = its_own | touchdown
    return _shifted(log.time[slot], -slope[flank], jnp.where(its_own, log.guard_rate[slot], jnp.inf))


def moving_events(mechanism: CaptureMechanism, log: Log, by_guard: Bool[Array, ""]) -> Log:
    """The same log, whose events move with the parameters: touchdowns, releases and an end by a guard at the time the
    guard crosses zero, and the last state at the end's own time instead of a fixed one. Values stay as they are."""
    last = jnp.maximum(log.count - 1, 0)
    flank = log.which % FLANKS
    gap = jax.vmap(lambda row, flank: mechanism.gaps(row)[flank])(log.rows[:, 0], flank)
    touch = (log.kind == Kind.TOUCHDOWN) & (log.time > 0.0)  # a run that starts in contact does so at t = 0
    guard = jnp.where(touch, -gap, jnp.where(log.kind == Kind.RELEASE, gap, 0.0))
    end, active = state_at(log, last), log.active[last]
    terminal = mechanism.terminals(end)[jnp.clip(log.which[last], 0, 1)]
    guard = guard.at[last].set(jnp.where(by_guard, terminal, guard[last]))
    time = jax.vmap(_shifted)(log.time, guard, log.guard_rate)
    fixed, at = jax.lax.stop_gradient((mechanism, end))  # no derivative of the rate is asked for
    rate = fixed.derivative(log.time[last], at, active)
    return dataclasses.replace(log, time=time, rows=log.rows.at[last, 0].set(_carried(end, rate, time[last])))


@jax.custom_jvp
def _shifted(time: Array, guard: Array, rate: Array) -> Float[Array, ""]:
    """An event's time: the located one, with the derivative of where the guard crosses zero."""
    return time


@_shifted.defjvp
def _shifted_jvp(primals: tuple, tangents: tuple) -> tuple[Array, Array]:
    (time, _, rate), (time_moves, guard_moves, _) = primals, tangents
    return time, time_moves - guard_moves / rate


@jax.custom_jvp
def _carried(state: Array, rate: Array, time: Array) -> Float[Array, " state"]:
    """A state whose time moves: the same one, with the derivative at the moving time."""
    return state


@_carried.defjvp
def _carried_jvp(primals: tuple, tangents: tuple) -> tuple[Array, Array]:
    return primals[0], tangents[0] + primals[1] * tangents[2]


class Impacts(eqx.Module):
    """Touchdowns in order, an entry each; slots beyond ``count`` are padding (flank -1, zeros).

    ``time`` [s], ``flank`` (0 lower, 1 upper), ``approach_speed`` δ̇⁻ [m/s], ``peak_force`` [N] until the flank's next
    touchdown, ``release_time`` [s] (NaN where the run ended in contact).
    """

    time: Float[Array, " slots"]
    flank: Int[Array, " slots"]
    approach_speed: Float[Array, " slots"]
    peak_force: Float[Array, " slots"]
    release_time: Float[Array, " slots"]
    count: Int[Array, ""]


def impacts(mechanism: CaptureMechanism, log: Log) -> Impacts:
    """All impacts of a run whose log's events move (`moving_events`)."""
    touch = log.kind == Kind.TOUCHDOWN

    def forces(row: Array, active: Array) -> Array:
        return mechanism.contact(mechanism.kinematics(row), row, active).normal

    flank = log.which % FLANKS
    speed = jax.vmap(lambda row, flank: mechanism.memory(row)[flank])(log.rows[:, 0], flank)
    top, release = _impact_ends(log)
    highest = jax.vmap(lambda slot, flank: forces(state_of_maximum(mechanism, log, slot), log.active[slot])[flank])(
        top, flank
    )
    peak = jnp.maximum(highest, 0.0)

    picked = jnp.argsort(~touch, stable=True)
    present = touch[picked]
    return Impacts(
        time=jnp.where(present, log.time[picked], 0.0),
        flank=jnp.where(present, log.which[picked], -1),
        approach_speed=jnp.where(present, speed[picked], 0.0),
        peak_force=jnp.where(present, peak[picked], 0.0),
        release_time=jnp.where(present, release[picked], 0.0),
        count=jnp.sum(touch),
    )


def _impact_ends(log: Log) -> tuple[Int[Array, " slots"], Float[Array, " slots"]]:
    """For the slot of each touchdown: the slot where that flank's force is largest until its next touchdown, and the
    time of its release [s] (NaN where there is none). One pass over the entries in use."""
    slots, flanks = log.kind.shape[0], jnp.arange(FLANKS)
    force = log.values[:, :FLANKS]

    def visit(carry: tuple[Array, Array, Array, Array]) -> tuple[Array, Array, Array, Array]:
        slot, under_way, top, release = carry
        mine = flanks == log.which[slot]
        under_way = jnp.where(mine & (log.kind[slot] == Kind.TOUCHDOWN), slot, under_way)
        for flank in range(FLANKS):
            touchdown = under_way[flank]
            better = (touchdown < slots) & (force[slot, flank] > force[top[touchdown], flank])
            top = top.at[touchdown].set(jnp.where(better, slot, top[touchdown]), mode="drop")
            releases = mine[flank] & (log.kind[slot] == Kind.RELEASE)
            release = release.at[touchdown].set(jnp.where(releases, log.time[slot], release[touchdown]), mode="drop")
        return slot + 1, under_way, top, release

    begin = (jnp.asarray(0), jnp.full(FLANKS, slots), jnp.arange(slots), jnp.full(slots, jnp.nan))
    _, _, top, release = jax.lax.while_loop(lambda carry: carry[0] < log.count, visit, begin)
    return top, release


def throat(mechanism: CaptureMechanism, log: Log, duration: Float[Array, ""]) -> tuple[Array, Array]:
    """How far the tip centre is before the capture plane at the end of the run [m], and the capture's margin [m]: how
    far beyond that plane it would be at ``duration``, going on from the end as fast as it goes there.

    The margin is positive exactly if the run ends captured (or would, going on). Its value and slope are continuous
    where capture, or escape, happens just at ``duration``; grazing the plane without crossing it is a jump.
    """
    last = jnp.maximum(log.count - 1, 0)
    end = state_at(log, last)
    motion = jnp.zeros_like(end).at[:N].set(end[N : 2 * N])  # all that a distance sees of the state's rate
    before, receding = jax.jvp(mechanism.throat_distance, (end,), (motion,))
    return before, -(before + receding * (duration - log.time[last]))


def contact_time(log: Log) -> Float[Array, ""]:
    """Time during which at least one flank is touched [s]."""
    last = jnp.maximum(log.count - 1, 0)
    touching = jnp.any(log.active > 0.5, axis=1)
    inside = (jnp.arange(log.kind.shape[0]) < last) & touching
    following = jnp.append(log.time[1:], 0.0)
    return jnp.sum(jnp.where(inside, following - log.time, 0.0))


class Energy(eqx.Module):
    """The ledger at one instant [J]: kinetic, springs, elastic contact, and what was lost so far."""

    kinetic: Float[Array, "..."]
    spring: Float[Array, "..."]
    contact: Float[Array, "..."]
    axial_damper: Float[Array, "..."]
    torsional_damper: Float[Array, "..."]
    hysteresis: Float[Array, "..."]
    friction: Float[Array, "..."]

    @property
    def dissipated(self) -> Float[Array, "..."]:
        """Everything lost [J]."""
        return self.axial_damper + self.torsional_damper + self.hysteresis + self.friction

    @property
    def total(self) -> Float[Array, "..."]:
        """The sum, constant in time [J]."""
        return self.kinetic + self.spring + self.contact + self.dissipated


def energy(mechanism: CaptureMechanism, state: Float[Array, " state"], active: Float[Array, " flanks"]) -> Energy:
    """The ledger of one state."""
    return Energy(*map(jnp.asarray, mechanism.stored(state, active)), *mechanism.losses(state))


class Balance(eqx.Module):
    """What should not change, and by how much it did over the run.

    ``energy``: relative to the initial energy; ``linear_momentum`` relative to m_S v0, ``angular_momentum`` to
    m_S v0 · 1 m; ``drift``: largest constraint error [m, rad] at any located event.
    """

    energy: Float[Array, ""]
    linear_momentum: Float[Array, ""]
    angular_momentum: Float[Array, ""]
    drift: Float[Array, ""]


def balance(mechanism: CaptureMechanism, log: Log) -> Balance:
    """Conservation over a whole run, from its first state to its last."""
    first, active = mechanism.start()
    last = jnp.maximum(log.count - 1, 0)
    end = state_at(log, last)
    before, after = energy(mechanism, first, active), energy(mechanism, end, log.active[last])
    scale = mechanism.design.active.mass * mechanism.scenario.approach_speed

    def momenta(state: Array) -> tuple[Array, Array]:
        kin = mechanism.kinematics(state)
        angular = mechanism.system.angular_momentum(kin.q, kin.v)
        if mechanism.spins:
            angular = angular + mechanism.probe.tip_inertia * state[2 * N]
        return mechanism.system.linear_momentum(kin.v), angular

    (linear_0, angular_0), (linear_1, angular_1) = momenta(first), momenta(end)
    used = jnp.arange(log.kind.shape[0]) < log.count
    phi = jax.vmap(lambda row: mechanism.system.constraints(Kinematics(row[:N], row[N : 2 * N])).phi)(log.rows[:, 0])
    return Balance(
        energy=(after.total - before.total) / before.total,
        linear_momentum=jnp.max(jnp.abs(linear_1 - linear_0)) / scale,
        angular_momentum=jnp.abs(angular_1 - angular_0) / scale,
        drift=jnp.max(jnp.where(used[:, None], jnp.abs(phi), 0.0)),
    )
