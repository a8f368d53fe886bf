"""What tests of the slider-crank compare with: ``python -m benchmarks peers.slider_crank.reference``.

Run in the repository's root; ``--file`` is tests/mechanisms/slider_crank_reference.json unless told otherwise.

Each number is the median of runs at several tolerances and longest steps; its ``error`` is the largest deviation of any
of them. Where rounding sets the limit (digits are lost at every impact) that is what it shows.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from .designs import DESIGNS, crank_of
from .largest import largest
from .parameters import SliderCrank, completed
from .run import Run, simulate

FILE = Path("tests/mechanisms/slider_crank_reference.json")
SETTINGS = ((1e-12, 2e-5), (3e-13, 2e-5), (1e-13, 2e-5), (3e-13, 7e-6), (1e-13, 5e-6), (1e-13, 2e-6), (3e-14, 1e-5))
IMPACTS = 4
LIMIT = 0.5  # [s] no run is longer
WINDOW = math.pi / 3.0  # [rad] of crank at the starting speed: the largest acceleration and torque within it
FIELDS = ("time", "approach_speed", "crank_angle", "peak_force", "peak_time", "release_time", "separation")
COLUMN = dict(zip(FIELDS, (1, 2, 3, 4, 5, 6, 7), strict=True))
INPUTS = ("clearance", "speed", "slider_mass", "rod_mass", "restitution", "stiffness")
STEPS = (8e-3, 4e-3, 2e-3, 1e-3)  # half the distance in ln p
TURN = 0.012  # [s] of the reference design


def median_and_error(values: Sequence[float]) -> tuple[float, float]:
    middle = float(np.median(values))
    return middle, float(np.max(np.abs(np.asarray(values) - middle)))


def impacts_of(crank: SliderCrank) -> list[dict]:
    """The first impacts, each number with its error; contact 0 is the crank pin, 1 the piston pin."""
    runs = [simulate(crank, LIMIT, rtol, IMPACTS, longest=longest) for rtol, longest in SETTINGS]
    if any(len(run.log) != IMPACTS or not np.isfinite(run.log[:, 4]).all() for run in runs):
        raise RuntimeError("a run has too few impacts")
    impacts = []
    for k in range(IMPACTS):
        numbers = {name: median_and_error([run.log[k, COLUMN[name]] for run in runs]) for name in FIELDS}
        record = {"contact": int(runs[0].log[k, 0])} | {name: value for name, (value, _) in numbers.items()}
        impacts.append(record | {"error": {name: error for name, (_, error) in numbers.items()}})
    return impacts


def maxima_of(crank: SliderCrank) -> dict:
    """Largest acceleration and torque of the first sixth of a turn (2 ms at 5000 rpm), with their errors."""
    window = WINDOW / crank.speed
    maxima = [largest(simulate(crank, window, rtol, rows=50000)) for rtol in (1e-12, 3e-13, 1e-13)]
    numbers = {name: median_and_error([each[name] for each in maxima]) for name in maxima[0]}
    record = {name: value for name, (value, _) in numbers.items()}
    return record | {"window": window, "error": {name: error for name, (_, error) in numbers.items()}}


def romberg(half_difference: Callable[[float], np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Central differences with steps halved, extrapolated; and the change that the last extrapolation made."""
    row = [half_difference(step) for step in STEPS]
    last = row[-1]
    for order in range(1, len(STEPS)):
        last = row[-1]
        row = [b + (b - a) / (4.0**order - 1.0) for a, b in pairwise(row)]
    return row[0], np.abs(row[0] - last)


def elasticities(crank: SliderCrank) -> dict:
    """d ln q / d ln p [-] of the first three peaks and the first touchdown's time, by p; each with its error.

    The error is the last extrapolation's change or what another tolerance makes of it, whichever is larger.
    By the clearance at given Young's modulus, so that the stiffness changes with it; "clearance alone" keeps that.
    """

    def logs(design: SliderCrank, rtol: float) -> np.ndarray:
        log = simulate(design, LIMIT, rtol, IMPACTS).log
        return np.log([log[0, 4], log[1, 4], log[2, 4], log[0, 1]])

    def moved(name: str, shift: float) -> SliderCrank:
        base = crank if name == "clearance" else completed(crank)
        name = name.removesuffix(" alone")
        return base._replace(**{name: getattr(base, name) * float(np.exp(shift))})

    table: dict = {}
    names = ("first_peak", "second_peak", "third_peak", "first_time")
    for name in (*INPUTS, "clearance alone"):
        (values, errors), (others, _) = (
            romberg(lambda h: (logs(moved(name, h), rtol) - logs(moved(name, -h), rtol)) / (2.0 * h))  # noqa: B023
            for rtol in (1e-12, 2e-13)
        )
        errors = np.maximum(errors, np.abs(others - values))
        table[name] = {q: {"value": float(v), "error": float(e)} for q, v, e in zip(names, values, errors, strict=True)}
    return table


def growth(crank: SliderCrank, shift: float = 1e-9) -> dict:
    """How a relative ``shift`` of the clearance grows in the peaks of the first turn, and by how much an impact.

    ``factor``: of the straight line through the logarithms; ``spread``: the runs of one design by several tolerances.
    """

    def peaks(design: SliderCrank) -> np.ndarray:
        return simulate(design, TURN, 1e-13).log[:, 4]

    stiff = completed(crank)
    base, up = peaks(stiff), peaks(stiff._replace(clearance=stiff.clearance * (1.0 + shift)))
    runs: list[Run] = [simulate(stiff, TURN, rtol, longest=longest) for rtol, longest in SETTINGS]
    spread = np.max([np.abs(run.log[:, 4] / base - 1.0) for run in runs], axis=0)
    ratio = np.abs(up / base - 1.0) / shift
    slope = np.polyfit(np.arange(len(ratio)), np.log10(ratio), 1)[0]
    return {
        "shift": shift,
        "peaks": base.tolist(),
        "growth": ratio.tolist(),
        "spread": spread.tolist(),
        "factor": float(10.0**slope),
        "digits_lost_per_impact": float(slope),
    }


def main(file: Path = FILE) -> None:
    """Write the file."""
    record: dict = {"command": "python -m benchmarks peers.slider_crank.reference", "designs": []}
    for name, inputs in DESIGNS.items():
        crank = crank_of(name)
        numbers = completed(crank)._asdict()
        impacts = impacts_of(crank)
        entry = {"name": name, "inputs": dict(inputs), "numbers": numbers, "impacts": impacts}
        record["designs"].append(entry | {"maxima": maxima_of(crank)})
        worst = max(impact["error"]["peak_force"] / impact["peak_force"] for impact in impacts)
        print(f"{name}: peaks to {worst:.1e}", flush=True)
    record["elasticities"] = elasticities(SliderCrank())
    record["growth"] = growth(SliderCrank())
    file.write_text(json.dumps(record, indent=1) + "\n")
