"""How figures look: colours, panels, labels."""

import contextlib
import functools
import io
import os
import sys
from collections.abc import Callable, Iterator
from typing import Any, ParamSpec

import numpy as np

from .._types import Axes, Figure
from ..errors import InputError
from .layout import DOTS_PER_INCH, fit

P = ParamSpec("P")

# Okabe and Ito's colours, told apart by everyone; lightness differs too
BLUE, ORANGE, GREEN, PURPLE, SKY, RED, GREY = (
    "#0072B2",
    "#E69F00",
    "#009E73",
    "#CC79A7",
    "#56B4E9",
    "#D55E00",
    "#888888",
)
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, RED, "#000000")
# In threes whose lightness differs: each three has dashes, or hatching, of its own.
CURVES = (BLUE, ORANGE, GREEN, PURPLE, RED, "#000000", SKY, BLUE, GREEN, ORANGE, "#000000", BLUE)
HATCHES = ("", "////", "....", "xxxx")
STYLES = ("-", "--", "-.", ":")
MARKS = ("o", "s", "^", "v", "D", "P", "X", "<", ">", "p", "h")
COLUMNS = 3
STYLE: dict[Any, Any] = {
    "axes.grid": True,
    "axes.labelsize": 9,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 10,
    "font.size": 9,
    "grid.alpha": 0.3,
    "legend.edgecolor": "none",
    "legend.fontsize": 8,
    "legend.framealpha": 0.6,
    "lines.linewidth": 1.2,
    "svg.hashsalt": "jaxbuffer",
}


def require_matplotlib() -> None:
    """Import matplotlib, also with an MPLBACKEND that it does not know: figures are drawn here without any.

    **Raises:** `InputError` if it is not installed, or the user's matplotlibrc keeps it from being imported.
    """
    before = os.environ.get("MPLBACKEND")
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise InputError("figures need matplotlib; install it with: pip install matplotlib") from None
    except Exception as error:
        if before is None:
            raise InputError(f"figures need matplotlib, which cannot be imported here: {error}") from None
        for name in [name for name in sys.modules if name.startswith("matplotlib.")]:
            del sys.modules[name]  # imported in part
        try:
            del os.environ["MPLBACKEND"]
            require_matplotlib()
        finally:
            os.environ["MPLBACKEND"] = before


@contextlib.contextmanager
def drawing() -> Iterator[None]:
    """Use matplotlib's own defaults and our style until the end of the block, whatever the user's matplotlibrc says.

    A figure must be drawn and saved inside it: ticks and their labels are made when a figure is saved.
    """
    require_matplotlib()
    from cycler import cycler
    from matplotlib import rcParams
    from matplotlib import style as styles

    # The defaults would replace the path of ffmpeg, which the user may have set.
    ours = {"axes.prop_cycle": cycler(color=COLOURS), "animation.ffmpeg_path": rcParams["animation.ffmpeg_path"]}
    with styles.context(["default", STYLE | ours]):
        yield


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Draw in our style, with texts that fit, and leave matplotlib's settings as they were."""

    @functools.wraps(draw)
    def styled(*data: P.args, **options: P.kwargs) -> Figure:
        with drawing():
            figure = draw(*data, **options)
            fit(figure)
            return figure

    return styled


def png(figure: Figure) -> bytes:
    """Return the figure as a PNG file's content."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    content = io.BytesIO()
    with _fitted(figure, DOTS_PER_INCH):
        FigureCanvasAgg(figure).print_png(content)
    return content.getvalue()


def svg(figure: Figure) -> bytes:
    """Return the figure as an SVG file's content; the same figure gives the same bytes."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    content = io.BytesIO()
    with _fitted(figure, figure.dpi):  # which the file does not depend on
        # Without the date, and with a fixed salt for identifiers (`STYLE`), the bytes depend on the figure alone.
        FigureCanvasSVG(figure).print_svg(content, metadata={"Date": None})
    return content.getvalue()


@contextlib.contextmanager
def _fitted(figure: Figure, dots_per_inch: float) -> Iterator[None]:
    """Hold a figure fitted and in our style while a canvas prints it, which draws it once; `savefig` draws twice."""
    before = figure.dpi
    with drawing():
        fit(figure)
        figure.dpi = dots_per_inch
        try:
            yield
        finally:
            figure.dpi = before


def both(name: str, draw: Callable[[], Figure]) -> dict[str, Callable[[], bytes]]:
    """Return a figure's two files, NAME.png and NAME.svg, and what makes their contents; it is drawn once."""
    drawn = functools.cache(draw)
    return {f"{name}.png": lambda: png(drawn()), f"{name}.svg": lambda: svg(drawn())}


def blank(width: float, height: float, layout: Any = "constrained") -> Figure:
    """Return a figure [inch] of its own: pyplot's global state stays as it is."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout=layout)


def panels(width: float, height: float, rows: int, columns: int) -> tuple[Figure, np.ndarray]:
    """Return a figure [inch] and its axes."""
    figure = blank(width, height)
    return figure, figure.subplots(rows, columns, squeeze=False)


def label(axes: Axes, title: str, x: str, y: str, legend: bool = True, columns: int = 1, beside: bool = False) -> None:
    """Set title, labels with their units and, if asked for, a legend in columns; ``beside``: to the right of the axes,
    where it hides no curve."""
    axes.set_title(title)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if legend:
        place: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0)} if beside else {}
        axes.legend(ncols=columns, **place)


def curve(number: int) -> dict[str, Any]:
    """Return colour and dashes of a curve among others in one panel: solid for the first three, whose lightness
    differs."""
    return {"color": CURVES[number % len(CURVES)], "linestyle": STYLES[number // 3 % len(STYLES)]}


def hatch(number: int) -> str:
    """Return the hatching of an area in the colour of `curve`, which keeps areas apart without colours."""
    return HATCHES[number // 3 % len(HATCHES)]


def line(number: int) -> dict[str, Any]:
    """Return colour and dashes of the curve of a number, told apart by everyone."""
    return {"color": COLOURS[number % len(COLOURS)], "linestyle": STYLES[number % len(STYLES)]}
