"""Bar and plate as plane finite elements, with and without friction, beside modes and rigid bodies (fig. 21 to 29)."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..._types import Figure
from ...contact.laws import contact_modulus
from ...fields import replace
from ...mechanisms.bar_drop import BarDrop
from ...mechanisms.bar_drop.run import BarDropRun
from ...output.style import drawing, label, line, panels
from ..claims import NONE, Claim, Row, Value, column, near
from ..study import Studied, Study, StudyCase, simulated
from .bar_studies import ACCURATE, BENT, BODIES, DROP
from .elements import DURATION, MeshedDrop, MeshedRun, follow

STIFFNESS = 4e6  # N/m: the printed spring's force over its depth where the rigid bar is stopped
EARLY = 1e-4  # s from the touch: the first peak
YIELDS = 3.2e9  # Pa: the largest pressure at which a hard steel, of 2 GPa yield stress, begins to yield below a ball
ROUGH = 10.0  # μ of a body in modes, whose friction is regularised; elements stick
TOUCH = "time from the touch [ms]"
COLUMNS = {
    "first_peak": "N",
    "peak_force": "N",
    "friction_force": "N",
    "impact_lasts": "s",
    "plate_deflection": "m",
    "plate_stress": "Pa",
    "contact_pressure": "Pa",
    "slid": "m",
    "rises_to": "m",
    "energy_error": "-",
}
SHOWN = tuple(COLUMNS)


def _drop(friction: float, changes: Mapping[str, int] = {}) -> BarDrop:
    # Elements touch by a linear spring without loss; modes and rigid bodies get the same, to be compared with them.
    spring = {"impact.exponent": 1.0, "impact.stiffness": STIFFNESS, "impact.damping": 0.0}
    lossless = {"bar.damping_ratio": 0.0, "plate.damping_ratio": 0.0}
    return replace(BarDrop(), {**spring, **lossless, **changes, "impact.friction": friction})


UNTIL = {"duration": 0.2114438851 + DURATION}  # s, from the release on
STUDIES = (
    Study(
        "elements",
        "21-29",
        "Bar and plate as plane finite elements",
        "coefficient of friction [-]",
        "plane stress, the bar as a rectangle of the round bar's area and second moment, the plate on simple supports "
        "in the middle of its ends; the bar's end alone touches, by 4e6 N/m; no damping anywhere; 6 ms from the touch",
        (
            StudyCase("elements, μ = 0", 0.0, MeshedDrop(_drop(0.0)), DROP),
            StudyCase("elements, μ = 0.3", 0.3, MeshedDrop(_drop(0.3)), DROP),
            StudyCase("elements, rough", 1e6, MeshedDrop(_drop(1e6)), DROP),
            StudyCase("finer elements, μ = 0", 0.0, MeshedDrop(_drop(0.0), 90), DROP),
            StudyCase("8 modes, μ = 0", 0.0, _drop(0.0, BODIES), DROP, {**BENT, **UNTIL}),
            StudyCase("8 modes, rough", ROUGH, _drop(ROUGH, BODIES), DROP, {**BENT, **UNTIL}),
            StudyCase("rigid, μ = 0", 0.0, _drop(0.0), DROP, {**ACCURATE, **UNTIL}),
        ),
    ),
)


def solve(case: StudyCase) -> Any:
    """Run a case, of elements or of the mechanism."""
    return follow(case.design, case.scenario) if isinstance(case.design, MeshedDrop) else simulated(case)


def row(case: StudyCase, run: Any) -> Row:
    """Return the numbers of one run, of elements or of the mechanism."""
    curves = _curves(run)
    time, normal = curves["time"], curves["normal"]
    meshed, touching = isinstance(run, MeshedRun), normal > 0.0
    return {
        "outcome": "finished" if meshed else run.outcome.name,
        "first_peak": float(normal[time <= EARLY].max()),
        "peak_force": float(normal.max()),
        "friction_force": float(np.abs(curves["friction"]).max()),
        "impact_lasts": float(time[touching][-1]),
        "plate_deflection": float(np.max(curves["deflection"])),
        "plate_stress": float(run.stress.max()) if meshed else NONE,
        "contact_pressure": pressure(run.design.drop if meshed else run.design, float(normal.max())),
        # What the end moves along the plate in flight is no sliding.
        "slid": float(np.sum(np.abs(np.diff(curves["slid"]))[touching[1:]])),
        "rises_to": run.rise if meshed else _rise(run),
        "energy_error": run.energy_error if meshed else float(run.balance.energy),
    }


def pressure(drop: BarDrop, force: float) -> float:
    """Return Hertz's largest pressure of the ball on the plate under a force [N], in [Pa]: (6 F E*²/π³R²)^(1/3)."""
    impact = drop.impact
    modulus = float(contact_modulus(*(impact.young_modulus, impact.poisson_ratio) * 2))
    return float((6.0 * force * modulus**2 / (math.pi**3 * float(drop.bar.ball_radius) ** 2)) ** (1.0 / 3.0))


def _curves(run: Any) -> dict[str, Any]:
    """Time from the touch [s], height of the end and deflection of the plate [m], forces [N], way along it [m]."""
    if isinstance(run, MeshedRun):
        return {name: getattr(run, name) for name in ("time", "height", "deflection", "normal", "friction", "slid")}
    history = run.history
    time, still = np.asarray(history.time) - float(run.impacts.time[0]), np.zeros(len(history.time))
    slip = np.asarray(history.slip)[:, 0]
    # A history has the slip's speed: the way is its integral.
    way = np.concatenate([[0.0], np.cumsum(0.5 * (slip[1:] + slip[:-1]) * np.diff(time))])
    curves = {
        "time": time,
        "height": np.asarray(history.gap)[:, 0],
        "deflection": np.asarray(history.plate_deflection) if run.design.plate.modes else still,
        "normal": np.asarray(history.contact_force)[:, 0],
        "friction": np.asarray(history.friction_force)[:, 0],
        "slid": way,
    }
    return {name: values[time >= 0.0] for name, values in curves.items()}


def _rise(run: BarDropRun) -> float:
    """Return how high the mean rotation of the bar at the end would carry its end [m], as `MeshedRun.rise`."""
    history, bar = run.history, run.design.bar
    assert history is not None
    (x, y, _), (along, up, spin) = (np.asarray(part)[-1, 0] for part in (history.position, history.velocity))
    length = float(bar.length)
    # The angular momentum about the hinge over the bar's moment of inertia about it.
    turning = 3.0 / length**2 * (x * up - y * along + length**2 / 12.0 * spin)
    return float(length * y / x + np.sign(turning) * (length * turning) ** 2 / (3.0 * float(DROP.gravity)))


def figure(studied: Studied) -> Figure:
    """Draw motion, forces, deflection and stress of all cases."""
    with drawing():
        drawn, grid = panels(10.0, 10.5, 3, 2)
        for number, (case, run) in enumerate(zip(studied.study.cases, studied.captures, strict=True)):
            curves, style = _curves(run), {**line(number), "label": case.label, "linewidth": 0.9}
            time, early = 1e3 * curves["time"], curves["time"] < 3.0 * EARLY
            grid[0, 0].plot(time, 1e3 * curves["height"], **style)
            grid[0, 1].plot(time, curves["normal"], **style)
            grid[1, 0].plot(time[early], curves["normal"][early], **style)
            grid[1, 1].plot(time, np.abs(curves["friction"]), **style)
            grid[2, 0].plot(time, 1e6 * curves["deflection"], **style)
            if isinstance(run, MeshedRun):
                grid[2, 1].plot(time, 1e-6 * run.stress, **style)
        for axes, title, up in (
            (grid[0, 0], "Height of the bar's end above the plate", "height [mm]"),
            (grid[0, 1], "Contact force", "contact force [N]"),
            (grid[1, 0], "Contact force, first peak", "contact force [N]"),
            (grid[1, 1], "Friction force", "friction force [N]"),
            (grid[2, 0], "Deflection of the plate", "deflection [µm]"),
            (grid[2, 1], "Largest von Mises stress in the plate's elements", "stress [MPa]"),
        ):
            label(axes, title, TOUCH, up, legend=axes is grid[0, 0])
        drawn.suptitle(f"{studied.study.title} (the paper's fig. {studied.study.figures})")
        return drawn


FREE, COULOMB, STUCK, FINER, MODAL, MODAL_ROUGH, RIGID = range(7)


def _of(name: str, *cases: int) -> Value:
    return column("elements", name, cases)


PEAK, FIRST_PEAK = _of("peak_force", FREE, COULOMB, STUCK), _of("first_peak", FREE, MODAL, RIGID)
RATIO, LASTS = PEAK[2] / PEAK[0], 1e3 * _of("impact_lasts", FREE, MODAL, RIGID)
RISES = 1e3 * _of("rises_to", FREE, COULOMB, STUCK)
PRESSURE = 1e-9 * _of("contact_pressure", FREE, STUCK)  # GPa

CLAIMS = (
    Claim(
        "433 N without friction, 915 N rough (by our own elements)",
        "2.3, fig. 22-27",
        "elements, μ = 0, 0.3, rough: {:.3g} N (finer mesh, μ = 0: {:.3g} N); rough over frictionless {:.3g}, printed "
        "2.11",
        (PEAK, _of("peak_force", FINER), RATIO),
        (near(PEAK[0], 433.0), near(PEAK[2], 915.0), near(RATIO, 915.0 / 433.0)),
    ),
    Claim(
        "Force has the same course by analysis, modes and elements",
        "4",
        "first peak {:.3g} N by elements, 8 modes, rigid; rough {:.3g} N by elements, modes",
        (FIRST_PEAK, _of("first_peak", STUCK, MODAL_ROUGH)),
        (near(FIRST_PEAK[1], FIRST_PEAK[0]), near(FIRST_PEAK[2], FIRST_PEAK[0])),
    ),
    Claim(
        "The impact lasts 2 ms (by our own elements)",
        "2.3, fig. 23",
        "{:.3g} ms by elements, 8 modes, rigid",
        (LASTS,),
        (near(LASTS[0], 2.0),),
    ),
    Claim(
        "On the rough plate the bar rises higher, to 230 mm (by our own elements)",
        "2.3, fig. 25",
        "elements, μ = 0, 0.3, rough: {:.3g} mm; modes, μ = 0, rough: {:.3g} mm",
        (RISES, 1e3 * _of("rises_to", MODAL, MODAL_ROUGH)),
        (RISES[2] > RISES[0], near(RISES[2], 230.16)),
    ),
    Claim(
        "Plate and contact are elastic (read: no yielding is mentioned)",
        "2.3",
        f"Hertz's pressure under the ball {{:.3g}} GPa, where hard steel yields from {1e-9 * YIELDS:g} GPa on; von "
        "Mises in the plate's elements {:.3g} MPa: μ = 0, rough",
        (PRESSURE, 1e-6 * _of("plate_stress", FREE, STUCK)),
        (PRESSURE.map(max) < 1e-9 * YIELDS,),
    ),
)
