"""A bar's first impact in Hertz-like contact without damping: the peak is a product of powers, so everything about its
sample has a closed form."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.experiments.indices import estimated

RANGES = {"impact.stiffness": (1e10, 1e12, "log"), "scenario.height": (0.02, 0.2, "log")}  # N/m^e, m
EXPONENT = 2.2
POWERS = np.array([1.0, EXPONENT]) / (EXPONENT + 1.0)  # F = k^(1/(e+1)) ((e+1) m v²/6)^(e/(e+1)), v² = 3 g H
SOURCE = "F = k ((e+1) m v²/6k)^(e/(e+1)), v² = 3 g H (docs/bar_drop.md)"


@pytest.fixture(scope="module")
def drops():
    design = jb.replace(jb.BarDrop(), {"impact.damping": 0.0})
    return jb.sample(design, jb.BarDropScenario(), RANGES, count=256, method="saltelli", duration=0.25)


def peak(values):
    """Closed form of the peak [N]."""
    bar = jb.BarDrop().bar
    mass = bar.density * np.pi / 4 * bar.diameter**2 * bar.length / 3.0
    k, speed2 = values["impact.stiffness"], 3 * 9.81 * values["scenario.height"]
    return k * ((EXPONENT + 1) * mass * speed2 / (2 * k)) ** (EXPONENT / (EXPONENT + 1))


def peak_with_weight(values):
    """The same with the weight's work on the way into the plate: k δ^(e+1) / (e+1) = m g (H + δ) / 2."""
    bar = jb.BarDrop().bar
    weight = 9.81 * bar.density * np.pi / 4 * bar.diameter**2 * bar.length
    k, height = values["impact.stiffness"], values["scenario.height"]
    depth = np.zeros_like(k)
    for _ in range(50):
        depth = ((EXPONENT + 1) * weight * (height + depth) / (2 * k)) ** (1 / (EXPONENT + 1))
    return k * depth**EXPONENT


def exact_indices():
    """Of a product of powers of log-uniform numbers: c = variance over mean² of each factor."""
    lengths = np.log([high / low for low, high, _ in RANGES.values()])

    def mean(powers):  # of x^a over its value at the low end
        return np.expm1(powers * lengths) / (powers * lengths)

    c = mean(2 * POWERS) / mean(POWERS) ** 2 - 1.0
    whole = np.prod(1 + c) - 1.0
    return c / whole, c * np.prod(1 + c) / (1 + c) / whole


def test_peaks_of_the_sample_are_the_closed_form(drops, evidence):
    error = np.max(np.abs(drops.sweep.peak_force / peak_with_weight(drops.values) - 1.0))
    source = "energy: k δ^(e+1) / (e+1) = m g (H + δ) / 2"
    evidence("Design of experiments", "first peaks of 1024 sampled drops", error, 1e-4, source, "-")


def test_indices_of_the_peak_are_those_of_a_product_of_powers(drops, evidence):
    found = jb.sobol_indices(drops).estimates["peak_force"]
    of_form = estimated(peak(drops.values), 2)
    same = max(np.max(np.abs(found.first - of_form.first)), np.max(np.abs(found.total - of_form.total)))
    claim = "indices of a drop's peak beside those of its closed form at the same points"
    evidence("Design of experiments", claim, same, 2e-3, SOURCE, "-")
    for what, mine, exact in zip(("first-order", "total"), (found.first, found.total), exact_indices(), strict=True):
        error = np.max(np.abs(mine - exact))
        claim = f"{what} indices of a drop's peak, 256 rows"
        evidence("Design of experiments", claim, error, 0.08, "closed form of a product of powers", "-")


@pytest.mark.slow
def test_a_quadratic_in_logarithms_is_exact_for_powers(drops, evidence):
    surface = jb.response_surface(drops, "peak_force", "quadratic")
    evidence("Design of experiments", "quadratic surface of a product of powers", surface.error.relative, 1e-3, SOURCE)
    values = {"impact.stiffness": np.array([3e10, 5e11]), "scenario.height": np.array([0.05, 0.1])}
    error = np.max(np.abs(surface.predict(values) / peak_with_weight(values) - 1.0))
    evidence("Design of experiments", "a response surface at points not sampled", error, 5e-3, SOURCE, "-")
    through = jb.sobol_indices(plain(drops), ["peak_force"]).estimates["peak_force"]
    error = max(np.max(np.abs(a - b)) for a, b in zip((through.first, through.total), exact_indices(), strict=True))
    claim = "indices of a drop's peak through its response surface"
    evidence("Design of experiments", claim, error, 0.02, "closed form of a product of powers", "-")


def plain(drops):
    """The first 256 of the runs as a sample of another method."""
    import dataclasses

    grid = dataclasses.replace(drops.grid, shares=drops.grid.shares[:256], method="sobol")
    columns = {name: column[:256] for name, column in drops.columns.items()}
    return dataclasses.replace(drops, grid=grid, columns=columns)


def test_a_surface_refuses_what_it_does_not_know(drops):
    surface = jb.response_surface(drops, "penetration", "quadratic")
    for values, said in (
        ({"impact.stiffness": 1e9, "scenario.height": 0.1}, "= 1e.09 N/m.e is outside of what was sampled"),
        ({"impact.stiffness": 1e11}, "scenario.height is missing"),
        ({"impact.stiffnes": 1e11}, "did you mean impact.stiffness"),
        ({"impact.stiffness": "x", "scenario.height": 0.1}, "is not a number"),
        ({"impact.stiffness": [1e10] * 2, "scenario.height": [0.1] * 3}, "one length"),
    ):
        with pytest.raises(jb.InputError, match=said):
            surface.predict(values)
    with pytest.raises(jb.InputError, match="did you mean peak_force"):
        jb.response_surface(drops, "peak_forse")


def test_the_safe_rectangle_of_drops_is_where_the_closed_form_is_below_the_limit():
    design = jb.replace(jb.BarDrop(), {"impact.damping": 0.0})
    values = {"scenario.height": [0.2, 0.05, 0.1], "impact.stiffness": [1e10, 1e11, 5e11, 1e12]}
    swept = jb.sweep(design, jb.BarDropScenario(), 0.25, over=values)
    found = jb.safe_rectangle(swept, jb.Limits(at_most={"peak_force": 400.0}))
    height, stiffness = np.meshgrid(*found.values, indexing="ij")
    assert np.array_equal(found.safe, peak({"impact.stiffness": stiffness, "scenario.height": height}) <= 400.0)
    assert "peak force above its limit" in found.reasons and found.safe.any() and not found.safe.all()
    with pytest.raises(jb.InputError, match="is no quantity of a sweep"):
        jb.safe_rectangle(swept, jb.Limits(at_most={"stroke": 1.0}))
    with pytest.raises(jb.InputError, match="over two fields"):
        jb.safe_rectangle(jb.sweep(design, jb.BarDropScenario(), 0.25, over={"scenario.height": [0.1, 0.2]}))
    none = jb.safe_rectangle(swept, jb.Limits(at_most={"peak_force": 1e-3}))
    assert none.first is None and none.runs == 0 and "no run is safe" in repr(none)


def test_verdicts_of_a_sample_are_those_of_single_runs():
    """At a tolerance loose enough that some are not trusted."""
    design, scenario = jb.BarDrop(), jb.BarDropScenario()
    sample = jb.sample(design, scenario, RANGES, 8, duration=0.25, rtol=1e-3, trust=True)
    singles = []
    for k in range(8):
        at = {path: float(values[k]) for path, values in sample.values.items()}
        one = jb.replace(design, {"impact.stiffness": at["impact.stiffness"]})
        there = jb.BarDropScenario(height=at["scenario.height"])
        singles.append(jb.trust(*(jb.simulate(one, there, 0.25, rtol=rtol) for rtol in (1e-3, 1e-4))).verdict)
    assert sample.sweep.verdicts == singles == sample.to_dataframe()["trust"].tolist()
    assert len(set(singles)) > 1
    assert jb.sample(design, scenario, RANGES, 8, duration=0.25).sweep.verdicts == [""] * 8


def test_a_sample_goes_on_where_it_was_stopped(drops, tmp_path):
    design, scenario = drops.design, drops.scenario
    again = {"count": 32, "method": "sobol", "duration": 0.25, "folder": tmp_path}
    whole = jb.sample(design, scenario, RANGES, **again)
    resumed = jb.sample(design, scenario, RANGES, **again, resume=True)
    assert np.array_equal(whole.sweep.peak_force, resumed.sweep.peak_force)
    with pytest.raises(jb.InputError, match="holds another sweep"):
        jb.sample(design, scenario, RANGES, **{**again, "seed": 1}, resume=True)
