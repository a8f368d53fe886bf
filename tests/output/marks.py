"""Whether the entries of a figure's legends can be told apart, in colour and in grey."""

import itertools

import numpy as np
from matplotlib.collections import PathCollection, PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D

SHADE = 0.06  # difference in lightness from which on two shades of grey are told apart


def check_marks(figure):
    """Assert that no two entries of any legend share marker, dashes, hatching and fill with a like shade of grey, and
    return how many entries there are."""
    legends = [*figure.legends, *filter(None, (axes.get_legend() for axes in figure.axes))]
    count = 0
    for legend in legends:
        entries = [(text.get_text(), *_mark(it)) for text, it in zip(legend.get_texts(), _handles(legend), strict=True)]
        count += len(entries)
        for (one, form, shade), (other, form_of_other, shade_of_other) in itertools.combinations(entries, 2):
            alike = form == form_of_other and abs(shade - shade_of_other) < SHADE
            assert not alike, f"{one!r} and {other!r} are drawn alike: {form}, {shade:.2f} and {shade_of_other:.2f}"
    return count


def _handles(legend):
    return legend.legend_handles


def _mark(handle):
    """What a handle looks like without colour, and its lightness."""
    if isinstance(handle, Line2D):
        marker, lined = handle.get_marker(), handle.get_linestyle() not in ("", "None", "none")
        shown = "" if marker in (None, "None", "") else marker
        # a line's dashes, also where they are not one of the four named ones
        dashes = (str(handle._unscaled_dash_pattern), handle.get_linewidth() > 2.0) if lined else ""
        hollow = shown and (handle.get_fillstyle() == "none" or handle.get_markerfacecolor() == "white")
        colour = handle.get_color() if lined or hollow else handle.get_markerfacecolor()
        return (shown, dashes, bool(hollow)), _lightness(colour)
    if isinstance(handle, PathCollection):  # a scatter: its marker is a path
        return ("path", handle.get_paths()[0].vertices.round(3).tobytes()), _lightness(handle.get_facecolor()[0])
    if isinstance(handle, PolyCollection):
        return ("area", handle.get_hatch()), _lightness(handle.get_facecolor()[0])
    return ("patch", handle.get_hatch()), _lightness(handle.get_facecolor())


def _lightness(colour):
    return float(np.dot(to_rgb(colour), (0.299, 0.587, 0.114)))
