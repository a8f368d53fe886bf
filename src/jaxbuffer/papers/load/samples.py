"""Random designs and postures of three mechanisms, their impacts, and how well the effective energy orders these."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float
from scipy.stats import spearmanr

from ...fields import with_values
from ...mechanisms.bar_drop import BarDrop, BarDropScenario
from ...mechanisms.probe_cone import Scenario, table2
from ...mechanisms.slider_crank import SliderCrank, SliderCrankScenario
from ...run.simulate import simulate
from ..claims import Row
from ..study import Study, StudyCase

LONGEST = 2e-3  # s, by which an impact is past its peak
RUNS, SEED = 200, 38  # of each case, with the same designs and postures
Range = tuple[float, float]
Ranges = Mapping[str, Range]


class SampledImpacts(NamedTuple):
    """All impacts of a case's runs but those that the run's end cuts off: ``energy`` T_c⁻ [J], ``peak`` [N], approach
    ``speed`` [m/s], whether each is the ``first`` of its run; ``cut``: how many others there are; ``failed``: runs that
    did."""

    energy: Float[np.ndarray, " impacts"]
    peak: Float[np.ndarray, " impacts"]
    speed: Float[np.ndarray, " impacts"]
    first: Float[np.ndarray, " impacts"]
    cut: int
    failed: int


# Ranges from which each number is drawn: evenly in its logarithm, angles evenly. What they leave out is the default.
CONE = {
    "active.mass": (5.0, 100.0),
    "active.inertia": (0.1, 2.0),
    "passive.mass": (5.0, 500.0),
    "passive.inertia": (0.1, 10.0),
    "buffer.cylinder_mass": (0.2, 3.0),
    "probe.rod_mass": (0.05, 0.5),
    "probe.tip_mass": (0.02, 0.3),
    "cone.half_angle": (0.6, 0.95),
    "scenario.approach_speed": (0.02, 0.4),
    "scenario.misalignment": (-0.05, 0.05),
}
BAR = {
    "bar.length": (0.1, 0.5),
    "bar.diameter": (0.003, 0.012),
    "bar.density": (2000.0, 9000.0),
    "scenario.height": (0.005, 0.09),
}
CRANK = {
    "crank.length": (0.03, 0.08),
    "rod.length": (0.12, 0.25),
    "rod.mass": (0.05, 0.5),
    "rod.inertia": (1e-4, 2e-3),
    "slider.mass": (0.05, 0.5),
    "scenario.crank_speed": (100.0, 600.0),
    "scenario.crank_angle": (-3.1, 3.1),
}
CONTACTS = ("no friction, no loss", "friction and loss", "friction and loss at random")
FRICTIONS: tuple[Range, ...] = ((0.0, 0.0), (0.3, 0.3), (0.01, 0.5))  # a range without width is a number
RESTITUTION = ("restitution", ((1.0, 1.0), (0.7, 0.7), (0.3, 1.0)))
DAMPER = ("damping", ((0.0, 0.0), (1000.0, 1000.0), (10.0, 6000.0)))  # N s/m


def _study(name: str, title: str, law: str, of: tuple[Any, Any], ranges: Ranges, duration: float, part: str) -> Study:
    """Make a case for each of `CONTACTS`, whose numbers are drawn as well, after all others."""
    lost, losses = DAMPER if part == "impact" else RESTITUTION
    cases = (
        StudyCase(
            label, k, *of, {"duration": duration, "ranges": {**ranges, f"{part}.friction": mu, f"{part}.{lost}": loss}}
        )
        for k, (label, mu, loss) in enumerate(zip(CONTACTS, FRICTIONS, losses, strict=True))
    )
    return Study(name, "none at hand", title, "contact", f"{RUNS} designs and postures at random; {law}", tuple(cases))


LAW, IMPACT = "the default's stiffness in all", "the impact paper's spring of the power 2.2 and damper in all"
CRANKS = "Slider-crank with play in its piston pin"
STUDIES = (
    _study("cone", "Probe in a cone", LAW, (table2(), Scenario()), CONE, 0.02, "contact"),
    _study("bar", "Bar dropped on a plate", IMPACT, (BarDrop(), BarDropScenario()), BAR, 0.3, "impact"),
    _study("crank", CRANKS, LAW, (SliderCrank(), SliderCrankScenario()), CRANK, 4e-3, "piston_pin"),
)
NUMBERS = ("runs", "impacts", "cut_off", "rank_first", "rank_all", "rank_speed", "exponent", "scatter")
COLUMNS = {"outcome": "", **dict.fromkeys(NUMBERS, "-"), "mean_energy": "J"}
SHOWN = tuple(COLUMNS)[1:]


def draw(ranges: Ranges) -> list[dict[str, float]]:
    """Draw the numbers of each run, by address: the same ones whenever the ranges are the same."""
    runs = np.random.default_rng(SEED).uniform(size=(len(ranges), RUNS))  # a row each: later ones change no earlier one
    drawn = {}
    for (name, (low, high)), share in zip(ranges.items(), runs, strict=True):
        # A range that reaches zero has no logarithm.
        even = low <= 0.0 or low == high
        drawn[name] = low + share * (high - low) if even else low * (high / low) ** share
    return [{name: float(values[k]) for name, values in drawn.items()} for k in range(RUNS)]


def solve(case: StudyCase) -> SampledImpacts:
    """Run a case, and return the impacts of its runs."""
    rows, cut, failed = [], 0, 0
    for numbers in draw(case.options["ranges"]):
        run = simulate(*with_values(case.design, case.scenario, numbers), case.options["duration"])
        if run.outcome.failed:
            # Numbers of a failed run are NaN, which have no rank.
            failed += 1
            continue
        count, hits = int(run.impacts.count), run.impacts
        begin, release, peak, speed = (
            np.asarray(x)[:count] for x in (hits.time, hits.release_time, hits.peak_force, hits.approach_speed)
        )
        # Without a release, an impact counts if it has lasted so long that its peak is past.
        whole = np.isfinite(release) | (float(run.end_time) - begin > LONGEST)
        energy = run.loads("effective_energy")
        rows.append(np.array([energy, peak, speed, np.arange(count) == 0])[:, whole])
        cut += int(np.sum(~whole))
    energy, peak, speed, first = np.concatenate(rows, axis=1)
    return SampledImpacts(energy, peak, speed, first, cut, failed)


def row(case: StudyCase, impacts: SampledImpacts) -> Row:
    """Return how well the effective energy orders the peaks: rank correlations, of first impacts and of all; the
    approach speed's for comparison; a power law F ∝ T_c^a through the first ones, and the rms of ln F about it."""
    first, pressed = impacts.first > 0.0, impacts.peak > 0.0
    # A power law is a straight line in logarithms.
    energy, peak = np.log(impacts.energy[first]), np.log(impacts.peak[first])
    exponent, intercept = np.polyfit(energy, peak, 1)
    return {
        "outcome": "finished" if not impacts.failed else f"failed: {impacts.failed} runs",
        "runs": int(np.sum(first)),
        "impacts": len(impacts.peak),
        "cut_off": impacts.cut,
        "rank_first": float(spearmanr(energy, peak).statistic),
        "rank_all": float(spearmanr(impacts.energy[pressed], impacts.peak[pressed]).statistic),
        "rank_speed": float(spearmanr(impacts.speed[first], peak).statistic),
        "exponent": float(exponent),
        "scatter": float(np.std(peak - exponent * energy - intercept)),
        "mean_energy": float(np.exp(np.mean(energy))),
    }
