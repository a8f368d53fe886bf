"""All that every mechanism's runs have, read off what time stepping found."""

import dataclasses
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array

from ..hybrid import Log, Result, Status
from ..mechanisms.mechanism import Request
from ..mechanisms.outcome import outcome_code
from ..mechanisms.run import Maxima, Run, Solved, plain_run
from ..mechanisms.system import ContactSystem
from .conservation import balance
from .history import history as history_of
from .impacts import contact_time, impacts
from .maxima import maxima, places_of
from .moving import moving_end, moving_events, moving_maxima
from .readings import readings
from .survey import survey


def read_off(request: Request, result: Result) -> Run:
    """Read the run off the events that were located."""
    system = request.system  # assembled once: that takes a while to trace
    return (request.mechanism.run or plain_run)(system, _read_off(request, system, result))


def _read_off(request: Request, system: ContactSystem, result: Result) -> Solved:
    """Read off what every mechanism's runs have."""
    mechanism, parameters, duration, _, options = request
    log, places = moving_maxima(system, result.log), places_of(system, result.log)
    events, by_guard = survey(system, log), result.status < Status.TIMEOUT
    log = moving_events(log, events)
    read = readings(system, mechanism.reader, result.start, log, places.slots, by_guard)
    events = events.with_forces(jnp.append(places.slots, jnp.maximum(log.count - 1, 0)), read.observables)
    log = moving_end(log, read.end_time, read.end.state)
    code = outcome_code(mechanism.outcomes, system.end_outcomes, result.status)
    # a factor, so that derivatives are NaN as well
    known = jnp.where(code < mechanism.outcomes["failed_steps"], 1.0, jnp.nan)
    # When a force is largest follows from derivatives at fixed times.
    fixed = dataclasses.replace(log, rows=result.log.rows)
    top, hits = maxima(system, fixed, places, read), impacts(system, log, events)
    energy, conserved = balance(system, read, log, events.drift)
    touched = top.peak_force > 0.0  # without a contact there is no largest force, nor a time and a place of it
    numbers = {
        "peak_force": top.peak_force,
        "peak_time": jnp.where(touched, top.peak_time, jnp.nan),
        "maxima": top.others | {n: jnp.maximum(top.others[n], least) for n, least in system.lower_bounds.items()},
        "penetration": system.penetration(top.peak_force),
        "end_time": log.time[jnp.maximum(log.count - 1, 0)],
        "contact_time": contact_time(system, log),
        "impacts": hits,
        "energy": energy,
        "balance": conserved,
        "history": history_of(system, result.steps) if options.keep else None,
        "_located": result.log,
    }
    common = {
        "design": parameters[0],
        "scenario": parameters[1],
        "code": code,
        "peak_contact": jnp.where(touched | jnp.isnan(known), top.peak_contact, -1),
        "peak_impact": _peak_impact(log, top, hits),
        "impact_count": hits.count + jnp.sum(log.missed[: system.impact_contacts]),
        "attempts": result.attempts,
        "accepted": result.accepted,
        "stabilisation": parameters[2],
        "_observed": tuple(system.observed),
        # What a failed run has done so far looks like a run: its history, impacts and log are unknown like all else.
        **jax.tree.map(lambda x: x * known if eqx.is_inexact_array(x) else x, numbers),
    }
    return Solved(parameters, duration, read.start, read.end, read.event, result, log, code, known, top, common)


def _peak_impact(log: Log, top: Maxima, hits: Any) -> Array:
    """Return which of the listed impacts the largest contact force belongs to, -1 for none of them."""
    slots = hits.time.shape[0]
    earlier = (jnp.arange(slots) < hits.count) & (hits.time <= top.peak_time) & (hits.contact == top.peak_contact)
    listed = ~log.overflown | (top.peak_time <= log.time[log.room - 1])
    return jnp.max(jnp.where(earlier & listed, jnp.arange(slots), -1))
