"""How figures look: colours, panels, labels."""

import functools
import io
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ParamSpec

import numpy as np

from ..errors import InputError
from .layout import fit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
STYLES = ("-", "--", "-.", ":")
MARKS = ("o", "s", "^", "v", "D", "P", "X", "<", ">", "p", "h")
FLANK_COLOURS = (BLUE, ORANGE)
ITERATION = "iteration [-]"
COLUMNS = 3
DOTS_PER_INCH = 150
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
}


def style() -> dict[Any, Any]:
    """The settings of every figure: `STYLE`, and our colours in their order."""
    from cycler import cycler

    return STYLE | {"axes.prop_cycle": cycler(color=COLOURS)}


def require_matplotlib() -> None:
    """Raise `InputError` if matplotlib is not installed."""
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise InputError("figures need matplotlib; install it with: pip install matplotlib") from None


def styled(draw: "Callable[P, Figure]") -> "Callable[P, Figure]":
    """Draw in our style, with texts that fit, and leave matplotlib's settings as they were."""

    @functools.wraps(draw)
    def styled(*data: P.args, **options: P.kwargs) -> "Figure":
        require_matplotlib()
        import matplotlib

        with matplotlib.rc_context(style()):
            figure = draw(*data, **options)
            fit(figure)
            return figure

    return styled


def png(figure: "Figure") -> bytes:
    """The figure as a PNG file's content."""
    content = io.BytesIO()
    fit(figure)
    figure.savefig(content, format="png", dpi=DOTS_PER_INCH)
    return content.getvalue()


def svg(figure: "Figure") -> bytes:
    """The figure as an SVG file's content; the same figure gives the same bytes."""
    import matplotlib

    content = io.BytesIO()
    fit(figure)
    with matplotlib.rc_context({"svg.hashsalt": "jaxbuffer"}):
        figure.savefig(content, format="svg", metadata={"Date": None})
    return content.getvalue()


def both(name: str, draw: "Callable[[], Figure]") -> dict[str, Callable[[], bytes]]:
    """A figure's two files, NAME.png and NAME.svg, and what makes their contents; it is drawn once."""
    drawn = functools.cache(draw)
    return {f"{name}.png": lambda: png(drawn()), f"{name}.svg": lambda: svg(drawn())}


def panels(width: float, height: float, rows: int, columns: int) -> "tuple[Figure, np.ndarray]":
    """A figure [inch] of its own: pyplot's global state stays as it is."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False)


def label(axes: "Axes", title: str, x: str, y: str, legend: bool = True, columns: int = 1) -> None:
    """Title, labels with their units and, if asked for, a legend in columns."""
    from matplotlib.ticker import MaxNLocator

    axes.set_title(title)
    if x == ITERATION:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if legend:
        axes.legend(ncols=columns)


def line(number: int) -> dict[str, Any]:
    """Colour and dashes of the curve of a number, told apart by everyone."""
    return {"color": COLOURS[number % len(COLOURS)], "linestyle": STYLES[number % len(STYLES)]}
