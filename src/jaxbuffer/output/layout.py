"""Texts that fit: titles, labels and legends wrapped to the room that there is, measured rather than guessed."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.text import Text

POINTS = 72.0  # an inch
ROOM = 8.0  # points between two texts side by side
ROUNDS = 3  # of wrapping: wrapped texts move the axes, which changes the room a little
HANDLE, GAP, EDGE = 2.8, 2.0, 1.0  # of a legend in font sizes: handle with its pad, between columns, around it


def fit(figure: "Figure") -> None:
    """Place the figure's axes, wrap the texts that are too long for their place, and fix the result."""
    if figure.get_layout_engine() is None:
        return
    for _ in range(ROUNDS):
        figure.draw_without_rendering()
        if not _wrap_all(figure):
            break
    figure.set_layout_engine("none")


def legend_below(figure: "Figure", handles: Sequence[Any], names: Sequence[str]) -> None:
    """Add a legend below the axes, with as many columns as the figure is wide enough for; none of no names."""
    if not names:
        return
    from matplotlib import rcParams
    from matplotlib.font_manager import FontProperties

    size = FontProperties(size=rcParams["legend.fontsize"]).get_size_in_points()
    room = POINTS * figure.get_figwidth() - 2.0 * EDGE * size
    names = [wrapped(name, room - HANDLE * size, size) for name in names]
    wide = [max(map(lambda line: width(line, size), name.split("\n"))) + HANDLE * size for name in names]
    columns = len(names)
    # matplotlib fills a legend column by column, as evenly as array_split does
    while columns > 1 and sum(map(max, np.array_split(wide, columns))) + (columns - 1) * GAP * size > room:
        columns -= 1
    figure.legend(handles, names, loc="outside lower center", ncols=max(columns, 1))


def width(text: str, size: float) -> float:
    """How wide a line of text of this font size is [points]."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    return float(text_to_path.get_text_width_height_descent(text, FontProperties(size=size), False)[0])


def wrapped(text: str, room: float, size: float) -> str:
    """The text with line breaks between words, so that no line is wider than ``room`` [points] if words allow it."""
    lines = []
    for line in text.split("\n"):
        made = ""
        for word in line.split(" "):
            longer = f"{made} {word}" if made else word
            if made and width(longer, size) > room:
                lines.append(made)
                longer = word
            made = longer
        lines.append(made)
    return "\n".join(lines)


def _wrap_all(figure: "Figure") -> bool:
    """Wrap the texts that are too long for where they stand, and return whether there were any."""
    changed = False
    for text, room in _rooms(figure):
        said = wrapped(text.get_text(), room, text.get_size())
        changed |= said != text.get_text()
        text.set_text(said)
    return changed


def _rooms(figure: "Figure") -> Iterator[tuple["Text", float]]:
    """The figure's title, its axes' titles and labels, and how wide each may be [points]."""
    from matplotlib.text import Text

    points, boxes = POINTS / figure.dpi, {axes: axes.get_tightbbox() for axes in figure.axes}
    for text in figure.texts:
        yield text, POINTS * figure.get_figwidth() - ROOM
    for axes in figure.axes:
        own = axes.get_window_extent()
        # a title may go on to the right, up to the next axes beside it
        right = [box.x0 for other, box in boxes.items() if other.get_position().x0 > axes.get_position().x0
                 and box.y0 < own.y1 + ROOM / points and own.y1 < box.y1]  # fmt: skip
        for text in axes.get_children():
            if isinstance(text, Text) and text.get_text() and text not in axes.texts:
                yield text, points * (min(right, default=figure.bbox.x1) - own.x0) - ROOM
        for axis, length in ((axes.xaxis, own.width), (axes.yaxis, own.height)):
            yield axis.label, points * length
