"""Impacts as pulses of force: when each begins, peaks and ends."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ..mechanisms.run import Run
from ..run.instants import at_times

EVEN = 600  # times that a curve is drawn through besides the steps
FINE, MOST = 6, 4000  # parts that a short step with a contact is drawn in, and about how many there are in all
TIMES = 2000  # evenly spread ones of a curve to be read off
LOW = 0.02  # of its peak: below that a pulse counts as over
BEYOND, WORTH = 1.2, 0.4  # of the last contact's time; a longer run's time axes end there


class Pulse(NamedTuple):
    """An impact's force over time: ``start``, ``peak`` and ``end`` [s], its largest ``force`` [N] and its contact."""

    start: float
    peak: float
    end: float
    force: float
    contact: int


def pulses(run: Run) -> list[Pulse]:
    """Return the pulses of the impacts that a run with a history lists, in their order.

    The run's peak is added where no impact has it.
    """
    history, hits = run.history, run.impacts
    assert history is not None
    time, force = np.asarray(history.time), np.asarray(history.contact_force)
    count = min(int(hits.count), len(np.asarray(hits.time)))
    begin, contact = np.asarray(hits.time)[:count], np.asarray(hits.contact)[:count]
    result = []
    for k in range(count):
        # A pulse ends where the next impact of the same contact begins.
        later = begin[k + 1 :][contact[k + 1 :] == contact[k]]
        until = later[0] if later.size else np.inf
        inside = np.flatnonzero((time >= begin[k]) & (time < until))
        if inside.size:
            at = float(time[inside[np.argmax(force[inside, contact[k]])]])
            result.append(pulse_around(time, force[:, contact[k]], at, int(contact[k])))
    # A run lists a limited number of impacts, so that the peak may be of a later one.
    if not any(pulse.start <= float(run.peak_time) <= pulse.end for pulse in result) and int(run.peak_contact) >= 0:
        one = int(run.peak_contact)
        result.append(pulse_around(time, force[:, one], float(run.peak_time), one))
    return [pulse for pulse in result if pulse.force > 0.0]


def touching(run: Run) -> Float[np.ndarray, " n"]:
    """Return the times of a run's history at which a contact is closed [s]."""
    assert run.history is not None
    return np.asarray(run.history.time)[np.any(np.asarray(run.history.contact_force) > 0.0, axis=1)]


def last_contact(run: Run) -> float:
    """Return until when impacts are drawn [s]: a little beyond the last contact, or to the end if that is not much
    later."""
    assert run.history is not None
    times, end = touching(run), float(np.asarray(run.history.time)[-1])
    last = BEYOND * float(times[-1]) if times.size else end
    return last if last < WORTH * end else end


def fine_times(run: Run, even: int = EVEN, until: float = np.inf) -> Float[np.ndarray, " n"]:
    """Return the times [s] through which forces are drawn smoothly.

    These are a run's own steps, evenly spread times, those of the peak and of other maxima, and parts of each shorter
    step in which a contact is closed, because an impact has a handful of steps only.

    **Arguments:** ``run``: one simulated with ``history=True``; ``even``: how many evenly spread ones, ``until``: the
    last of them [s].
    """
    history = run.history
    assert history is not None
    time, force = np.asarray(history.time), np.asarray(history.contact_force)
    touching = np.any(force > 0.0, axis=1)
    spread, step = np.linspace(time[0], min(float(time[-1]), until), even), np.diff(time)
    first = np.flatnonzero((touching[1:] | touching[:-1]) & (step < spread[1] - spread[0]))
    # The more such steps there are, the fewer parts each has, so that the total stays about the same.
    parts = int(np.clip(MOST // max(first.size, 1), 1, FINE))
    inside = time[first] + np.outer(np.arange(1, parts) / parts, step[first])
    return np.unique(np.concatenate([time, spread, inside.ravel(), largest_times(run)]))


def largest_times(run: Run) -> Float[np.ndarray, " n"]:
    """Return when the contact force and the observables with maxima are largest [s]: a curve through evenly spread
    times would stay below them."""
    assert run.history is not None
    first, *_, last = np.asarray(run.history.time)
    times = np.array([float(run.peak_time), *run.maximum_times.values()])
    # What stays zero, and the force of a run without an impact, has no such time.
    return np.unique(np.clip(times[np.isfinite(times)], first, last))


def force_over_time(run: Run) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """Return times [s], close to each other where a contact is closed, and the largest force of any contact then [N].

    **Arguments:** ``run``: one simulated with ``history=True``.
    """
    time = fine_times(run, TIMES)
    return time, np.max(np.asarray(at_times(run, time).contact_force), axis=1, initial=0.0)


def pulse_around(
    time: Float[np.ndarray, " steps"], force: Float[np.ndarray, " steps"], at: float, contact: int = 0
) -> Pulse:
    """Return the pulse whose largest force is at a given time [s]: its steps above two per cent of it."""
    near = int(np.argmin(np.abs(time - at)))
    low = force < LOW * force[near]
    before, after = np.flatnonzero(low[:near]), np.flatnonzero(low[near:])
    start = before[-1] + 1 if before.size else 0
    end = near + after[0] - 1 if after.size else len(time) - 1
    return Pulse(float(time[start]), at, float(time[end]), float(force[near]), contact)
