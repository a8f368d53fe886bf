"""One row of numbers a run of the slider-crank: its turns, the drive's torque, the force by components."""

import math

import numpy as np
from jaxtyping import Float

from ...mechanisms.run import Run
from ...mechanisms.slider_crank import journal_path
from ...mechanisms.slider_crank.design import Rod
from ...multibody.flexible import free_bar
from ..claims import NONE, Row
from ..study import StudyCase

STARTED = 1e-2  # s: from here on the start is over
TENTH = 0.1  # of the torque at the start
COLUMNS = {
    "outcome": "",
    "first_turn": "s",
    "second_turn": "s",
    "torque_at_start": "N m",
    "start_takes": "s",
    "first_impact": "s",
    "least_torque": "N m",
    "largest_torque": "N m",
    "across": "N",
    "along": "N",
    "across_second_turn": "N",
    "swing_first_turn": "N m",
    "swing_second_turn": "N m",
    "impacts": "-",
    "depth": "m",
    "touching_share": "-",
    "rod_deflection": "m",
    "rod_stress": "Pa",
    "rod_modes": "-",
    "lowest_mode": "Hz",
    "highest_mode": "Hz",
}
SHOWN = tuple(name for name in COLUMNS if name not in ("outcome", "touching_share"))


def row(case: StudyCase, run: Run) -> Row:
    """Return the numbers of one run with a history. The least and the largest torque are those after the first 10 ms;
    ``start_takes``: until the torque is a tenth of that at the start."""
    history = run.history
    assert history is not None
    time, torque = np.asarray(history.time), torque_of(run)
    along, across = components(run)
    turns = turn_times(time, np.asarray(history.position)[:, 0, 2])
    # The torque is largest at rest, by its formula: what contacts do to it shows only after the start.
    later, begun = time > turns[0], torque[time >= STARTED]
    low = np.flatnonzero(np.abs(torque) < TENTH * abs(torque[0]))
    return {
        "outcome": run.outcome.name,
        "first_turn": turns[0],
        "second_turn": turns[1] - turns[0],
        "torque_at_start": float(torque[0]),
        "start_takes": float(time[low[0]]) if len(low) else math.nan,
        "first_impact": float(run.impacts.time[0]),
        # A run that ends within the start has none to compare, which the infinities say.
        "least_torque": float(begun.min(initial=math.inf)),
        "largest_torque": float(begun.max(initial=-math.inf)),
        "across": float(across.max()),
        "along": float(along.max()),
        "across_second_turn": float(across[later].max()) if np.any(later) else NONE,
        "swing_first_turn": float(np.abs(torque[(time >= STARTED) & ~later]).max()),
        "swing_second_turn": float(np.abs(torque[later]).max()) if np.any(later) else NONE,
        "impacts": int(run.impact_count),
        "depth": float(run.maxima["penetration"]),
        "touching_share": float(run.quantity("contact_share")),
        "rod_deflection": float(run.quantity("rod_deflection")),
        "rod_stress": float(run.quantity("rod_stress")),
        "rod_modes": run.design.rod.modes,
        **frequencies(run.design.rod),
    }


def frequencies(rod: Rod) -> Row:
    """Return the lowest and highest natural frequency of the free rod's modes [Hz], 0 for a rigid one."""
    modes = free_bar(rod.bar, rod.modes - 2).modes.frequencies() if rod.modes else (0.0,)
    return {"lowest_mode": float(modes[0]), "highest_mode": float(modes[-1])}


def torque_of(run: Run) -> Float[np.ndarray, " steps"]:
    """Return M_0 (1 - ω/ω_0) at every step [N m]."""
    drive, history = run.design.drive, run.history
    assert history is not None
    speed = np.asarray(history.velocity)[:, 0, 2]
    return float(drive.torque) * (1.0 - speed / float(drive.no_load_speed))


def components(run: Run) -> tuple[Float[np.ndarray, " steps"], Float[np.ndarray, " steps"]]:
    """Return the size of the contact force along the slider's line and across it [N]: two sides each, of which one
    touches."""
    history = run.history
    assert history is not None
    right, left, above, below = np.asarray(history.contact_force).T
    return np.abs(right - left), np.abs(above - below)


def end_off(run: Run) -> Float[np.ndarray, " steps"]:
    """Return how far the end of a rod that bends, at the piston pin, is across its mean rotation [m], which modes of a
    free bar have as their axis."""
    history = run.history
    assert history is not None
    place, angle = np.asarray(history.position), np.asarray(history.position)[:, 1, 2]
    # by components the path is the slider's, seen from the rod's end
    off = place[:, 2, :2] - journal_path(run) - place[:, 1, :2]
    return np.cos(angle) * off[:, 1] - np.sin(angle) * off[:, 0]


def turn_times(time: Float[np.ndarray, " steps"], angle: Float[np.ndarray, " steps"]) -> tuple[float, float]:
    """Return when the crank has turned once and twice [s], NaN where it has not. ``angle``: from its start [rad]."""
    times = []
    for turns in (1, 2):
        past = np.flatnonzero(angle >= 2.0 * math.pi * turns)
        # Between two steps: without one before there is nothing to interpolate.
        if len(past) == 0 or past[0] == 0:
            times.append(math.nan)
            continue
        at = slice(past[0] - 1, past[0] + 1)
        times.append(float(np.interp(2.0 * math.pi * turns, angle[at], time[at])))
    return times[0], times[1]
