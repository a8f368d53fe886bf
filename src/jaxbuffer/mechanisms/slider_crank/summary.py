"""A slider-crank's run in words: what it lies beyond, and means over turns."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...value_text import degrees_text
from ..bending import mode_limits, mode_lines
from ..plain_summary import plain_summary
from ..run import Run
from ..validity import BEYOND_LAW, ValidityLimit
from .bending import bending_parts, rise_time
from .design import SliderCrank, SliderCrankScenario
from .pins import ADAMS, PinInBush
from .quantities import deepest
from .statistics import LEAST_TURNS, overflown, turn_starts, turn_statistics


def label(scenario: SliderCrankScenario, among: Any = ()) -> str:
    """Return a start in a few words: "from 523.6 rad/s at 0°"."""
    weight = float(scenario.gravity)
    angle = degrees_text(np.degrees(float(scenario.crank_angle)), sign=False)
    start = f"from {float(scenario.crank_speed):.4g} rad/s at {angle}"
    return f"{start}, gravity {weight:.4g} m/s²" if weight else start


def loose(design: SliderCrank) -> tuple[PinInBush, ...]:
    """Return the pins with play."""
    return tuple(pin for pin in (design.piston_pin, design.crank_pin) if pin.joint == "clearance")


def validity(design: SliderCrank, quantities: Mapping[str, Any]) -> list[ValidityLimit]:
    """Return how near the peak forces come to the contact laws' limits, and the rod's modes to being too few."""
    peak_force = quantities["peak_force"]
    few = bending_validity(design, peak_force, quantities.get("penetration")) if loose(design) else []
    return contact_validity(design, peak_force) + few


def bending_validity(design: SliderCrank, peak_force: Any, penetration: Any) -> list[ValidityLimit]:
    """Return how each part's highest mode compares with the time that the force [N] takes to its peak, ``penetration``
    [m] deep; nothing where that depth is not known."""
    parts = bending_parts(design)
    if not parts or penetration is None:
        return []
    return mode_limits(parts, rise_time(design, peak_force, penetration))


def contact_validity(design: SliderCrank, peak_force: Any) -> list[ValidityLimit]:
    """Return how near the peak forces [N] come to the contact laws' limits alone."""
    # A limit follows from the materials: IMPACT, and a stiffness that is given, have none.
    limits = [pin.by_materials.limit_force for pin in loose(design) if pin.law != ADAMS and pin.stiffness is None]
    if not limits:
        return []
    least = np.min([np.broadcast_to(np.asarray(limit), np.shape(peak_force)) for limit in limits], axis=0)
    wide = f"{BEYOND_LAW}the contact is too wide for the law, which takes it for small"
    return [ValidityLimit(wide, np.asarray(peak_force) / least)]


def warnings(run: Run) -> list[str]:
    """Return a line for each limit that a run exceeds."""
    lines = []
    if overflown(run):
        listed, all_of_them = int(run.impacts.count), int(run.impact_count)
        lines.append(
            f"the log has room for {listed} of {all_of_them} impacts: raise max_events of simulate for the rest"
        )
    if any(pin.law == ADAMS and np.any(np.asarray(pin.exponent) < 1.0) for pin in loose(run.design)):
        lines.append("an exponent below 1 is no elastic contact's: its stiffness falls as the pin goes deeper")
    limits = contact_validity(run.design, run.peak_force)
    lines += [limit.beyond for limit in limits if limit.passed]
    few = bending_validity(run.design, run.peak_force, deepest(run)) if int(run.impact_count) else []
    return lines + [f"{limit.beyond}, by a factor of {float(limit.share):.3g}" for limit in few if limit.passed]


def summary(run: Run) -> str:
    """Return the plain summary, with the number of modes of a rod that bends below the peak, and means over turns where
    there are at least four whole ones after the first."""
    text = with_modes(run, plain_summary(run))
    if run.outcome.failed or overflown(run) or len(turn_starts(run)) - 2 < LEAST_TURNS:
        return text
    statistics = turn_statistics(run)
    lines = [f"  means over {statistics.turns} turns ± standard error"]
    for name in ("impacts", "largest_force", "mean_peak", "contact_share"):
        lines.append(f"    {name.replace('_', ' '):22} {getattr(statistics, name)}")
    return "\n".join([text, *lines])


def with_modes(run: Run, text: str) -> str:
    """Return a summary with the number of modes below the peak."""
    if run.outcome.failed:
        return text
    lines = text.splitlines()
    below = next((k + 1 for k, line in enumerate(lines) if line.startswith("  time of the peak")), len(lines))
    parts, time = bending_parts(run.design), None
    # Without an impact no force rises that the modes could be too slow for.
    if parts and int(run.impact_count):
        time = rise_time(run.design, float(run.peak_force), float(np.asarray(deepest(run))))
    return "\n".join([*lines[:below], *mode_lines(parts, time), *lines[below:]])
