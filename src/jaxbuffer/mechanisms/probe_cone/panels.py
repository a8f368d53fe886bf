"""What to draw of a capture over time."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from ..._types import Scalar
from ...elements import Buffer, EnergyShare
from ..energy import energy_unit
from ..picture import Level, Panel, PanelCurve, reach
from .assembly import LISTED
from .capture import Capture
from .design import Design
from .parts import PARTS, parts_of

SUPPLIES = tuple(part.supply for part in PARTS if part.supply is not None)
NOT_ELASTIC = ("kinetic", *(supply.name for supply in SUPPLIES))  # of what a history calls stored


ONE_ANGLE: Mapping[str, str] = MappingProxyType({"": "hinge_angle"})


def panels(capture: Capture, angles: Mapping[str, str] = ONE_ANGLE) -> list[Panel]:
    """Return panels of gap and distance to capture, energy, stroke, hinge angle and elements of a capture with a
    history.

    ``angles``: the history's names of the hinge's angles, by what the legend calls them.
    """
    history: Any = capture.history
    # The stroke's panel is the buffer's; of the others those come first that tell of the time after the impacts.
    others = (it for it in capture.elements if not isinstance(it, Buffer))
    more = sorted((panel for it in others for panel in it.report.panels(capture)), key=lambda panel: not panel.to_end)
    view = capture.mechanism.view
    contacts = [view.contact_in_words(name) for name in view.names(capture.design).contacts]
    gaps = Panel(
        "Gap and distance to capture",
        "distance [mm]",
        (
            *(
                PanelCurve(f"gap, {name}", 1e3 * gap)
                for name, gap in zip(contacts, np.transpose(history.gap), strict=True)
            ),
            PanelCurve("to the capture plane", 1e3 * history.throat_distance, dashed=True),
        ),
        (Level("", 0.0),),
    )
    turned, most = np.degrees(np.asarray(history.hinge_angle)), float(np.degrees(capture.hinge_angle))
    angle = Panel(
        f"Hinge angle{reach(turned, most, '°')}",
        "hinge angle [°]",
        tuple(PanelCurve(label, np.degrees(history.others[name])) for label, name in angles.items()),
        (Level("", 0.0),),
    )
    rest = [_energy(capture), _stroke(capture), angle, *more]
    # Latched vehicles come to rest long after the last impact.
    long = any(panel.to_end for panel in more)
    return [gaps, *(panel._replace(whole=long, to_end=long) for panel in rest)]


def _energy(capture: Capture) -> Panel:
    """Return a panel of what each part has of the energy of relative motion (M177), and what each has taken of it."""
    history: Any = capture.history
    energy = history.energy
    parts = {
        # Rounding may leave less than none of it, which a stack of curves cannot show.
        "relative motion": np.maximum(relative_motion(history), 0.0),
        "springs": energy.spring,
        "lost in dampers": energy.axial_damper + energy.torsional_damper,
        "lost in friction": energy.friction,
        "in contact": energy.contact + energy.hysteresis,
    }
    for share in energy_shares(capture):
        parts[share.label] = sum(np.asarray(getattr(energy, name)) for name in share.names)
    # The panel stacks them, so that the unit is that of their sum.
    largest = float(np.max(np.sum([np.asarray(values) for values in parts.values()], axis=0)))
    unit, many = energy_unit(largest)
    curves = tuple(PanelCurve(name, many * np.asarray(value)) for name, value in parts.items())
    notes = "".join(f", {supply.note}" for supply in SUPPLIES if supply.note and supply.name in energy.stored)
    return Panel(f"Energy without that of the common motion{notes}", f"energy [{unit}]", curves, stacked=True)


def energy_shares(capture: Capture) -> list[EnergyShare]:
    """Return what the parts have of a capture's energy: first what every capture lists, in that order."""
    shares = [share for element in capture.elements for share in element.report.shares]
    order = dict(zip(LISTED[1], range(len(LISTED[1])), strict=True))
    return sorted(shares, key=lambda share: order.get(share.names[-1], len(order)))


def relative_motion(history: Any) -> np.ndarray:
    """Return the energy of relative motion less what springs, contacts and parts store of it [J], over a history."""
    stored = history.energy.stored
    elastic = sum(np.asarray(stored[name]) for name in stored if name not in NOT_ELASTIC)
    return np.asarray(history.relative_energy) - elastic


def _stroke(capture: Capture) -> Panel:
    largest = 1e3 * float(capture.stroke)
    # With a stop its place is shown, not the end behind it.
    ends = [(f"the {what}", place) for what, place in stroke_limits(capture.design)]
    ends = ends or [("the buffer's end", capture.design.buffer.longest_stroke)]
    levels = [Level(f"largest, {largest:.4g} mm", largest)]
    for what, place in ends:
        end = 1e3 * float(place)
        if largest > 0.5 * end:
            levels.append(Level(f"{what}, {end:.4g} mm", end, limit=True))
    if (out := 1e3 * float(capture.extension)) > 0.1 * largest:
        levels.append(Level(f"farthest out, {out:.4g} mm", -out))
    stroke = PanelCurve("", 1e3 * capture.history.stroke)  # type: ignore[union-attr]
    return Panel("Buffer stroke", "stroke [mm]", (stroke,), (*levels, Level("", 0.0)))


def stroke_limits(design: Design) -> list[tuple[str, Scalar]]:
    """Return what limits the buffer's stroke before its end, in words, and from which stroke on [m]."""
    return [limit for part in parts_of(design) for limit in part.stroke_limits(design)]
