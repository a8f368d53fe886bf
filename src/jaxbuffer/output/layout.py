"""Texts that fit: titles, labels and legends wrapped to the room that there is, measured rather than guessed."""

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from .._types import Figure, Text

POINTS = 72.0  # an inch
DOTS_PER_INCH = 150  # of PNG files
ROOM = 8.0  # points between two texts side by side
ROUNDS = 4  # of wrapping and leaving out: both move the axes, which changes the room a little
HANDLE, GAP, EDGE = 2.8, 2.0, 1.0  # of a legend in font sizes: handle with its pad, between columns, around it


def fit(figure: Figure) -> None:
    """Place the figure's axes, wrap texts and leave out labels of ticks that there is no room for; fix the result."""
    from matplotlib.transforms import Bbox

    engine = figure.get_layout_engine()
    if engine is None:
        return
    # Small letters are set to whole dots: at other dots an inch a line may be some per cent wider.
    before, figure.dpi = figure.dpi, DOTS_PER_INCH
    _lay_out(figure, engine)
    figure.dpi = before
    # Without an engine, saving the figure neither moves its axes again nor fits it a second time.
    figure.set_layout_engine(None)
    for axes in figure.axes:
        # The last digits of the engine's solution depend on what was drawn before, and with them the names in an SVG.
        if axes.get_subplotspec() is not None:
            axes.set_position(Bbox(np.round(axes.get_position(original=True).get_points(), 9)))


def _lay_out(figure: Figure, engine: Any) -> None:
    """Place the axes, wrap texts and leave out labels of ticks, which move the axes again, in a few rounds."""
    for _ in range(ROUNDS):
        # Only a figure that is laid out knows where its texts end; the engine measures them without drawing anything.
        engine.execute(figure)
        wrapped = False
        for text, room in _rooms(figure):
            broken = with_line_breaks(text.get_text(), room, float(text.get_fontsize()))
            wrapped |= broken != text.get_text()
            text.set_text(broken)
        # Not `or`: each round does both.
        if not wrapped | _thin_out(figure):
            break


def legend_below(figure: Figure, handles: Sequence[Any], names: Sequence[str]) -> None:
    """Add a legend below the axes, with as many columns as the figure is wide enough for; none of no names."""
    if not names:
        return
    from matplotlib import rcParams
    from matplotlib.font_manager import FontProperties

    size = FontProperties(size=rcParams["legend.fontsize"]).get_size_in_points()
    room = POINTS * figure.get_figwidth() - 2.0 * EDGE * size
    names = [with_line_breaks(name, room - HANDLE * size, size) for name in names]
    wide = [max(map(lambda line: width(line, size), name.split("\n"))) + HANDLE * size for name in names]
    columns = len(names)
    # matplotlib fills a legend column by column, as evenly as array_split does
    while columns > 1 and sum(map(max, np.array_split(wide, columns))) + (columns - 1) * GAP * size > room:
        columns -= 1
    figure.legend(handles, names, loc="outside lower center", ncols=max(columns, 1))


def width(text: str, size: float) -> float:
    """Return how wide a line of text of this font size is [points]."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    return float(text_to_path.get_text_width_height_descent(text, FontProperties(size=size), False)[0])


def with_line_breaks(text: str, room: float, size: float) -> str:
    """Return the text with line breaks, after commas rather than between words, so that no line is wider than ``room``
    [points] if its words allow it."""
    return "\n".join(part for line in text.split("\n") for part in _lines(line, room, size, (", ", " ")))


def _lines(line: str, room: float, size: float, separators: tuple[str, ...]) -> list[str]:
    if not separators or width(line, size) <= room:
        return [line]
    separator, mark = separators[0], separators[0].rstrip()
    first, *others = line.split(separator)
    parts = [first]
    for part in others:
        longer = f"{parts[-1]}{separator}{part}"
        if width(longer + mark, size) <= room:  # the mark stays at the end of a broken line
            parts[-1] = longer
        else:
            parts[-1] += mark
            parts.append(part)
    return [narrow for part in parts for narrow in _lines(part, room, size, separators[1:])]


def _rooms(figure: Figure) -> Iterator[tuple["Text", float]]:
    """Yield the figure's title, its axes' titles and labels, each with how wide it may be [points]."""
    from matplotlib.text import Text

    points, boxes = POINTS / figure.dpi, [(axes.get_position().x0, axes.get_tightbbox()) for axes in figure.axes]
    for text in figure.texts:
        yield text, POINTS * figure.get_figwidth() - ROOM
    for axes in figure.axes:
        own, begin = axes.get_window_extent(), axes.get_position().x0
        # a title may go on to the right, up to the next axes beside it
        right = [
            box.x0
            for place, box in boxes
            if box is not None and place > begin and box.y0 < own.y1 + ROOM / points and own.y1 < box.y1
        ]
        for child in axes.get_children():
            if isinstance(child, Text) and child.get_text() and child not in axes.texts:
                yield child, points * (min(right, default=figure.bbox.x1) - own.x0) - ROOM
        for label, length in ((axes.xaxis.label, own.width), (axes.yaxis.label, own.height)):
            yield label, points * length


def _thin_out(figure: Figure) -> bool:
    """Leave out every other tick of an axis on which labels overlap, and return whether there was one."""
    from matplotlib.ticker import FixedFormatter, FixedLocator

    changed = False
    for axes in figure.axes:
        for axis, low, high in ((axes.xaxis, "x0", "x1"), (axes.yaxis, "y0", "y1")):
            begin, end = sorted(axis.get_view_interval())
            ticks = [tick for tick in axis.get_major_ticks() if begin <= tick.get_loc() <= end]
            # a colour bar has its labels on the other side
            sides = [tick.label1 if tick.label1.get_visible() else tick.label2 for tick in ticks]
            # The upright boxes around turned labels overlap where the labels themselves do not.
            labels = [label for label in sides if label.get_text() and label.get_rotation() == 0.0]
            ends = sorted((getattr(box, low), getattr(box, high)) for box in (it.get_window_extent() for it in labels))
            if any(after[0] < before[1] for before, after in itertools.pairwise(ends)):
                places = [tick.get_loc() for tick in ticks[::2]]
                if isinstance(axis.get_major_formatter(), FixedFormatter):  # names, which go with their places
                    axis.set_ticks(places, [label.get_text() for label in sides[::2]])
                else:  # numbers, some of them with a common factor at the axis' end
                    axis.set_major_locator(FixedLocator(places))
                changed = True
    return changed
