"""The slider-crank with play in its piston pin, its rod rigid or bending: the first impacts' peaks at equal accuracy
beside SciPy's DOP853 and Exudyn, and what a turn, an impact and a gradient cost at default settings."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from . import ours
from .accuracy import Setting, best_of, cheapest, measured, race
from .figures import Figure, Part, Ratio, milliseconds, precision_plot
from .plan import ROOT, Plan, of_tests

import jaxbuffer as jb  # isort: skip # after `ours`, which configures JAX

TARGET, COARSE, SLOPES = 1e-4, 1e-2, 1e-3  # [-] relative error: of peaks, of Exudyn's peaks, of elasticities
IMPACTS, WINDOW, TURN = 4, 1.5e-3, 0.012  # impacts that are compared, until when they are over [s], and a turn [s]
SHORT = 1e-3  # [s] the first three impacts, whose elasticities are compared
RTOLS = ours.RTOLS[:9]  # looser ones change the order of impacts
LONGEST = (2e-5, 1e-4)  # [s] longest step of the compiled peer
EXUDYN = (1e-7, 2e-7, 5e-7, 1e-6)  # [s] its steps
RODS = {"rigid rod": 0, "rod with 2 modes": 2, "rod with 4 modes": 4, "rod with 8 modes": 8}
DEPTH = 0.015  # [m] of a rod that bends
SAME = 1e-6  # [-] to which the integrators must agree on the exact peaks
FILE = ROOT / "tests" / "mechanisms" / "slider_crank_reference.json"
PARAMETERS = {
    "piston_pin.clearance": "clearance",
    "slider.mass": "slider_mass",
    "piston_pin.restitution": "restitution",
}
STEPS = (1e-2, 3e-3, 1e-3, 3e-4)  # [-] of the peers' central differences
NAMED = ("first_peak", "second_peak", "third_peak")


def crank(modes: int) -> jb.SliderCrank:
    """The default design, its rod bending in so many modes."""
    return jb.replace(jb.SliderCrank(), {"rod.depth": DEPTH, "rod.modes": modes}) if modes else jb.SliderCrank()


def own_peaks(design: jb.SliderCrank, rtol: float, duration: float = WINDOW) -> np.ndarray:
    """The product's first peaks [N]."""
    return np.asarray(jb.simulate(design, duration=duration, rtol=rtol).impacts.peak_force)[:IMPACTS]


def peak_errors(peaks: np.ndarray, exact: np.ndarray) -> dict[str, float]:
    """The largest relative error [-] of the first peaks."""
    if len(peaks) < len(exact):
        return {"peaks": float("inf")}
    return {"peaks": float(np.max(np.abs(peaks[: len(exact)] / exact - 1.0)))}


def own_curve(design: jb.SliderCrank, exact: np.ndarray, repeats: int) -> list[Setting]:
    """The product, tight to loose; what compiles is not timed."""
    own_peaks(design, RTOLS[-1])
    return [
        measured(
            ours.NAME, f"rtol {rtol:.0e}", partial(own_peaks, design, rtol), partial(peak_errors, exact=exact), repeats
        )
        for rtol in RTOLS
    ]


def by_hand(rtol: float, longest: float, duration: float = WINDOW, **changes: float) -> np.ndarray:
    """Peaks [N] of the default design by equations written out by hand and DOP853, compiled by Numba."""
    from .peers.slider_crank import SliderCrank
    from .peers.slider_crank.run import simulate

    run = simulate(SliderCrank()._replace(**changes), duration, rtol, longest=longest)
    return run.log[:, 4]


def by_plain_scipy(rtol: float) -> np.ndarray:
    """Peaks [N] by SciPy's solve_ivp with equations in plain Python."""
    from .peers.slider_crank import SliderCrank, plain

    return np.array([impact.peak_force for impact in plain.simulate(SliderCrank(), WINDOW, rtol)])


def by_exudyn(step: float) -> np.ndarray:
    """Peaks [N] by Exudyn at a fixed step."""
    simulate = of_tests("verification.second_opinion.slider_crank").simulate
    numbers = json.loads(FILE.read_text())["designs"][0]["numbers"]
    return simulate(numbers, step, WINDOW).peak_force


def rigid_peers(exact: np.ndarray, plan: Plan) -> Iterator[list[Setting]]:
    """Curves of the equations by hand: in a compiled loop, and by solve_ivp in plain Python."""
    errors = partial(peak_errors, exact=exact)
    for longest in LONGEST:
        by_hand(RTOLS[-1], longest)  # compiles
        name = "DOP853, loop and equations compiled"
        yield [
            measured(
                name, f"rtol {rtol:.0e}, steps ≤ {longest:g} s", partial(by_hand, rtol, longest), errors, plan.repeats
            )
            for rtol in RTOLS
        ]
    if not plan.quick:
        yield [
            measured("SciPy DOP853, plain Python", f"rtol {rtol:.0e}", partial(by_plain_scipy, rtol), errors)
            for rtol in RTOLS[::2]
        ]


def bending_peers(design: jb.SliderCrank, exact: np.ndarray) -> Iterator[list[Setting]]:
    """The curve of SciPy's DOP853 with the product's equations, compiled."""
    from .bending_crank import equations, peaks

    of = equations(design, jb.SliderCrankScenario())
    peaks(of, 3e-4, 1e-5)  # compiles
    errors = partial(peak_errors, exact=exact)
    yield [
        measured("SciPy DOP853, our equations", f"rtol {rtol:.0e}", partial(peaks, of, WINDOW, rtol), errors)
        for rtol in RTOLS[::2]
    ]


def exact_peaks(design: jb.SliderCrank, modes: int) -> tuple[np.ndarray, str]:
    """The first peaks [N], and how far two integrators differ on them."""
    own = own_peaks(design, 1e-10)
    if not modes:
        exact = np.array(json.loads(FILE.read_text())["growth"]["peaks"][:IMPACTS])
        return exact, f"exact peaks from {FILE.name}, {peak_errors(own, exact)['peaks']:.0e} off ours at rtol 1e-10"
    from .bending_crank import equations, peaks

    other = peaks(equations(design, jb.SliderCrankScenario()), WINDOW, 1e-11)
    apart = peak_errors(other, own)["peaks"]
    if apart > SAME:
        raise RuntimeError(f"{modes} modes: two integrators differ by {apart:.0e} on the exact peaks")
    return own, f"ours at rtol 1e-10 and DOP853 at 1e-11 differ by {apart:.0e}; the equations are the same"


def one_rod(plan: Plan, name: str) -> Part:
    """The first impacts with one rod, against its peers."""
    modes, key = RODS[name], name.replace(" ", "-")
    design = crank(modes)
    exact, how = exact_peaks(design, modes)
    mine = own_curve(design, exact, plan.repeats)
    theirs = list(bending_peers(design, exact)) if modes else list(rigid_peers(exact, plan))
    by_name: dict[str, list[list[Setting]]] = {}
    for curve in theirs:
        by_name.setdefault(curve[0].solver, []).append(curve)
    chosen = [cheapest([mine], TARGET), *(cheapest(curves, TARGET) for curves in by_name.values())]
    ratios, notes = [], [f"{name}: {how}"]
    if all(chosen):
        own, *others = race(chosen, plan.repeats)
        for other in others:
            pair = milliseconds(own), milliseconds(other)
            ratios.append(Ratio(f"slider_crank/{key}/{other.solver}", f"{name}, against {other.solver}", *pair))
    else:
        notes.append(f"{name}: somebody is nowhere within {TARGET:g}")
    if not modes and not plan.quick:
        ratios += exudyn_ratio(mine, exact, notes)
    plot = precision_plot(f"slider-crank-{key}", f"First {IMPACTS} peaks, {name}", [mine, *theirs], "peaks", TARGET)
    return Part("slider_crank", name, tuple(ratios), plots=(plot,), notes=tuple(notes))


def exudyn_ratio(mine: list[Setting], exact: np.ndarray, notes: list[str]) -> list[Ratio]:
    """Against Exudyn, at the accuracy that its steps reach."""
    errors = partial(peak_errors, exact=exact)
    try:
        theirs = [measured("Exudyn", f"step {step:g} s", partial(by_exudyn, step), errors) for step in EXUDYN]
    except ImportError:
        notes.append("Exudyn is not installed: pip install 'jaxbuffer[verify]'")
        return []
    notes += [f"Exudyn, {one.tolerances}: {one.seconds:.3g} s, peaks {one.error:.1e} off" for one in theirs]
    own, other = cheapest([mine], COARSE), cheapest([theirs], COARSE)
    if own is None or other is None:
        return []
    pair = milliseconds(own), milliseconds(other)
    return [Ratio("slider_crank/rigid-rod/Exudyn", f"rigid rod, against Exudyn, within {COARSE:g}", *pair)]


def own_slopes(design: jb.SliderCrank, rtol: float) -> np.ndarray:
    """Elasticities of the first three peaks by three parameters, with the run they belong to, shape (3, 3)."""
    from jaxbuffer.mechanisms.slider_crank import SLIDER_CRANK
    from jaxbuffer.sensitivities.gradients import gradients

    values = np.array([float(jb.get(design, path)) for path in PARAMETERS])
    result = gradients(SLIDER_CRANK, design, jb.SliderCrankScenario(), tuple(PARAMETERS), values, SHORT, rtol=rtol)
    return np.asarray(result.by_impact["peak_force"])[:3] * values / np.asarray(result.run.impacts.peak_force)[:3, None]


def differences(peaks: Callable[..., np.ndarray], step: float) -> np.ndarray:
    """The same of ``peaks(path=value factor)`` by central differences in ln p, beside one run for the values."""
    peaks()
    columns = []
    for path in PARAMETERS:
        high, low = (np.log(peaks(**{path: np.exp(move)})[:3]) for move in (step, -step))
        columns.append((high - low) / (2.0 * step))
    return np.stack(columns, axis=1)


def hand_slopes(rtol: float, step: float) -> np.ndarray:
    """By differences of the equations by hand, compiled."""
    from .peers.slider_crank import SliderCrank

    def peaks(**factors: float) -> np.ndarray:
        moved = {PARAMETERS[p]: getattr(SliderCrank(), PARAMETERS[p]) * factor for p, factor in factors.items()}
        return by_hand(rtol, LONGEST[0], SHORT, **moved)

    return differences(peaks, step)


def slope_errors(slopes: np.ndarray, exact: np.ndarray) -> dict[str, float]:
    """Of the nine elasticities the largest relative error [-]."""
    return {"elasticities": float(np.max(np.abs(slopes / exact - 1.0)))}


def gradient(plan: Plan) -> Part:
    """Value and derivatives of the rigid rod's first peaks against differences."""
    known = json.loads(FILE.read_text())["elasticities"]
    exact = np.array([[known[name][peak]["value"] for name in PARAMETERS.values()] for peak in NAMED])
    errors, design = partial(slope_errors, exact=exact), crank(0)
    own_slopes(design, RTOLS[-1])  # compiles
    mine = [
        measured(f"{ours.NAME}, derivative", f"rtol {rtol:.0e}", partial(own_slopes, design, rtol), errors, 2)
        for rtol in RTOLS
    ]
    name = "DOP853, compiled, central differences"
    theirs = [
        [measured(name, f"rtol {rtol:.0e}, steps {h:g}", partial(hand_slopes, rtol, h), errors, 2) for rtol in RTOLS]
        for h in STEPS
    ]
    pair = [cheapest([mine], SLOPES), cheapest(theirs, SLOPES)]
    if not all(pair):
        return Part("slider_crank", "gradient", notes=(f"gradient: somebody is nowhere within {SLOPES:g}",))
    own, other = (milliseconds(setting) for setting in race(pair, plan.repeats))
    what = "rigid rod, nine elasticities of three peaks, against differences"
    return Part("slider_crank", "gradient", (Ratio("slider_crank/gradient", what, own, other),))


def costs(plan: Plan, name: str) -> tuple[Figure, ...]:
    """At default settings: a turn, an impact of it, the first three impacts, and these with derivatives."""
    design, rtol = crank(RODS[name]), 1e-6

    def turn() -> int:
        run = jb.simulate(design, duration=TURN, rtol=rtol)
        return int(run.impact_count)

    turn()  # compiles
    impacts, seconds = best_of(plan.repeats, turn)
    alone = best_of(plan.repeats, partial(own_peaks, design, rtol, SHORT))[1]
    own_slopes(design, rtol)  # compiles
    slopes = best_of(plan.repeats, partial(own_slopes, design, rtol))[1]
    return (
        Figure(f"{name}: a turn", 1e3 * seconds, "ms", setting=f"{impacts} impacts"),
        Figure(f"{name}: an impact of it", 1e3 * seconds / impacts, "ms"),
        Figure(f"{name}: the first {SHORT:g} s", 1e3 * alone, "ms"),
        Figure(f"{name}: the same with derivatives by three parameters", 1e3 * slopes, "ms"),
    )


def plate_costs(plan: Plan) -> tuple[Figure, ...]:
    """The default drop of a bar on a plate of several modes."""
    costs = []
    for modes in (0, 2, 4, 8):
        run = partial(dropped, jb.replace(jb.BarDrop(), {"plate.modes": modes}))
        impacts = run()  # compiles
        seconds = best_of(plan.repeats, run)[1]
        name = f"a plate of {modes} modes" if modes else "a rigid plate"
        costs.append(Figure(f"bar dropped on {name}", 1e3 * seconds, "ms", setting=f"{impacts} impacts"))
    return tuple(costs)


def dropped(design: jb.BarDrop) -> int:
    """Impacts of one drop."""
    return int(jb.simulate(design).impact_count)


def measure(plan: Plan) -> Part:
    """All rods; a quick run has the rigid one alone."""
    names = list(RODS)[:1] if plan.quick else list(RODS)
    parts = [one_rod(plan, name) for name in plan.track(names, "slider-crank, first impacts")]
    parts.append(gradient(plan))
    figures = [figure for name in plan.track(names, "slider-crank, turns") for figure in costs(plan, name)]
    if not plan.quick:
        figures += plate_costs(plan)
    return Part(
        "slider_crank",
        f"Slider-crank with play: the first {IMPACTS} peaks within {TARGET:g}; costs at default settings",
        tuple(ratio for part in parts for ratio in part.ratios),
        plots=tuple(plot for part in parts for plot in part.plots),
        notes=tuple(note for part in parts for note in part.notes),
        figures=tuple(figures),
    )
