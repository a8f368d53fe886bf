"""A run as an animation: slow motion around the largest impacts, evenly in between, faster after the last contact."""

import io
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Float

from .._types import Axes
from ..errors import InputError, check_choice, check_type
from ..files import user_path, write
from ..mechanisms.run import Run
from ..run.instants import at_times
from .field_files import coloured
from .layout import POINTS, with_line_breaks
from .motion import Scene, caption, clock, closer, contact_names, scene, whole
from .pulses import fine_times, last_contact, pulses
from .style import blank, curve, drawing, require_matplotlib

FORMATS = ("gif", "mp4")
RATE = 20  # frames a second
EVEN, SLOW = 80, 24  # frames in between, and of each impact in slow motion
IMPACTS = 3  # how many of them
ROOM = 0.5  # of an impact's duration, before and after it
STILL = 10  # frames at the end
DOTS_PER_INCH = 90
BAR = 1.0  # inch, for the meaning of colours
LINE = 0.19  # inch, of each further line of the title
ROOM_OF_TITLE = 8.0  # points, at either side
Report = Callable[[int, int], None]


class Frames(NamedTuple):
    """The ``times`` of an animation's frames [s], and how many times ``slower`` than in truth each is shown [-]."""

    times: Float[np.ndarray, " frames"]
    slower: Float[np.ndarray, " frames"]


def frames_of(run: Run) -> Frames:
    """Return evenly spaced times, and many more around each of the run's largest impacts."""
    assert run.history is not None
    end, busy = float(np.asarray(run.history.time)[-1]), last_contact(run)
    even = busy / EVEN
    slow: list[tuple[float, float, float]] = []
    for pulse in sorted(pulses(run), key=lambda pulse: -pulse.force):
        room = ROOM * (pulse.end - pulse.start)
        window = max(pulse.start - room, 0.0), min(pulse.end + room, busy)
        # Windows of slow motion must not overlap, because time would go back between them.
        apart = all(window[1] < other[0] or window[0] > other[1] for other in slow)
        # Slow motion must show at least twice as many frames as even ones would.
        if len(slow) < IMPACTS and apart and 0.0 < window[1] - window[0] < 0.5 * SLOW * even:
            slow.append((*window, pulse.peak))
    times, steps, at = [], [], 0.0
    for start, stop, peak in [*sorted(slow), (busy, busy, busy)]:
        fine = (stop - start) / SLOW
        if start + fine < peak:  # even steps that lead to the largest force, so that a frame shows it
            fine = (peak - start) / round((peak - start) / fine)
        for first, last, step in ((at, start, even), (start, stop, fine)):
            # The last pair is no impact: its step of zero would be none of a range.
            part = np.arange(first, last, step) if last > first else np.zeros(0)
            times.append(part)
            steps.append(np.full(len(part), step))
        at = stop
    if busy < end:  # what follows the last contact is long and slow: it is shown faster
        even = (end - busy) / EVEN
        # Half a step short, because the end itself is added below.
        times.append(np.arange(busy, end - 0.5 * even, even))
        steps.append(np.full(len(times[-1]), even))
    # A range leaves out its end. A frame is slower by the time for which it is shown over the time that it spans.
    return Frames(np.append(np.concatenate(times), end), 1.0 / (RATE * np.append(np.concatenate(steps), even)))


def animate(run: Run, path: str | Path) -> Path:
    """Write a run's animation: the mechanism in scale, contact forces as arrows, slow motion around the impacts.

    **Arguments:**

    - ``run``: one simulated with ``history=True``.
    - ``path``: of the file; its ending says the format, ".gif" or, where ffmpeg is installed, ".mp4".

    **Returns:** the path.

    **Raises:** `InputError` for a run without a history, another ending, and for ".mp4" without ffmpeg.

    **Example:**

    >>> run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(), 0.01, history=True)
    >>> jb.animate(run, "drop.gif").name
    'drop.gif'
    """
    path = user_path(path)
    write(path, animation(run, path.suffix.removeprefix(".")))
    return path


def check_format(kind: str) -> None:
    """Raise `InputError` for a format that cannot be written here."""
    require_matplotlib()
    from matplotlib.animation import FFMpegWriter

    check_choice("format", kind, FORMATS)
    if kind == "mp4" and not FFMpegWriter.isAvailable():
        raise InputError("format = 'mp4' needs ffmpeg, which is not installed; take 'gif'")


def animation(run: Run, kind: str = "gif", report: Report = lambda done, count: None) -> bytes:
    """Return the content of an animation's file.

    **Arguments:** ``kind``: "gif" or "mp4"; ``report``: called with the frames done and all of them.
    """
    check_type("run", run, Run, "a run, such as jb.simulate(jb.table2(), history=True)")
    check_format(kind)
    if run.history is None:
        raise InputError("this run has no history to draw; simulate it with history=True")
    frames = frames_of(run)
    with drawing():
        stage = Stage(scene(run, frames.times))
        return (_gif if kind == "gif" else _mp4)(stage, frames, report)


def _gif(stage: "Stage", frames: Frames, report: Report) -> bytes:
    """Return a GIF, drawn frame by frame with 256 colours each."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    stage.figure.set_dpi(DOTS_PER_INCH)
    canvas, film = FigureCanvasAgg(stage.figure), []
    for k, slower in enumerate(frames.slower):
        stage.show(k, slower)
        canvas.draw()
        picture = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
        # Dithering would make areas of one colour grainy, and grain compresses badly.
        film.append(picture.quantize(dither=Image.Dither.NONE))
        report(k + 1, len(frames.times))
    content, shown = io.BytesIO(), [1000 // RATE] * (len(film) - 1) + [1000 * STILL // RATE]  # ms
    film[0].save(content, "GIF", save_all=True, append_images=film[1:], duration=shown, loop=0, optimize=True)
    return content.getvalue()


def _mp4(stage: "Stage", frames: Frames, report: Report) -> bytes:
    """Return an MP4 file's content, made by ffmpeg."""
    from matplotlib.animation import FFMpegWriter

    writer, count = FFMpegWriter(RATE), len(frames.times)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "motion.mp4"
        with writer.saving(stage.figure, str(file), 2 * (DOTS_PER_INCH // 2)):
            for k, slower in enumerate(frames.slower):
                stage.show(k, slower)
                # All frames of a film last equally long, so that the last one is repeated.
                for _ in range(STILL if k == count - 1 else 1):
                    writer.grab_frame()
                report(k + 1, count)
        return file.read_bytes()


class Stage:
    """The figure that an animation's frames are drawn on: mechanism, closer look, force over time with a cursor."""

    def __init__(self, at: Scene) -> None:
        self.at, detail = at, at.drawing.detail
        (wide, high) = at.views[0, 1] - at.views[0, 0]
        row = float(np.clip(5.2 * high / wide, 1.8, 3.4))  # inch
        self.meshes = at.run.mechanism.view.meshes(at.run, at.times)
        width = (6.6 if detail is None else 6.7 + row) + (BAR if self.meshes else 0.0)
        title = _title(at.run, width)
        tall = row + 2.9 + LINE * title.count("\n")
        # A layout engine would move the axes from frame to frame, as titles and labels change.
        self.figure = blank(width, tall, layout=None)
        low, top = 2.2 / tall, row / tall
        self.whole = self.figure.add_axes((0.7 / width, low, 5.2 / width, top))
        self.detail: Axes | None = None
        if detail is not None:
            self.detail = self.figure.add_axes((6.55 / width, low, row / width, top))
        self.force = self.figure.add_axes((0.7 / width, 0.45 / tall, 1.0 - 0.85 / width, 1.05 / tall))
        if self.meshes:
            from matplotlib.cm import ScalarMappable
            from matplotlib.colors import Normalize

            # The colours of the first of the cells' values mean the same in all frames.
            self.colour = next(iter(self.meshes[0].values))
            values = np.stack([mesh.values[self.colour] for mesh in self.meshes])
            self.ends = float(np.nanmin(values)), float(np.nanmax(values))
            bar = self.figure.add_axes((1.0 - 0.9 * BAR / width, low, 0.12 / width, top))
            self.figure.colorbar(ScalarMappable(Normalize(*self.ends)), cax=bar, label=self.colour)
        self.figure.suptitle(title, y=1.0 - 0.1 / tall)
        self.cursor = _curves(self.force, at.run)

    def show(self, k: int, slower: float) -> None:
        """Draw the k-th frame, shown so many times ``slower`` than in truth."""
        self.whole.clear()
        whole(self.whole, self.at, k)
        if self.meshes:
            # Above the filled parts, and below contact arrows and bending that is drawn larger.
            coloured(self.whole, self.meshes[k], self.colour, self.ends).set_zorder(2.5)
        end = float(np.asarray(self.at.run.history.time)[-1])  # type: ignore[union-attr]
        self.whole.set_title(f"{clock(self.at.times[k], end, 2)}, {speed_in_words(slower)}", family="monospace")
        if self.detail is not None:
            self.detail.clear()
            closer(self.detail, self.at, k)
        # Without the time, which the clock above tells with more digits.
        self.force.set_title(", ".join(caption(self.at, k).split(", ")[1:]))
        self.cursor.set_xdata([self.at.times[k], self.at.times[k]])


def _title(run: Run, width: float) -> str:
    """Return what a run is, in lines that fit into a figure of this ``width`` [inch]."""
    from matplotlib import rcParams
    from matplotlib.font_manager import FontProperties

    size = FontProperties(size=rcParams["figure.titlesize"]).get_size_in_points()
    text = f"{run.mechanism.view.title}, {run.mechanism.view.approach(run.scenario)}"
    return with_line_breaks(text, POINTS * width - 2.0 * ROOM_OF_TITLE, size)


def speed_in_words(slower: float) -> str:
    """Return a pace in words with two digits: "slowed 140 times", "shown 2.5 times faster"."""
    digits = f"{float(f'{max(slower, 1.0 / slower):.2g}'):g}"
    return f"slowed {digits} times" if slower >= 1.0 else f"shown {digits} times faster"


def _curves(axes: Axes, run: Run) -> Any:
    """Draw the contact forces over time and return the cursor."""
    names, time = contact_names(run), fine_times(run)
    if not names:
        return _own_curves(axes, run, time)
    force = np.asarray(at_times(run, time).contact_force)
    for k, name in enumerate(names):
        label = run.mechanism.view.contact_in_words(name)
        axes.plot(time, force[:, k], **curve(k), linewidth=0.9, label=label)
    if len(names) > 1:
        # Above the axes, whose title stands to the left: there it hides no curve.
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(names), borderaxespad=0.1)
    room = 0.01 * (time[-1] - time[0])
    axes.set_xlim(time[0] - room, time[-1] + room)
    # A run without a contact has no force to scale by.
    axes.set_ylim(0.0, 1.25 * max(float(force.max(initial=0.0)), 1e-12))
    return _with_cursor(axes, "force [N]")


def _own_curves(axes: Axes, run: Run, time: Float[np.ndarray, " n"]) -> Any:
    """Draw the mechanism's first panel in place of contact forces, and return the cursor."""
    fine = eqx.tree_at(lambda it: it.history, run, at_times(run, time))
    panel = next((it for it in run.mechanism.view.panels(fine) if not (it.path or it.stacked)), None)
    for k, drawn in enumerate(() if panel is None else panel.curves):
        axes.plot(time, np.asarray(drawn.values), **curve(k), linewidth=0.9)
    axes.set_xlim(time[0], time[-1])
    return _with_cursor(axes, "" if panel is None else panel.axis)


def _with_cursor(axes: Axes, name: str) -> Any:
    axes.set_xlabel("time [s]")
    axes.set_ylabel(name)
    return axes.axvline(0.0, color="black", linestyle=":", linewidth=1.2)
