"""(l) The docking standard's initial contact conditions, drawn at random: how often they are captured and held, which
condition decides, and a design that holds more of them."""

from collections.abc import Mapping
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from jaxtyping import Bool, Float

from jaxbuffer import Sweep
from jaxbuffer.experiments.points import points
from jaxbuffer.experiments.ranges import ranges
from jaxbuffer.fields import get, with_values
from jaxbuffer.output.formats import csv_text

from .study import Sweeps, config, figure, write

RUNS = 2000
# Whether a run is held has no slope to follow: designs are drawn over the bounds and compared in the same few
# conditions, the best of them in others.
DESIGNS, FIRST_CONDITIONS = 23, 12  # and the design as drawn
FINALISTS, SECOND_CONDITIONS = 4, 32
BINS = 10  # of a condition, with equally many runs
CAPTURED = ("captured", "latched", "held", "torn")
# Components of one vector, of which the standard limits the size.
VECTORS = {
    "lateral misalignment [mm]": ("offset_y", "offset_z", 1e3),
    "pitch and yaw [deg]": ("active_yaw", "active_pitch", 180.0 / np.pi),
    "lateral rate [mm/s]": ("lateral_speed_y", "lateral_speed_z", 1e3),
    "pitch and yaw rate [deg/s]": ("active_rate_y", "active_rate_z", 180.0 / np.pi),
}
QUANTITIES = {"peak_force": ("N", 1.0), "stroke": ("mm", 1e3), "peak_hinge_force": ("N", 1.0)}

Values = dict[str, Float[np.ndarray, " n"]]


def main(folder: Path, resume: bool = False, executor: Executor | None = None) -> None:
    """Run the design as drawn, search a better one, run that in conditions that neither has met."""
    study, sweeps = config("initial_conditions"), Sweeps(folder, resume, executor)
    seed = study.sample.seed
    first = drawn(study, RUNS, seed)
    results = {"Table 2": (first, swept(study, sweeps, first))}
    report(folder, study, "Table 2", *results["Table 2"])
    tuned = searched(study, sweeps, seed)
    for path, value in tuned.items():
        print(f"  {path} = {value:.4g}")
    fresh = drawn(study, RUNS, seed + 100)
    results["tuned"] = fresh, swept(study, sweeps, {**fresh, **{path: np.full(RUNS, it) for path, it in tuned.items()}})
    report(folder, study, "tuned", *results["tuned"])
    draw_figure(folder, study, results)


def drawn(study: Any, count: int, seed: int) -> Values:
    """Return ``count`` conditions, by path, spread evenly over the ranges, in which no vector exceeds its limit."""
    axes = ranges(study.sample.ranges, study.design, study.scenario)
    # Four circles take up (π/4)⁴ = 38 % of their squares; the first of a Sobol' sequence are spread as evenly as all.
    columns = points(axes, 1 << int(4 * count - 1).bit_length(), seed=seed).columns()
    within = np.ones(len(columns["scenario.approach_speed"]), bool)
    for first, second, _ in VECTORS.values():
        pair = [columns[f"scenario.{name}"] for name in (first, second)]
        within &= np.hypot(*(values / np.max(np.abs(values)) for values in pair)) <= 1.0
    return {path: values[within][:count] for path, values in columns.items()}


def swept(study: Any, sweeps: Sweeps, values: Values) -> Sweep:
    """Return one run for each entry of ``values``, by path."""
    design, scenario = with_values(study.design, study.scenario, values)
    return sweeps.found(design, scenario, study.options.duration, study.options.rtol)


def captured(sweep: Sweep) -> Bool[np.ndarray, " n"]:
    """Return which runs crossed the capture plane."""
    return np.array([outcome.name in CAPTURED for outcome in sweep.outcomes])


def held(study: Any, sweep: Sweep) -> Bool[np.ndarray, " n"]:
    """Return which runs ended held with a stroke that fits into the cylinder."""
    return np.array([it.name == "held" for it in sweep.outcomes]) & (
        sweep.stroke <= study.problem().limits.at_most["stroke"]
    )


def searched(study: Any, sweeps: Sweeps, seed: int) -> dict[str, float]:
    """Return the numbers of the design that holds most conditions; of equal ones, that with the least mean force."""
    problem = study.problem()
    bounds = {it.path: (it.low, it.high, "log") for it in problem.variables}
    axes = ranges(bounds, study.design, study.scenario)
    designs = points(axes, DESIGNS, "latin_hypercube", seed).columns()
    designs = {path: np.append(values, float(get(study.design, path))) for path, values in designs.items()}
    for count, conditions, shift in ((FINALISTS, FIRST_CONDITIONS, 1), (1, SECOND_CONDITIONS, 2)):
        designs = best(study, sweeps, designs, drawn(study, conditions, seed + shift), count)
    return {path: float(values[0]) for path, values in designs.items()}


def best(study: Any, sweeps: Sweeps, designs: Values, conditions: Values, count: int) -> Values:
    """Return the ``count`` designs that hold most of the conditions, each of which meets all."""
    many, each = len(next(iter(designs.values()))), len(next(iter(conditions.values())))
    values = {path: np.repeat(it, each) for path, it in designs.items()}
    sweep = swept(study, sweeps, values | {path: np.tile(it, many) for path, it in conditions.items()})
    holds = held(study, sweep).reshape(many, each).sum(axis=1)
    force = np.nanmean(sweep.peak_force.reshape(many, each), axis=1)
    order = np.lexsort((force, -holds))[:count]
    print(f"  {many} designs in {each} conditions each: the best hold {holds[order].tolist()}", flush=True)
    return {path: it[order] for path, it in designs.items()}


def sizes(values: Mapping[str, Any]) -> Values:
    """Return the conditions as the standard names them, in the units of their names, and the lateral rate's part that
    leads away from the axis."""
    of = {path.removeprefix("scenario."): it for path, it in values.items()}
    named = {"closing rate [mm/s]": 1e3 * of["approach_speed"]}
    for name, (first, second, factor) in VECTORS.items():
        named[name] = factor * np.hypot(of[first], of[second])
    named["roll rate [deg/s]"] = np.degrees(np.abs(of["active_rate_x"]))
    outwards = of["offset_y"] * of["lateral_speed_y"] + of["offset_z"] * of["lateral_speed_z"]
    named["lateral rate outwards [mm/s]"] = 1e3 * outwards / np.hypot(of["offset_y"], of["offset_z"])
    return named


def binned(condition: Float[np.ndarray, " n"], y: Float[np.ndarray, " n"]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return mean condition, mean of ``y`` and its count in bins with equally many runs."""
    parts = np.array_split(np.argsort(condition), BINS)
    return tuple(
        np.array([f(part) for part in parts]) for f in (lambda p: condition[p].mean(), lambda p: y[p].mean(), len)
    )


def share(condition: Float[np.ndarray, " n"], y: Float[np.ndarray, " n"]) -> float:
    """Return the share of the variance of ``y`` that a condition causes alone, its first-order Sobol' index, as the
    correlation ratio of the bins less what bins of noise would have; NaN of what is the same in all runs."""
    if y.var() == 0.0:
        return np.nan
    _, means, counts = binned(condition, y)
    ratio = np.average((means - y.mean()) ** 2, weights=counts) / y.var()
    chance = (BINS - 1) / (len(y) - 1)
    return float((ratio - chance) / (1.0 - chance))


def interval(successes: int, count: int) -> str:
    """Return a probability with its 95 % interval (Wilson)."""
    low, high = scipy.stats.binomtest(successes, count).proportion_ci(method="wilson")
    return f"{100 * successes / count:.1f} % ({100 * low:.1f} to {100 * high:.1f} %)"


def report(folder: Path, study: Any, name: str, values: Values, sweep: Sweep) -> None:
    """Write and print how often a design captures and holds, what is worst and where, and which condition decides."""
    good, count = held(study, sweep), len(sweep)
    conditions = sizes(values)
    names, codes = np.unique([outcome.name for outcome in sweep.outcomes], return_counts=True)
    lines = [f"{name}: {count} runs", f"  captured {interval(int(captured(sweep).sum()), count)}"]
    lines += [f"  held     {interval(int(good.sum()), count)}"]
    lines += [f"  outcomes {', '.join(f'{of} {n}' for of, n in zip(names, codes, strict=True))}"]
    for quantity, (unit, factor) in QUANTITIES.items():
        worst = int(np.nanargmax(sweep.columns[quantity]))
        at = ", ".join(f"{condition} {numbers[worst]:.3g}" for condition, numbers in conditions.items())
        lines += [f"  worst {quantity} {factor * sweep.columns[quantity][worst]:.4g} {unit} at {at}"]
    known = np.all([np.isfinite(sweep.columns[quantity]) for quantity in QUANTITIES], axis=0)
    rows = []
    for condition, numbers in conditions.items():
        of = [share(numbers, good.astype(float))]
        of += [share(numbers[known], sweep.columns[quantity][known]) for quantity in QUANTITIES]
        rows.append([condition, *of])
        lines += [f"  {condition:30} " + "  ".join(f"{of_one:6.3f}" for of_one in of)]
    lines.insert(-len(rows), f"  share of the variance of        held    {'  '.join(QUANTITIES)}")
    print("\n".join(lines), flush=True)
    place = name.replace(" ", "").lower()
    write(folder, f"{place}.txt", "\n".join(lines) + "\n")
    write(folder, f"{place}-shares.csv", csv_text(["condition", "held [-]", *(f"{it} [-]" for it in QUANTITIES)], rows))
    header = [*conditions, "outcome", *(f"{it} [{unit}]" for it, (unit, _) in QUANTITIES.items())]
    runs = zip(*conditions.values(), (outcome.name for outcome in sweep.outcomes),
               *(factor * sweep.columns[it] for it, (_, factor) in QUANTITIES.items()), strict=True)  # fmt: skip
    write(folder, f"{place}-runs.csv", csv_text(header, [[*map(_plain, row)] for row in runs]))


def _plain(value: Any) -> Any:
    return value if isinstance(value, str) else float(value)


def draw_figure(folder: Path, study: Any, results: Mapping[str, tuple[Values, Sweep]]) -> None:
    """Draw the share of held runs over each condition that decides, and all conditions' shares of the variance."""
    shown = ("lateral rate outwards [mm/s]", "closing rate [mm/s]")

    def draw(axes: Any) -> None:
        for axis, condition in zip(axes, shown, strict=False):
            for name, (values, sweep) in results.items():
                at, means, counts = binned(sizes(values)[condition], held(study, sweep).astype(float))
                error = 1.96 * np.sqrt(means * (1.0 - means) / counts)
                axis.errorbar(at, 100 * means, 100 * error, fmt="o-", capsize=2, label=name)
            axis.set(xlabel=condition, ylabel="held [%]", ylim=(0, 105))
        axes[1].legend()
        for k, (name, (values, sweep)) in enumerate(results.items()):
            conditions, good = sizes(values), held(study, sweep).astype(float)
            places = np.arange(len(conditions)) + 0.4 * k
            axes[2].barh(places, [100 * share(it, good) for it in conditions.values()], 0.4, label=name)
        axes[2].set_yticks(np.arange(len(conditions)) + 0.2, [it.split(" [")[0] for it in conditions])
        axes[2].invert_yaxis()
        axes[2].set(xlabel="share of the variance of held [%]")

    figure(folder, "initial_conditions.png", draw, columns=3)
