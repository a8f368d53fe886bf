"""One row of numbers a drop, and what a run at a fixed step would have seen of it."""

import numpy as np
from scipy.signal import find_peaks

from ...mechanisms.bar_drop.run import BarDropRun
from ..claims import Row
from ..study import StudyCase
from .fixed_steps import components

STEPS = (1e-3, 1e-4)  # s, the paper's two
BEGINNINGS = 200  # of the grids that are tried
WINDOW = 3.8e-3  # s from the first contact: the paper's detailed view, 0.1824 to 0.1862 s
APART = 1e-3  # m: above this gap the bar has left the plate, and the next touch is another impact
COUNTED = 0.01  # of the peak: by which a maximum of the force must stand out to count as a harmonic
COLUMNS = {
    "outcome": "",
    "contact_at": "s",
    "speed": "m/s",
    "first_peak": "N",
    "peak_force": "N",
    "later_peak": "N",
    "spring_peak": "N",
    "damper_peak": "N",
    "first_contact": "s",
    "stays": "-",
    "impacts": "-",
    "harmonics": "-",
    "penetration": "m",
    "plate_deflection": "m",
    "plate_share_at_peak": "-",
    "bar_deflection": "m",
    "friction_force": "N",
    "impact_lasts": "s",
    "height_after": "m",
    "seen_at_1e-3": "N",
    "seen_at_1e-4": "N",
    "plate_modes": "-",
    "bar_modes": "-",
}
SHOWN = (
    *("contact_at", "speed", "first_peak", "peak_force", "spring_peak", "damper_peak", "impacts", "harmonics"),
    *(
        "plate_deflection",
        "bar_deflection",
        "friction_force",
        "height_after",
        "seen_at_1e-3",
        "seen_at_1e-4",
        "plate_modes",
        "bar_modes",
    ),
)


def row(case: StudyCase, run: BarDropRun) -> Row:
    """Return the numbers of one drop, with a history. What a step sees is the median over grids that begin anywhere in
    it."""
    history, hits, design = run.history, run.impacts, run.design
    assert history is not None
    impact, deepest = design.impact, float(run.maxima["penetration"])
    peaks = np.asarray(hits.peak_force)[: int(hits.count)]
    time, force = np.asarray(history.time), np.asarray(history.contact_force)[:, 0]
    bent = float(np.asarray(run.quantity("plate_deflection")))
    # A rigid plate has no deflection to take a share of.
    at_peak = float(np.interp(float(run.peak_time), time, history.plate_deflection)) / bent if bent else 0.0
    medians = {
        f"seen_at_{step:.0e}".replace("e-0", "e-"): float(np.median(sampled_at(step, time, force))) for step in STEPS
    }
    # Without a release in the run the bar is still on the plate.
    stays = bool(np.isnan(hits.release_time[0]))
    since, gap = time - float(hits.time[0]), np.asarray(history.gap)[:, 0]
    touching, above = (since >= 0.0) & (gap <= 0.0), (since >= 0.0) & (gap > APART)
    # The paper's impact is all touches until the bar has left the plate, not the first of them.
    left = since[above][0] if np.any(above) else np.inf
    return {
        "outcome": run.outcome.name,
        "contact_at": float(hits.time[0]),
        "speed": float(hits.approach_speed[0]),
        "first_peak": float(peaks[0]),
        "peak_force": float(run.peak_force),
        # A bar that stays on the plate has one impact alone.
        "later_peak": float(peaks[1:].max(initial=0.0)),
        "spring_peak": float(impact.stiffness) * deepest ** float(impact.exponent),
        "damper_peak": damper_peak(run),
        "first_contact": (float(run.end_time) if stays else float(hits.release_time[0])) - float(hits.time[0]),
        "stays": int(stays),
        "impacts": int(run.impact_count),
        "harmonics": harmonics(since, force),
        "penetration": deepest,
        "plate_deflection": bent,
        "plate_share_at_peak": at_peak,
        "bar_deflection": float(np.asarray(run.quantity("bar_deflection"))),
        "friction_force": float(np.abs(np.asarray(history.friction_force)).max()),
        "impact_lasts": float(since[touching & (since < left)][-1]),
        "height_after": float(gap[since >= 0.0].max(initial=0.0)),
        **medians,
        "plate_modes": design.plate.modes,
        "bar_modes": design.bar.modes,
    }


def damper_peak(run: BarDropRun) -> float:
    """Return the largest of c STEP(δ) δ̇ [N]."""
    history = run.history
    assert history is not None
    _, damper = components(run.design, np.asarray(history.penetration), np.asarray(history.approach_speed)[:, 0])
    return float(damper.max(initial=0.0))


def sampled_at(step: float, time: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return the largest force [N] that samples a fixed ``step`` [s] apart meet, for many beginnings of the samples."""
    grids = (np.arange(first * step, time[-1], step) for first in np.linspace(0.0, 1.0, BEGINNINGS, endpoint=False))
    return np.array([np.interp(grid, time, force).max() for grid in grids])


def harmonics(since: np.ndarray, force: np.ndarray) -> int:
    """Count the force's maxima in the paper's detailed view. ``since``: the time from the first contact [s]."""
    inside = (since >= 0.0) & (since < WINDOW)
    # With zeros on both sides a maximum at an end of the view counts too.
    padded = np.concatenate([[0.0], force[inside], [0.0]])
    return len(find_peaks(padded, prominence=COUNTED * force.max())[0])
