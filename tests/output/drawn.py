"""What a figure looks like, measured: texts that overlap or leave it, axes without an area, entries drawn alike."""

import itertools

from matplotlib.text import Text

from jaxbuffer.output.layout import DOTS_PER_INCH
from output.marks import check_marks

ROUNDING = 1.0  # pixels that boxes of texts may share: they have a little room around the letters
LEAST = 0.3  # inch, of an axes' width and height


def check_readable(figure):
    """Assert that no text of a drawn figure overlaps another or leaves the figure, that every axes has an area, and
    that the entries of each legend can be told apart."""
    figure.dpi = DOTS_PER_INCH  # as it is printed: letters are set to whole dots
    figure.draw_without_rendering()
    check_marks(figure)
    texts = [(text.get_text(), text.get_window_extent()) for text in visible_texts(figure)]
    whole = figure.bbox
    for text, box in texts:
        inside = box.x0 > -ROUNDING and box.y0 > -ROUNDING
        inside &= box.x1 < whole.x1 + ROUNDING and box.y1 < whole.y1 + ROUNDING
        assert inside, f"{text!r} leaves the figure"
    for (one, first), (other, second) in itertools.combinations(texts, 2):
        wide = min(first.x1, second.x1) - max(first.x0, second.x0)
        high = min(first.y1, second.y1) - max(first.y0, second.y0)
        assert wide <= ROUNDING or high <= ROUNDING, f"{one!r} overlaps {other!r}"
    for axes in figure.axes:
        box = axes.get_window_extent()
        least = 0.1 if axes.get_label() == "<colorbar>" else LEAST
        assert min(box.width, box.height) > least * figure.dpi, f"{axes.get_title(loc='left')!r} has no area"


def visible_texts(figure):
    """The texts that are seen: labels of ticks beyond the ends of an axis are not."""
    beyond = set()
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            room = 1e-9 * (high - low)
            for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
                if not axis.get_visible() or not low - room <= tick.get_loc() <= high + room:
                    beyond |= {tick.label1, tick.label2}
    texts = figure.findobj(Text)
    return [text for text in texts if text.get_visible() and text.get_text().strip() and text not in beyond]
