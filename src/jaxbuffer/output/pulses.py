"""Impacts as pulses of force: when each begins, peaks and ends."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ..mechanisms.run import Run

LOW = 0.02  # of its peak: below that a pulse counts as over


class Pulse(NamedTuple):
    """An impact's force over time: ``start``, ``peak`` and ``end`` [s], its largest ``force`` [N] and its contact."""

    start: float
    peak: float
    end: float
    force: float
    contact: int


def pulses(run: Run) -> list[Pulse]:
    """Those of the impacts that a run with a history lists, in their order; and the run's peak, if no impact has it."""
    history, hits = run.history, run.impacts
    assert history is not None
    time, force = np.asarray(history.time), np.asarray(history.contact_force)
    count = min(int(hits.count), len(np.asarray(hits.time)))
    begin, contact = np.asarray(hits.time)[:count], np.asarray(hits.contact)[:count]
    found = []
    for k in range(count):
        later = begin[k + 1 :][contact[k + 1 :] == contact[k]]
        until = later[0] if later.size else np.inf
        inside = np.flatnonzero((time >= begin[k]) & (time < until))
        if inside.size:
            at = float(time[inside[np.argmax(force[inside, contact[k]])]])
            found.append(pulse_around(time, force[:, contact[k]], at, int(contact[k])))
    if not any(pulse.start <= float(run.peak_time) <= pulse.end for pulse in found) and int(run.peak_contact) >= 0:
        one = int(run.peak_contact)
        found.append(pulse_around(time, force[:, one], float(run.peak_time), one))
    return [pulse for pulse in found if pulse.force > 0.0]


def pulse_around(
    time: Float[np.ndarray, " steps"], force: Float[np.ndarray, " steps"], at: float, contact: int = 0
) -> Pulse:
    """The pulse whose largest force is at a given time [s]: from its first to its last step above two per cent of it."""
    near = int(np.argmin(np.abs(time - at)))
    low = force < LOW * force[near]
    before, after = np.flatnonzero(low[:near]), np.flatnonzero(low[near:])
    start = before[-1] + 1 if before.size else 0
    end = near + after[0] - 1 if after.size else len(time) - 1
    return Pulse(float(time[start]), at, float(time[end]), float(force[near]), contact)
