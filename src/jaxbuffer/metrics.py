"""From a run's log to the quantities of the model's section 7: each a plain function of located states, differentiable
because the states carry their sensitivities."""

import dataclasses
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .integrate import Kind, Log
from .mechanisms.assembly import FLANKS
from .mechanisms.capture import CaptureMechanism
from .mechanisms.stiffness import axial_direction


class Maxima(NamedTuple):
    """Largest values over a run: contact force [N] with its time [s] and flank, hinge force [N], buffer force [N],
    stroke [m], hinge angle [rad], force of the end stop [N], 0 without one."""

    peak_force: Float[Array, ""]
    peak_time: Float[Array, ""]
    peak_flank: Int[Array, ""]
    hinge_force: Float[Array, ""]
    buffer_force: Float[Array, ""]
    stroke: Float[Array, ""]
    hinge_angle: Float[Array, ""]
    stop_force: Float[Array, ""]


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
    late = mechanism.time_to_contact(state, log.which[slot] % mechanism.contacts)
    return state + mechanism.derivative(log.time[slot], state, log.active[slot]) * jnp.where(touchdown, late, 0.0)


def maxima(mechanism: CaptureMechanism, log: Log) -> Maxima:
    """The largest values over all located events and the end.

    By the envelope theorem a maximum's derivative needs the state's at fixed time only; its time's needs the slope's.
    """

    def observe(slot: Array) -> tuple[Array, Array]:
        state, active = state_of_maximum(mechanism, log, slot), log.active[slot]
        # After a touchdown with a jump the rate is another than before it.
        rate = mechanism.derivative(log.time[slot], state, active) if mechanism.jumps else log.rates[slot, 0]
        return mechanism.observables(state, rate, active), rate

    # Any entry may hold a maximum: of two at one instant only one is logged under its own name, and a quantity may be
    # largest at the end.
    used = jnp.arange(log.kind.shape[0]) < log.count
    contact = jnp.max(log.values[:, :FLANKS], axis=1, keepdims=True)
    candidates = jnp.concatenate([contact, log.values[:, FLANKS:]], axis=1)
    slots = jnp.argmax(jnp.where(used[:, None], candidates, -jnp.inf), axis=0)
    flank = jnp.argmax(log.values[slots[0], :FLANKS])
    columns = jnp.concatenate([flank[None], jnp.arange(FLANKS, len(mechanism.observed))])
    seen, rates = jax.vmap(observe)(slots)
    peak, *values = seen[jnp.arange(len(slots)), columns]
    others = {"stop_force": jnp.zeros(())} | dict(zip(mechanism.observed[FLANKS:], values, strict=True))
    return Maxima(peak, _peak_time(mechanism, log, slots[0], flank, rates[0]), flank, **others)


def _peak_time(
    mechanism: CaptureMechanism, log: Log, slot: Int[Array, ""], flank: Int[Array, ""], rate: Float[Array, " state"]
) -> Float[Array, ""]:
    """When a contact force is largest, with the derivative -(∂slope/∂p)/(dslope/dt)."""
    state, active = state_at(log, slot), log.active[slot]
    slope = jax.jvp(lambda y: mechanism.contact(mechanism.posture(y), active).normal, (state,), (rate,))[1]
    its_own = (log.kind[slot] == Kind.PEAK) & (log.which[slot] == flank)
    if mechanism.jumps:
        touchdown = (log.kind[slot] == Kind.TOUCHDOWN) & (log.which[slot] == flank) & (log.time[slot] > 0.0)
        slope = jnp.where(touchdown, mechanism.gaps(state)[:FLANKS], slope)
        its_own = its_own | touchdown
    return _shifted(log.time[slot], -slope[flank], jnp.where(its_own, log.guard_rate[slot], jnp.inf))


def moving_end(mechanism: CaptureMechanism, log: Log, by_guard: Bool[Array, ""]) -> Log:
    """The same log, whose end by a guard moves with the parameters: to the time at which the guard crosses zero, and
    the last state with it. Values stay as they are."""
    last = jnp.maximum(log.count - 1, 0)
    end = state_at(log, last)
    terminals = mechanism.terminals(end)
    terminal = terminals[jnp.clip(log.which[last], 0, len(terminals) - 1)]
    time = _shifted(log.time[last], jnp.where(by_guard, terminal, 0.0), log.guard_rate[last])
    rows = log.rows.at[last, 0].set(_carried(end, jax.lax.stop_gradient(log.rates[last, 0]), time))
    return dataclasses.replace(log, time=log.time.at[last].set(time), rows=rows)


class Survey(NamedTuple):
    """What each entry of a log shows: every contact's gap [m], both flanks' force [N]; the constraints' largest error
    [m, rad]."""

    gap: Float[Array, "slots contacts"]
    force: Float[Array, "slots flanks"]
    drift: Float[Array, " slots"]


def survey(mechanism: CaptureMechanism, log: Log) -> Survey:
    """One look at every entry."""

    def look(slot: Array) -> Survey:
        state, active = state_at(log, slot), log.active[slot]
        at = mechanism.posture(state)
        highest = mechanism.posture(state_of_maximum(mechanism, log, slot)) if mechanism.jumps else at
        drift = jnp.max(jnp.abs(mechanism.system.errors(jax.lax.stop_gradient(at.kin))))
        return Survey(mechanism.gaps_at(at)[0], mechanism.contact(highest, active).normal, drift)

    return jax.vmap(look)(jnp.arange(log.kind.shape[0]))


def moving_events(log: Log, seen: Survey) -> Log:
    """The same log, whose touchdowns and releases move with the parameters: to the time at which the gap is zero."""
    gap = jnp.take_along_axis(seen.gap, (log.which % seen.gap.shape[1])[:, None], axis=1)[:, 0]
    touch = (log.kind == Kind.TOUCHDOWN) & (log.time > 0.0)  # a run that starts in contact does so at t = 0
    guard = jnp.where(touch, -gap, jnp.where(log.kind == Kind.RELEASE, gap, 0.0))
    return dataclasses.replace(log, time=jax.vmap(_shifted)(log.time, guard, log.guard_rate))


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
    """Touchdowns in order, an entry each; slots beyond ``count`` are padding (flank -1, zeros). A run with more events
    than its log has room for lists the first ones; `Capture.impact_count` counts all.

    ``time`` [s], ``flank`` (0 lower, 1 upper), ``approach_speed`` δ̇⁻ [m/s], ``peak_force`` [N] until the flank's next
    touchdown, ``release_time`` [s] (NaN where the run ended in contact).
    """

    time: Float[Array, " slots"]
    flank: Int[Array, " slots"]
    approach_speed: Float[Array, " slots"]
    peak_force: Float[Array, " slots"]
    release_time: Float[Array, " slots"]
    count: Int[Array, ""]


def impacts(mechanism: CaptureMechanism, log: Log, seen: Survey) -> Impacts:
    """All impacts of a run whose log's events move (`moving_events`)."""
    in_order = jnp.arange(log.kind.shape[0]) < log.room
    touch, flank = (log.kind == Kind.TOUCHDOWN) & (log.which < FLANKS) & in_order, log.which % FLANKS
    speed = jax.vmap(lambda row, flank: mechanism.memory(row)[flank])(log.rows[:, 0], flank)
    top, release = _impact_ends(log)
    peak = jnp.maximum(seen.force[top, flank], 0.0)

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
    last = jnp.minimum(log.count, log.room)
    _, _, top, release = jax.lax.while_loop(lambda carry: carry[0] < last, visit, begin)
    return top, release


def throat(mechanism: CaptureMechanism, log: Log, duration: Float[Array, ""]) -> tuple[Array, Array]:
    """How far the tip centre is before the capture plane at the end of the run [m], and how far beyond that plane it
    would be at ``duration``, going on from the end as fast as it goes there [m]: positive exactly if it crosses the
    plane until then.

    Its value and slope are continuous where capture, or escape, happens just at ``duration``; grazing the plane without
    crossing it is a jump.
    """
    last = jnp.maximum(log.count - 1, 0)
    before, receding = mechanism.throat_of(state_at(log, last))
    return before, -(before + receding * (duration - log.time[last]))


def stroke_margin(
    mechanism: CaptureMechanism, log: Log, stroke: Float[Array, ""], bottomed: Bool[Array, ""]
) -> Float[Array, ""]:
    """How much stroke is left before the buffer's end [m]; of a bottomed run minus how much is missing.

    What is missing is ½ m ṡ²/F, the way on which the buffer's force at its end would stop the mass m that its ends meet
    through the joints. So the margin is continuous, and zero, where a run just reaches the end.
    """
    last = jnp.maximum(log.count - 1, 0)
    at = mechanism.posture(state_at(log, last))
    mass, buffer = mechanism.system.effective_mass(at.kin, axial_direction(at)), mechanism.design.buffer
    speed = jnp.maximum(at.stroke_rate, 0.0)
    force = buffer.k_A * buffer.longest_stroke + buffer.c_A * speed + mechanism.stop_force(at, log.active[last])
    return jnp.where(bottomed, -0.5 * mass * speed**2 / force, buffer.longest_stroke - stroke)


def contact_time(log: Log) -> Float[Array, ""]:
    """Time during which at least one flank is touched [s]; its derivative is NaN if events found no room in the log."""
    last = jnp.minimum(jnp.maximum(log.count - 1, 0), log.room - 1)
    touching = jnp.any(log.active[:, :FLANKS] > 0.5, axis=1)
    inside = (jnp.arange(log.kind.shape[0]) < last) & touching
    following = jnp.append(log.time[1:], 0.0)
    listed = jnp.sum(jnp.where(inside, following - log.time, 0.0))
    return _undifferentiable(listed + log.missed_time, log.overflown)


@jax.custom_jvp
def _undifferentiable(value: Array, where: Array) -> Float[Array, ""]:
    """The value, whose derivative is NaN ``where`` it is not known."""
    return value


@_undifferentiable.defjvp
def _undifferentiable_jvp(primals: tuple, tangents: tuple) -> tuple[Array, Array]:
    return primals[0], tangents[0] * jnp.where(primals[1], jnp.nan, 1.0)
