"""A run's mechanism drawn at chosen times, with its contact forces."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from .._types import Axes, Figure
from ..errors import InputError, check_type
from ..mechanisms.drawing import Arrows, Band, Drawing, arrows_of
from ..mechanisms.parts_drawing import drawing_of
from ..mechanisms.run import Run
from ..run.instants import at_times
from .layout import legend_below
from .pulses import last_contact, pulses
from .sketch import INK, bounds, fills, forces, sketch
from .style import BLUE, GREY, RED, blank, styled
from .words import force_text

PANELS = 4  # of the chosen times, the start and the end among them
MOMENTS = 2  # more of them at most, at which an element is loaded most or closes
SAME = 1e-3  # of the run: what elements do within it of a largest force has the same picture
APART = 0.05  # of the run: impacts nearer to each other are shown as one
MARGIN = 1.08  # of what is seen, over what is drawn
MM = 1e-3  # m
FREE = 1.3  # half of a detail, over the distance from its middle to the nearest surface
SEEN, LARGER = 0.01, 0.05  # of a picture's width: bending below the first is drawn larger too, about as the second
ROUNDING = 1e-9  # of a picture's width
BENT = ((BLUE, ":"), (INK, "-."), (RED, (0, (6, 1, 1, 1, 1, 1))))  # colour and dashes of bending drawn larger


class Scene(NamedTuple):
    """A run's drawing at some ``times`` [s].

    ``frames`` of its bodies; ``instants`` of its history; ``arrows`` of the contact forces, in the whole and in the
    detail; ``views`` of the whole (lower left and upper right corner [m]); ``peak``: the run's largest force [N];
    ``magnified``: parts that bend too little to be seen, and how many times larger their bending is drawn beside them
    [-]; ``moments``: as of `moments`; ``path`` of the detail's frame over the whole run [m].
    """

    run: Run
    drawing: Drawing
    times: Float[np.ndarray, " times"]
    frames: Float[np.ndarray, "times frames 3"]
    instants: Any
    arrows: Arrows
    views: Float[np.ndarray, "times 2 2"]
    peak: float
    magnified: list[tuple[Band, float]]
    moments: dict[str, float]
    path: Float[np.ndarray, "steps 2"] | None = None


def scene(run: Run, times: Sequence[float] | np.ndarray) -> Scene:
    """Return a run's drawing at some times [s]; those outside the run are its ends."""
    check_type("run", run, Run, "a run, such as jb.simulate(jb.table2(), history=True)")
    instants = at_times(run, np.asarray(times, float))
    drawing = drawing_of(run.mechanism, run.design, run.scenario)
    frames = drawing.frames(instants)
    force = np.asarray(run.history.contact_force)  # type: ignore[union-attr]
    # One length for all arrows: those of different times can be compared.
    peak = float(np.max(np.hypot(force, np.asarray(run.history.friction_force)), initial=0.0))  # type: ignore[union-attr]
    views = _views(drawing, frames)
    larger = magnifications(run, drawing, float(views[0, 1, 0] - views[0, 0, 0]))
    # Seen again, because bending that is drawn larger needs more room; how much larger depends on the first width.
    views = _views(drawing, frames, larger)
    detail = drawing.detail
    path = None if detail is None or detail.path is None else drawing.frames(run.history)[:, detail.path, :2]
    return Scene(
        run=run,
        drawing=drawing,
        times=np.asarray(instants.time),
        frames=frames,
        instants=instants,
        arrows=arrows_of(drawing, instants, frames),
        views=views,
        peak=peak,
        magnified=larger,
        moments=moments(run),
        path=path,
    )


def magnifications(run: Run, drawing: Drawing, wide: float) -> list[tuple[Band, float]]:
    """Return the parts whose bending would not be seen in a picture ``wide`` [m], and a round factor by which it
    would."""
    bands = [shape for shape in drawing.shapes if isinstance(shape, Band)]
    factors = []
    for band in bands:
        off = [np.max(np.hypot(*(band.bent(at) - band.straight(at)).T)) for at in drawing.frames(run.history)]
        largest = float(np.max(off))
        if ROUNDING * wide < largest < SEEN * wide:
            factor = LARGER * wide / largest
            power = 10.0 ** math.floor(math.log10(factor))
            # The largest of 1, 2, 5, 10, 20… that is not above the factor, which rounding may leave a hair below a
            # round number that it is.
            step = max(step for step in (1.0, 2.0, 5.0) if step * power <= factor * (1.0 + 1e-9))
            factors.append((band, step * power))
    return factors


def draw(run: Run, times: Sequence[float] | None = None) -> Figure:
    """Draw the mechanism at some times of a run, in scale, its contact forces as arrows.

    **Arguments:**

    - ``run``: one simulated with ``history=True``.
    - ``times``: [s] (default: the start, the largest impacts, the end).

    **Returns:** a matplotlib figure; ``figure.savefig("motion.svg")`` writes it.

    **Raises:** `InputError` for a run without a history, and for no times at all or one outside the run.

    **Example:**

    >>> run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(), history=True)
    >>> figure = jb.draw(run, times=[0.0, 0.1, float(run.peak_time)])
    >>> [axes.get_title(loc="left") for axes in figure.axes][::2]
    ['0.0000 s, no contact', '0.1000 s, no contact', '0.2114 s, 1831 N']
    """
    check_type("run", run, Run, "a run, such as jb.simulate(jb.table2(), history=True)")
    if run.history is None:
        raise InputError("this run has no history to draw; simulate it with history=True")
    if times is not None:
        if not len(times):
            raise InputError("times is empty; give one time [s] at least, or none at all for telling ones")
        end = float(np.asarray(run.history.time)[-1])
        for time in times:
            if not 0.0 <= float(time) <= end * (1.0 + 1e-12):
                raise InputError(f"times: {float(time):.6g} s is outside the run, which lasts from 0 to {end:.6g} s")
    return motion_figure(run, times)


@styled
def motion_figure(run: Run, times: Sequence[float] | None = None) -> Figure:
    """Draw a row for each time: the whole mechanism, and a closer look at the contact.

    **Arguments:** ``run``: one with a history; ``times`` [s] (default: telling ones).
    """
    at = scene(run, telling_times(run) if times is None else times)
    count, detail = len(at.times), at.drawing.detail
    wide, high = at.views[0, 1] - at.views[0, 0]
    row = float(np.clip(6.0 * high / wide, 1.5, 2.9)) + 0.75  # inch
    columns = 1 if detail is None else 2
    width = min(6.6, (row - 0.75) * wide / high + 0.9)  # no wider than what is drawn
    figure = blank(max(width + (columns - 1) * row, 6.0), row * count + 1.0)
    ratios = [width] if detail is None else [width, row]
    grid = figure.subplots(count, columns, squeeze=False, width_ratios=ratios)
    named: dict[str, Any] = {}
    for k in range(count):
        named |= whole(grid[k, 0], at, k)
        grid[k, 0].set_title(caption(at, k))
        if detail is not None:
            # The parts of the whole come first in the legend, and their entries stay where both name a part.
            named = named | closer(grid[k, 1], at, k) | named
    legend_below(figure, list(named.values()), list(named))
    arrows = ". Arrows: contact force" if at.arrows.size else ""
    figure.suptitle(f"{run.mechanism.view.title}, {run.mechanism.view.approach(run.scenario)}{arrows}")
    return figure


def caption(at: Scene, k: int) -> str:
    """Return time and contact force of a panel: "0.4881 s, 253 N on the upper flank"."""
    normal, kind, names = np.asarray(at.instants.contact_force)[k], at.run.mechanism.view.contact, contact_names(at.run)
    acting = [
        _acting(force, at.peak) + (f" on the {name} {kind}" if len(names) > 1 else "")
        for name, force in zip(names, normal, strict=True)
        if force > 0.0
    ]
    end = float(np.asarray(at.run.history.time)[-1])  # type: ignore[union-attr]
    # Where there is nothing to touch, that nothing touches says nothing.
    touching = [" and ".join(acting) or "no contact"] if len(normal) else []
    events = [words for words, time in at.moments.items() if abs(time - at.times[k]) <= SAME * end]
    return ", ".join([clock(at.times[k], end), *touching, *events])


def contact_names(run: Run) -> list[str]:
    """Return what the contacts of a run with a history are called; nothing of a mechanism without any."""
    count = np.shape(run.history.contact_force)[1]  # type: ignore[union-attr]
    return [*run.mechanism.view.names(run.design).of_contacts(count)]


def _acting(force: float, peak: float) -> str:
    """Return a force in words: "253.1 N"; "touching" below a ten-thousandth of the run's ``peak`` [N]."""
    return "touching" if force < 1e-4 * peak else force_text(force, peak)


def clock(time: float, end: float, more: int = 0) -> str:
    """Return a time of a run that lasts until ``end`` [s], in words: "0.4881 s", "0.251 ms"; with so many ``more``
    digits."""
    return f"{time:.{4 + more}f} s" if end > 0.1 else f"{1e3 * time:.{3 + more}f} ms"


def whole(axes: Axes, at: Scene, k: int) -> dict[str, Any]:
    """Draw the whole mechanism at the k-th time, with a frame around what the detail shows; return the legend's
    parts."""
    frames, ((left, low), (right, high)) = at.frames[k], at.views[k]
    named = sketch(axes, at.drawing.shapes, frames)
    for (band, times), (colour, dashes) in zip(at.magnified, BENT, strict=False):
        (line,) = axes.plot(*band.bent(frames, times).T, linestyle=dashes, color=colour, linewidth=1.6, zorder=3)
        named[f"bending of the {band.part} × {times:g}"] = line
    forces(axes, at.arrows[k, 0], *_arrows(at, 0.2 * max(right - left, high - low)))
    detail = at.drawing.detail
    # A frame nearly as large as the picture would not show where the detail is.
    if detail is not None and detail.framed and (h := _half(at, k)) < 0.2 * (right - left):
        x, y = detail.centre.at(frames)
        axes.plot([x - h, x + h, x + h, x - h, x - h], [y - h, y - h, y + h, y + h, y - h], ":", color=GREY, zorder=3)
    axes.set_xlim(left, right)
    axes.set_ylim(low, high)
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    return named


def closer(axes: Axes, at: Scene, k: int) -> dict[str, Any]:
    """Draw the detail at the k-th time; return the legend's parts that only it has."""
    detail, frames = at.drawing.detail, at.frames[k]
    assert detail is not None
    middle, half = detail.centre.at(frames), _half(at, k)
    named = sketch(axes, detail.shapes or at.drawing.shapes, frames, MM, middle, fills(at.drawing.shapes))
    forces(axes, at.arrows[k, 1], *_arrows(at, 0.8 * half), MM, middle)
    if at.path is not None:
        way = at.path[np.asarray(at.run.history.time) <= at.times[k]] - middle  # type: ignore[union-attr]
        axes.plot(*(way / MM).T, "-", color=INK, linewidth=1.3, zorder=3)
    axes.set_xlim(-half / MM, half / MM)
    axes.set_ylim(-half / MM, half / MM)
    axes.set_title(detail.title)
    axes.set_xlabel(detail.axes[0])
    axes.set_ylabel(detail.axes[1])
    return named if detail.shapes else {}


def _half(at: Scene, k: int) -> float:
    """Return half the width of the detail at the k-th time [m], wide enough to show what the ball may touch next."""
    detail, frames = at.drawing.detail, at.frames[k]
    assert detail is not None
    middle = detail.centre.at(frames)
    away = [float(np.max(np.abs(touch.at(frames)[0] - middle))) for touch in at.drawing.touches]
    return max(detail.half, FREE * min(away, default=0.0))


def telling_times(run: Run, count: int = PANELS) -> Float[np.ndarray, " times"]:
    """Return the start, the instants of the largest forces and of what elements do, and the end [s]; where there are
    few, those of the closest approach and of the largest values of the mechanism's quantities, and evenly spaced
    ones."""
    if run.history is None:
        return np.zeros(1)
    end, busy = float(np.asarray(run.history.time)[-1]), last_contact(run)
    peaks: list[float] = []
    for pulse in sorted(pulses(run), key=lambda pulse: -pulse.force):
        # Two places stay free, for the start and the end.
        if len(peaks) < count - 2 and all(abs(pulse.peak - other) > APART * busy for other in peaks):
            peaks.append(pulse.peak)

    def apart(time: float, others: Sequence[float], least: float = APART) -> bool:
        return all(abs(time - other) > least * busy for other in others)

    # What elements do is shown besides the largest forces, also soon before or after one of these.
    events: list[float] = []
    for time in moments(run).values():
        if len(events) < MOMENTS and time <= end and apart(time, [*peaks, *events], SAME):
            events.append(time)
    chosen = [*peaks, *events]
    # Start and end come first: extremes and evenly spaced times only fill up what is left.
    for time in [0.0, end, *_extremes(run), *np.linspace(0.0, busy, count + 1)]:
        if len(chosen) < count + len(events) and apart(time, chosen):
            chosen.append(float(time))
    return np.sort(chosen)


def moments(run: Run) -> dict[str, float]:
    """Return when the elements of a run do something that a picture should show [s], by what happens in words."""
    each = (it.report.moments(run) for it in run.elements)
    return {words: time for found in each for words, time in found.items() if math.isfinite(time)}


def _extremes(run: Run) -> list[float]:
    """Return when balls are nearest to what they may touch, if nothing touches, and when the mechanism's own quantities
    are largest [s]."""
    history: Any = run.history
    gap = np.asarray(history.gap)
    nearest = []
    if gap.shape[1] and not np.any(np.asarray(history.contact_force) > 0.0):
        nearest = [float(np.asarray(history.time)[np.argmin(np.min(gap, axis=1))])]
    own = [time for name, time in run.maximum_times.items() if name in run.mechanism.quantities]
    return [*nearest, *(time for time in own if math.isfinite(time))]


def _arrows(at: Scene, longest: float) -> tuple[float, float]:
    """Return the length [m] of an arrow for 1 N, and of the longest."""
    # A run in which nothing touches has a peak of zero.
    return longest / max(at.peak, 1e-300), longest


def _views(
    drawing: Drawing, frames: Float[np.ndarray, "times frames 3"], magnified: Sequence[tuple[Band, float]] = ()
) -> Float[np.ndarray, "times 2 2"]:
    """Return the view at each time, lower left and upper right corner [m].

    All views have one size, and one place too unless the mechanism travels.
    """
    corners = np.array([bounds(drawing, each) for each in frames])
    for band, times in magnified:
        lines = np.array([band.bent(each, times) for each in frames])
        corners[:, 0] = np.minimum(corners[:, 0], lines.min(axis=1))
        corners[:, 1] = np.maximum(corners[:, 1], lines.max(axis=1))
    size = np.max(corners[:, 1] - corners[:, 0], axis=0)
    overall = corners[:, 1].max(axis=0) - corners[:, 0].min(axis=0)
    middle = corners.mean(axis=1)
    if np.all(overall < 1.4 * size.max()):
        size = overall
        middle = np.broadcast_to(0.5 * (corners[:, 1].max(axis=0) + corners[:, 0].min(axis=0)), middle.shape)
    # No side is shorter than a share of the longest, so that a slender mechanism has room about it.
    half = 0.5 * MARGIN * np.maximum(size, 0.15 * size.max())
    return np.stack([middle - half, middle + half], axis=1)
