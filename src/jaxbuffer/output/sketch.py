"""A mechanism's drawing on a figure's axes: shapes, and the contact forces as arrows."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from jaxtyping import Float

from .._types import Axes
from ..mechanisms.drawing import Band, Coil, Disc, Drawing, Frames, Outline, Points, RodShape, Spot, Spring, placed
from .style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY

# Of filled parts in their order, and how opaque: so that each is lighter than the next, also without colours.
FILLS = ((SKY, 0.25), (ORANGE, 0.5), (GREEN, 0.45), (GREY, 0.75), (BLUE, 0.68), (RED, 1.0))
INK = "#222222"
LINES = (INK, RED, BLUE, PURPLE, GREEN, ORANGE, GREY)  # of parts that are lines, likewise
FORCE = "#B2182B"
SHORTEST = 0.02  # of the longest arrow: what is shorter is a dot
ROUND, TURNS = 60, 8  # corners of a disc; turns of a spring


def sketch(
    axes: Axes,
    shapes: Iterable[Any],
    frames: Frames,
    unit: float = 1.0,
    origin: Any = (0.0, 0.0),
    colours: dict[str, Any] | None = None,
) -> dict[str, Any]:
    """Draw shapes whose bodies are at ``frames``.

    **Arguments:** ``unit``: of the axes [m]; ``origin``: what is drawn at their origin [m]; ``colours``: of the parts
    (default: `fills` of the shapes).

    **Returns:** by the name of each part, an artist for the legend.
    """
    shapes = tuple(shapes)
    colours = fills(shapes) if colours is None else colours
    named: dict[str, Any] = {}
    # A shape without a name belongs to the part before it, and has its colour.
    filled, drawn = _faint(*FILLS[0]), INK
    for shape in shapes:
        if is_filled(shape):
            colour = filled = colours.get(shape.part, filled)
        else:
            colour = drawn = colours.get(shape.part, drawn if not shape.part else INK)
        points = (outline(shape, frames) - origin) / unit
        artist = _draw(axes, shape, points, colour)
        if shape.part:
            named[shape.part] = artist
    axes.set_aspect("equal")
    return named


def fills(shapes: Iterable[Any]) -> dict[str, Any]:
    """Return the colour of each named part, filled ones and lines, in the parts' order."""
    shapes = tuple(shapes)
    areas = dict.fromkeys(shape.part for shape in shapes if is_filled(shape) and shape.part)
    lines = dict.fromkeys(shape.part for shape in shapes if not is_filled(shape) and shape.part and not _dashed(shape))
    filled = {part: _faint(*FILLS[k % len(FILLS)]) for k, part in enumerate(areas)}
    return filled | {part: LINES[k % len(LINES)] for k, part in enumerate(lines)}


def _dashed(shape: Any) -> bool:
    return bool(getattr(shape, "dashed", False))


def _draw(axes: Axes, shape: Any, points: Points, fill: Any) -> Any:
    if is_filled(shape):
        return axes.fill(*points.T, facecolor=fill, edgecolor=INK, linewidth=0.8, zorder=2)[0]
    dashes, colour = ("--", GREY) if _dashed(shape) else ("-", fill)
    return axes.plot(*points.T, dashes, color=colour, linewidth=1.1, solid_joinstyle="round", zorder=2)[0]


def is_filled(shape: Any) -> bool:
    """Return whether a shape is an area rather than a line."""
    return bool(getattr(shape, "filled", isinstance(shape, RodShape | Band)))


def outline(shape: Any, frames: Frames) -> Points:
    """Return the corners of a shape in inertial axes [m]."""
    if isinstance(shape, Outline):
        return placed(shape.corners, shape.body, frames)
    if isinstance(shape, Disc):
        angle = np.linspace(0.0, 2.0 * np.pi, ROUND + 1)
        circle = shape.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return _spot(circle, shape.centre, frames)
    if isinstance(shape, Coil):
        turn = np.linspace(0.0, 2.5, 100)
        angle = 2.0 * np.pi * turn
        radius = shape.radius * (0.25 + 0.75 * turn / turn[-1])
        return _spot(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1), shape.centre, frames)
    if isinstance(shape, Band):
        middle, angle = shape.bent(frames), frames[list(shape.stations), 2]
        half = 0.5 * shape.width * np.stack([-np.sin(angle), np.cos(angle)], axis=1)
        return np.concatenate([middle + half, (middle - half)[::-1]])
    first, second = shape.first.at(frames), shape.second.at(frames)
    along = second - first
    # The two ends may coincide, where a direction cannot be told.
    across = np.array([-along[1], along[0]]) / max(float(np.hypot(*along)), 1e-12)
    if isinstance(shape, Spring):
        share = np.concatenate([[0.0], np.linspace(0.1, 0.9, 2 * TURNS + 1), [1.0]])
        swing = np.concatenate([[0.0, 0.0], np.tile([1.0, -1.0], TURNS)[1:], [0.0, 0.0]])
        return first + share[:, None] * along + 0.5 * shape.width * swing[:, None] * across
    half = 0.5 * shape.width * across
    return np.array([first - half, second - half, second + half, first + half])


def forces(
    axes: Axes,
    arrows: Float[np.ndarray, "contacts 4"],
    length: float,
    reach: float,
    unit: float = 1.0,
    origin: Any = (0.0, 0.0),
) -> None:
    """Draw an arrow for each contact force on a ball, from where it acts.

    **Arguments:** ``arrows``: of each contact the place and the force there [m, m, N, N]; ``length`` [m] of an arrow
    for 1 N; ``reach`` [m]: of the longest, against which the shortest are left out; others as of `sketch`.
    """
    for arrow in arrows:
        force = arrow[2:]
        if not np.any(force):
            continue
        start = (arrow[:2] - origin) / unit
        tip = start + length / unit * force
        axes.plot(*start, "o", color=FORCE, markersize=3, zorder=4)
        if length * float(np.hypot(*force)) < SHORTEST * reach:
            continue
        style = {"arrowstyle": "-|>,head_width=0.25,head_length=0.5", "color": FORCE, "linewidth": 1.8}
        axes.annotate("", tip, start, arrowprops=style | {"shrinkA": 0.0, "shrinkB": 0.0}, zorder=4)


def bounds(drawing: Drawing, frames: Frames) -> Float[np.ndarray, "2 2"]:
    """Return the lower left and the upper right corner of a drawing [m], of a line without end as far as the nearest
    points to the balls that may touch it."""
    endless = [getattr(shape, "endless", False) for shape in drawing.shapes]
    shown = [outline(shape, frames) for shape, long in zip(drawing.shapes, endless, strict=True) if not long]
    feet = [touch.at(frames)[0][None, :] for touch in drawing.touches if any(endless)]
    # Without any shape the places of the bodies say what there is to see.
    points = np.concatenate([*shown, *feet] or [frames[:, :2]])
    return np.array([points.min(axis=0), points.max(axis=0)])


def _spot(points: Points, centre: Spot, frames: Frames) -> Points:
    """Return points about a spot, in its body's axes, in inertial axes."""
    return placed(points + np.array([centre.x, centre.y]), centre.body, frames)


def _faint(colour: str, opacity: float) -> Any:
    """Return a colour mixed with white."""
    from matplotlib.colors import to_rgb

    return tuple(1.0 - opacity * (1.0 - np.array(to_rgb(colour))))
