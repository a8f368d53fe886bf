"""Models around a made-up tuning, of functions that are known: smooth forces, and one that jumps."""

import numpy as np

import jaxbuffer as jb
from jaxbuffer.experiments.what_if import MovableNumber, WhatIf
from jaxbuffer.experiments.what_if_model import endings, fit
from jaxbuffer.study.load import loads

RUNS = 96
STUDY = b"""
[problem.variables]
buffer.free_length = ["100 mm", "200 mm"]
buffer.k_A = [100, 900]
[problem.constraints]
stroke = "25 mm"
relative_energy = {min = "5 %"}
[problem.grid]
approach_speed = [0.1, 0.2, 0.3]
"""


def quantity(name, case, u):
    """The values [N, m, -] of a quantity at shares (n, 2) of the sliders."""
    x, y = u[..., 0], u[..., 1]
    if name == "stroke":
        return (0.012 + 0.004 * case) * np.exp(0.3 * x - 0.2 * y)
    if name == "relative_energy":
        return 0.1 + 0.05 * x * y - 0.01 * case
    if name == "hinge_angle":  # with a discontinuity in one scenario
        return 0.01 * np.exp(0.1 * x) + 0.008 * (x + y > 1.0) * (case == 1)
    return (100.0 + 60.0 * case) * np.maximum(np.exp(0.5 * x - 0.4 * y), 1.05 + 0.2 * y)  # two impacts


def made_what_if(
    names=("peak_force", "stroke", "hinge_angle", "relative_energy"), failing=False, omitted=("end_time",)
):
    """Models at the middle of both ranges; with ``failing`` the last scenario's runs end otherwise in a corner."""
    problem = loads(STUDY, "study.toml").problem()
    halfway = [v.scaled(0.5 * (v.low + float(jb.get(problem.design, v.path)))) for v in problem.variables]
    design = problem.built(halfway)  # what `made_up_tuning` finds
    problem = jb.Problem(design, problem.scenarios, problem.variables, limits=problem.limits, units=problem.units)
    rng = np.random.default_rng(4)
    shares, apart = np.vstack([[0.5, 0.5], rng.random((RUNS - 1, 2))]), rng.random((20, 2))
    succeeded = np.ones((RUNS, 3), bool)
    if failing:
        succeeded[:, 2] = shares[:, 0] < 0.8
    models = []
    for case in range(3):
        of, row = succeeded[:, case], []
        kept = apart[apart[:, 0] < 0.8] if failing and case == 2 else apart
        for name in names:
            known, truth = quantity(name, case, shares[of]), quantity(name, case, kept)
            row.append(fit(shares[of], known, kept, truth, np.flatnonzero(of), RUNS))
        models.append(tuple(row))
    sliders = (
        MovableNumber("buffer.free_length", "mm", 100.0, 150.0, 118.25, "log"),
        MovableNumber("buffer.k_A", "N/m", 200.0, 450.0, 300.0, "log"),
    )
    return WhatIf(
        problem=problem,
        sliders=sliders,
        cases=problem.cases,
        left_out=0,
        quantities=names,
        omitted=omitted,
        shares=shares,
        nominal=shares[0],
        models=tuple(models),
        succeeded=succeeded,
        endings=tuple(
            endings(shares, succeeded[:, case], apart, apart[:, 0] < (0.8 if failing and case == 2 else 2.0))
            for case in range(3)
        ),
        apart=20,
        runs=180,
    )
