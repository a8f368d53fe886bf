"""Algorithm 1 of the paper: the two components of IMPACT at instants 1e-4 s apart, beside all of the force."""

from functools import cache
from typing import Any

import numpy as np

from ..._types import Figure
from ...fields import replace
from ...mechanisms.bar_drop import BarDrop, BarDropScenario
from ...output.style import BLUE, COLOURS, ORANGE, drawing, label, panels
from ..claims import Claim, Row, cell, column, listed, near
from ..study import Studied, Study, StudyCase
from .bar_figures import OFFSETS
from .fixed_steps import components, peaks

INSTANTS = np.arange(0.0, 0.6, 1e-4)  # s, the algorithm's
STEPS = {"1e-3": 1e-3, "1e-4": 1e-4, "1e-6": 1e-6}  # s: the paper's two, and one that resolves the contact
OF_GRIDS: dict[str, Any] = {"": np.median, "_least": np.min, "_most": np.max}
PRINTED = {"1e-3": 205.0, "1e-4": 250.0}  # N, by steps of these lengths: for c = 1 and c = 6
SPEED = 1.325  # m/s, the printed one, in the figure of the damper
SPRING, DAMPER = range(2)
NAMES = ("peak_force", "spring", "spring_seen", "damper", "damper_seen", "damper_as_printed")
COLUMNS = dict.fromkeys((*NAMES, *(f"bdf_{step}{which}" for step in STEPS for which in OF_GRIDS)), "N")
SHOWN = tuple(COLUMNS)
STUDIES = (
    Study(
        "algorithm",
        "3-10",
        "IMPACT by components, and what Algorithm 1 sees of them",
        "damping c [N s/mm]",
        "y₁ is the height of the plate above the datum, so that the bar falls by 194 mm less y₁; the algorithm is "
        "given the motion of the rigid bar; bdf: backward differences of order 2",
        tuple(
            StudyCase(
                f"c = {c:g}, y₁ = {y1:g} mm",
                c,
                replace(BarDrop(), {"impact.damping": 1e3 * c}),
                BarDropScenario(height=0.194 - 1e-3 * y1),
                {"duration": 0.6, "rtol": 1e-8},
            )
            for c, y1 in ((1.0, 0.8), (6.0, 0.897))
        ),
    ),
)


def row(case: StudyCase, run: Any) -> Row:
    """Return what there is, what the algorithm's instants meet, and what backward differences at fixed steps
    compute."""
    whole, at_instants = _components(run), _components(run, INSTANTS)
    printed = _components(run, printed=True)[DAMPER]
    forces = float(run.peak_force), *(float(x.max()) for pair in zip(whole, at_instants, strict=True) for x in pair)
    return {
        "outcome": run.outcome.name,
        **dict(zip(NAMES, (*forces, float(printed.max())), strict=True)),
        **{
            f"bdf_{step}{which}": float(of(_peaks(case.value, step)))
            for step in STEPS
            for which, of in OF_GRIDS.items()
        },
    }


# For the row and for the figure.
@cache
def _peaks(damping: float, step: str) -> Any:
    """Return `peaks` of the study's case with a damping [N s/mm]."""
    (case,) = (case for case in STUDIES[0].cases if case.value == damping)
    return peaks(case.design, case.scenario, STEPS[step])


def _components(run: Any, at: Any = None, printed: bool = False) -> tuple[Any, Any]:
    """Return F₁ and F₂ of a run [N], at the steps of its history or at other times [s]."""
    history = run.history
    time, depth = np.asarray(history.time), -np.asarray(history.gap)[:, 0]
    at = time if at is None else at
    closing = np.interp(at, time, np.asarray(history.approach_speed)[:, 0])
    return components(run.design, np.interp(at, time, depth), closing, printed)


def figure(studied: Studied) -> Figure:
    """Draw the components over depth and over time, and the largest forces of fixed steps."""
    with drawing():
        drawn, grid = panels(10.0, 14.0, 5, 2)
        _over_depth(grid, studied.study.cases[0].design)
        for column, (case, run) in enumerate(zip(studied.study.cases, studied.captures, strict=True)):
            _over_time(grid[2, column], run, SPRING, f"Spring F₁, {case.label} (fig. {7 + 2 * column})")
            _over_time(grid[3, column], run, DAMPER, f"Damper F₂, {case.label} (fig. {8 + 2 * column})")
            axes = grid[4, column]
            for step, colour in zip(STEPS, COLOURS, strict=False):
                forces = np.sort(_peaks(case.value, step))
                axes.semilogy(np.linspace(0.0, 1.0, len(forces)), forces, color=colour, label=f"steps of {step} s")
            axes.set_ylim(top=4.0 * axes.get_ylim()[1])  # room for the legend
            label(axes, f"By backward differences, {case.label}", OFFSETS, "largest force [N]", legend=False)
            axes.legend(loc="upper left", ncols=3)
        drawn.suptitle(f"{studied.study.title} (the paper's fig. {studied.study.figures})")
        return drawn


def _over_depth(grid: Any, design: BarDrop) -> None:
    """Draw figures 3 to 6."""
    depth = np.linspace(-0.01, 0.03, 801)  # mm
    for printed, name, colour in ((False, "c STEP, 0 at the touch", BLUE), (True, "as printed, a = c", ORANGE)):
        _, damper = components(design, 1e-3 * depth, 1.0, printed)
        grid[0, 0].plot(depth, 1e-3 * damper, color=colour, label=name)
        grid[1, 0].plot(depth, SPEED * damper, color=colour, label=name)
    grid[0, 1].plot(10.0 * depth, components(design, 1e-2 * depth, 0.0)[SPRING])
    part = np.linspace(-1.0, 2.0, 301)
    grid[1, 1].plot(3.0 + part, np.clip(part, 0.0, 1.0) ** 2 * (3.0 - 2.0 * np.clip(part, 0.0, 1.0)))
    label(grid[0, 0], "Damping over depth (fig. 3)", "depth [mm]", "damping [N s/mm]")
    label(grid[0, 1], "Spring force over depth (fig. 4)", "depth [mm]", "force [N]", legend=False)
    label(grid[1, 0], f"Damping force over depth at {SPEED} m/s (fig. 5)", "depth [mm]", "force [N]")
    label(grid[1, 1], "STEP(x, 3, 0, 4, 1) (fig. 6)", "x [-]", "STEP [-]", legend=False)


def _over_time(axes: Any, run: Any, which: int, title: str) -> None:
    """Draw one component over 0.6 s, its first contact larger, and the algorithm's instants as dots."""
    time, first = np.asarray(run.history.time), float(run.impacts.time[0])
    closer = axes.inset_axes((0.5, 0.38, 0.45, 0.55))
    closer.set_xlabel("time from the first contact [ms]", fontsize=7)
    closer.tick_params(labelsize=7)
    for place, begin, many in ((axes, 0.0, 1.0), (closer, first, 1e3)):
        place.plot(many * (time - begin), _components(run)[which], color=BLUE, linewidth=0.9, label="computed")
        at = many * (INSTANTS - begin)
        place.plot(at, _components(run, INSTANTS)[which], ".", color=ORANGE, markersize=3, label="Algorithm 1")
    closer.set_xlim(-0.05, 0.35)
    label(axes, title, "time [s]", "force [N]", legend=False)
    axes.legend(loc="upper left")


SEEN = ("spring_seen", "spring", "damper_seen", "damper")
AS_PRINTED, MEANT = (cell("algorithm", 0, name) for name in ("damper_as_printed", "damper"))
PEAK, LEAST, MOST = (column("algorithm", name) for name in ("peak_force", "bdf_1e-4_least", "bdf_1e-4_most"))
MIDDLES = [cell("algorithm", case, f"bdf_{step}") for case, step in enumerate(PRINTED)]


IN_BAND = tuple(
    ((LEAST[case] <= force) & (force <= MOST[case])).map(lambda inside: "is" if inside else "is not")
    for case, force in enumerate(PRINTED.values())
)
BY_STEPS = "{{:.4g}} N; {{:.3g}} N by steps of {} s, {{:.3g}} to {{:.3g}} N by steps of 1e-4 s"

CLAIMS = (
    Claim(
        "Algorithm 1 gives 250 and 3000 N for c = 1, 450 and 5e4 N for c = 6",
        "2.1, fig. 7-10",
        "c = 1 and 6: {}. It is given the motion, so that its force stops nothing, and its instants pass over a damper "
        "that acts for some 10 µs",
        (
            listed(
                "F₁ {:.3g} of {:.4g} N, F₂ {:.3g} of {:.4g} N",
                *(column("algorithm", name) for name in SEEN),
                joint="; ",
            ),
        ),
        tuple(
            near(cell("algorithm", case, name), force)
            for case, forces in enumerate(((250.0, 3e3), (450.0, 5e4)))
            for name, force in zip(("spring_seen", "damper_seen"), forces, strict=True)
        ),
    ),
    Claim(
        "STEP rises from 0 at the touch to c (with a = c, eq. 24)",
        "2.1, fig. 3, 5",
        "with the printed a = c damping is 2 c at the touch and falls to c at the depth d, a force that jumps; a = -c "
        "is meant. F₂ of the same motion: {:.4g} N against {:.4g} N",
        (AS_PRINTED, MEANT),
        (near(AS_PRINTED, MEANT),),
    ),
    Claim(
        "Steps of 1e-3 s (c = 1) and 1e-4 s (c = 6) show the force",
        "2.2, fig. 12, 17",
        "; ".join(f"c = {c}: {BY_STEPS.format(step)}" for c, step in zip((1, 6), PRINTED, strict=True))
        + ", by where the steps begin. Of the printed forces "
        + " and ".join(f"{force} N {{}}" for force in PRINTED.values())
        + " in the band of 1e-4 s",
        (
            *(it for case in range(2) for it in (PEAK[case], MIDDLES[case], LEAST[case], MOST[case])),
            *IN_BAND,
        ),
        tuple(near(middle, PEAK[case]) for case, middle in enumerate(MIDDLES)),
    ),
)
