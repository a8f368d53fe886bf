"""Sweeps over named dimensions, choices among them, against single runs."""

import json
import threading

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.cli.entry import run
from jaxbuffer.sweeps import sweep as sweeps
from jaxbuffer.sweeps.result import SweepInterrupted

DESIGN = jb.replace(jb.BarDrop(), {"impact.exponent": 1.5})  # which Hertz's law has
HEIGHTS, LAWS = [0.1, 0.15, 0.194], ["adams", "hertz"]
OVER = {"impact.law": LAWS, "scenario.height": HEIGHTS}
OPTIONS = {"duration": 0.22, "workers": 1}


@pytest.fixture(scope="module")
def swept():
    return jb.sweep(DESIGN, jb.BarDropScenario(), over=OVER, **OPTIONS)


@pytest.mark.slow
def test_every_combination_is_the_single_run(swept, evidence):
    data = swept.to_xarray()
    assert dict(data.sizes) == {"impact.law": 2, "scenario.height": 3}
    assert data["scenario.height"].units == "m" and data.peak_force.units == "N"
    assert np.unique(data.outcome).tolist() == ["finished"]
    worst = 0.0
    for law, height in (("adams", 0.194), ("adams", 0.1)):  # Hertz's are compared with its closed form
        design, scenario = jb.replace(DESIGN, {"impact.law": law}), jb.BarDropScenario(height=height)
        alone = jb.simulate(design, scenario, OPTIONS["duration"])
        mine = data.sel({"impact.law": law, "scenario.height": height})
        worst = max(worst, abs(float(mine.peak_force) / float(alone.peak_force) - 1.0))
        assert int(mine.impact_count) == int(alone.impact_count) and mine.peak_plate.item() == "plate"
    evidence("labelled data", "peak of a swept choice against the single run", worst, 1e-9, "jb.simulate", "-")


@pytest.mark.slow
def test_hertz_without_loss_is_the_closed_form(swept, evidence):
    """F = k δ^e with δ = ((e + 1) m_eff v²/2k)^{1/(e+1)}, v from the height: mechanisms.md, section 1."""
    data = swept.to_xarray().peak_force.sel({"impact.law": "hertz"})
    bar, k, e = DESIGN.bar, float(DESIGN.impact.stiffness), 1.5
    inertia = 7850.0 * np.pi / 4 * bar.diameter**2 * bar.length * bar.length**2 / 3.0
    sine = np.array(HEIGHTS) / bar.length
    speed = bar.length * np.sqrt(3.0 * 9.81 / bar.length * sine)
    depth = ((e + 1.0) * inertia / bar.length**2 * speed**2 / (2.0 * k)) ** (1.0 / (e + 1.0))
    error = np.max(np.abs(data.values / (k * depth**e) - 1.0))
    # gravity during the impact, which the closed form leaves out, does m g δ/2 of work on some T = m g H/2
    evidence("labelled data", "Hertz's peaks over drop heights", error, 1e-4, "closed form without gravity", "-")


def test_rows_are_in_long_form(swept):
    table = swept.to_dataframe()
    assert list(table.columns[:4]) == ["impact.law", "scenario.height [m]", "outcome", "peak_force [N]"]
    assert len(table) == 6 and table["impact.law"].tolist() == ["adams"] * 3 + ["hertz"] * 3
    data = swept.to_xarray()
    np.testing.assert_array_equal(table["peak_force [N]"], data.peak_force.values.ravel())


def test_arrays_along_runs_name_what_differs():
    found = jb.sweep(DESIGN, jb.BarDropScenario(height=HEIGHTS), **OPTIONS)
    data = found.to_xarray()
    assert dict(data.sizes) == {"run": 3} and data["scenario.height"].dims == ("run",)
    assert found.to_dataframe()["scenario.height [m]"].tolist() == HEIGHTS
    assert "<table>" in found._repr_html_()


def test_summary_and_html_tell_choices(swept):
    shown = " ".join(repr(swept).split())
    assert "Sweep of 6 drops: 2 law × 3 height" in shown and "impact.law adams, hertz" in shown
    assert "law adams" in shown.split("greatest peak force")[1]
    html = swept._repr_html_()
    assert html.count("<table>") == 2 and "impact.law" in html


def test_interrupted_and_resumed_a_sweep_over_choices_is_the_same(swept, tmp_path, monkeypatch):
    second, compute = threading.Event(), sweeps.columns_of_chunk

    def chunk(batch, *settings):
        if batch[0].impact.law == "hertz":
            second.wait(10.0)  # until the interrupt is over
        return compute(batch, *settings)

    def stop(done, count):
        raise KeyboardInterrupt

    monkeypatch.setattr(sweeps, "columns_of_chunk", chunk)
    scenario = jb.BarDropScenario()
    with pytest.raises(SweepInterrupted) as stopped:
        jb.sweep(DESIGN, scenario, over=OVER, folder=tmp_path, progress=stop, **OPTIONS)
    second.set()
    data = stopped.value.partial.to_xarray()
    assert data.outcome.sel({"impact.law": "hertz"}).values.tolist() == ["not computed"] * 3
    assert data.impact_count.sel({"impact.law": "hertz"}).values.tolist() == [-1] * 3
    turned = {name: OVER[name] for name in reversed(OVER)}
    with pytest.raises(jb.InputError, match="holds another sweep"):
        jb.sweep(DESIGN, scenario, over=turned, folder=tmp_path, resume=True, **OPTIONS)
    again = jb.sweep(DESIGN, scenario, over=OVER, folder=tmp_path, resume=True, **OPTIONS)
    assert again.to_xarray().identical(swept.to_xarray())


@pytest.mark.parametrize(
    ("over", "message"),
    [
        ({"impact.law": ["hertzz"]}, "impact.law = 'hertzz' is unknown; choose one of .* did you mean hertz"),
        ({"impact.lav": ["hertz"]}, "sweep: impact.lav is unknown; did you mean impact.law"),
        ({"scenario.height": [-1.0]}, "height = -1 m is out of range"),
        ({"impact.law": ["hertz"], "impact.exponent": [2.0]}, "'hertz' has the exponent 1.5"),
        ({}, "nothing to sweep; name a field and its values"),
    ],
)
def test_bad_dimensions_are_refused(over, message):
    with pytest.raises(jb.InputError, match=message):
        jb.sweep(DESIGN, jb.BarDropScenario(), over=over, **OPTIONS)


@pytest.mark.long
def test_the_command_line_takes_choices_and_its_files_are_read_back(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    jb.save_design("drop.toml", DESIGN)
    over = ["--over", "impact.law=adams,hertz", "--over", "scenario.height=0.1,0.15,0.194"]
    assert run(["sweep", "drop.toml", *over, "--duration", "0.22", "--output", "out"]) == 0
    capsys.readouterr()
    data = jb.load("out").sweep
    assert data.peak_force.dims == ("impact.law", "scenario.height") and data.attrs["kind"] == "bar_drop"
    choices = {"impact.law": ["adams", "hertz"], "scenario.height": [0.1, 0.15, 0.194]}
    again = jb.sweep(DESIGN, jb.BarDropScenario(), 0.22, over=choices, trust=True).to_xarray()
    assert json.loads(again.identity) == json.loads(data.identity)
    assert again.identical(data)
