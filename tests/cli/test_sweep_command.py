"""`jaxbuffer sweep` and `report`: what they ask for, print, draw and write."""

import csv
import dataclasses
import html
import io
import json

import numpy as np
import pytest
import xarray as xr

import jaxbuffer as jb
from jaxbuffer import InputError, Outcome
from jaxbuffer.cli.entry import run
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.output.style import png
from jaxbuffer.output.sweep_figures import sweep_figure
from jaxbuffer.study.load import load
from jaxbuffer.study.problem_toml import limits
from jaxbuffer.sweeps.grid import grid
from jaxbuffer.sweeps.result import Sweep
from made_up import made_up_sweep
from output.drawn import check_readable

FILES = (
    "sweep.csv",
    "sweep.txt",
    "sweep.png",
    "sweep.nc",
    "sweep.json",
    "envelope.png",
)
TWO = ["--over", "scenario.approach_speed=0.1:0.3:3", "--over", "buffer.k_A=100,1000"]


def swept(asked, outcomes=None, done=None) -> Sweep:
    design, scenario = jb.table2(), jb.Scenario()
    over = grid(asked, design, scenario)
    found = made_up_sweep(*over.applied(design, scenario), outcomes)
    swept = dataclasses.replace(found, design=design, scenarios=scenario, grid=over)
    return swept if done is None else swept.only(done)


def table(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_without_a_grid_speeds_and_misalignments_are_swept(computed, capsys, tmp_path):
    assert run(["sweep", "--rtol", "1e-5", "--solver", "explicit", "--duration", "2"]) == 0
    command, asked = computed.calls[-1]
    assert command == "sweep" and asked["scenarios"].approach_speed.shape == (121,)
    assert (asked["scenarios"].misalignment.min(), asked["scenarios"].misalignment.max()) == (-0.1, 0.1)
    assert (asked["rtol"], asked["duration"]) == (1e-5, 2.0)
    assert type(asked["solver"]).__name__ == "ExplicitRungeKutta"
    shown = capsys.readouterr()
    assert "Sweep of 121 captures: 11 approach_speed × 11 misalignment" in shown.out
    assert "sweeping 121 runs" in shown.err and "121 of 121 done" in shown.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("no_figures")
def test_runs_that_are_not_trusted_are_counted_and_marked(computed, capsys, monkeypatch, tmp_path):
    assert run(["sweep", *TWO, "--output", "out"]) == 0
    assert computed.calls[-1][1]["trust"] is True and "ill-conditioned" not in capsys.readouterr().out
    assert [row["trust"] for row in table((tmp_path / "out/sweep.csv").read_text())] == ["trusted"] * 6

    def doubtful(designs, scenarios, outcomes):
        found = made_up_sweep(designs, scenarios, outcomes)
        found.columns["trust"][:4] = [2, 1, 1, -1]
        return found

    monkeypatch.setattr("computed.made_up_sweep", doubtful)
    assert run(["sweep", *TWO, "--trust", "off", "--output", "out", "--force"]) == 0
    assert computed.calls[-1][1]["trust"] is False
    words = " ".join(capsys.readouterr().out.split())
    assert "1 of 6 captures are ill-conditioned: little decides what happens" in words
    assert "2 of 6 captures have numbers that may be off by more than 1e-04 of them (see trust in sweep.csv)" in words
    marked = [row["trust"] for row in table((tmp_path / "out/sweep.csv").read_text())]
    assert marked == ["ill-conditioned", "check", "check", "", "trusted", "trusted"]
    assert run(["sweep", *TWO, "--trust", "maybe"]) == 2
    assert "trust" in capsys.readouterr().err


def test_the_grid_of_the_study_and_the_command_line(computed, no_figures, tmp_path):
    (tmp_path / "study.toml").write_text(
        "[buffer]\nc_A = 7\n[sweep]\nscenario.approach_speed = [0.1, 0.2]\nbuffer.k_A = [300, 400]"
    )
    assert run(["sweep", "study.toml"]) == 0
    asked = computed.calls[-1][1]
    assert asked["scenarios"].approach_speed.tolist() == [0.1, 0.1, 0.2, 0.2]
    assert asked["design"].buffer.k_A.tolist() == [300.0, 400.0] * 2 and asked["design"].buffer.c_A == 7.0
    assert run(["sweep", "study.toml", "--over", "buffer.k_A=500", "--buffer.c_A", "9"]) == 0
    asked = computed.calls[-1][1]
    assert asked["design"].buffer.k_A.tolist() == [500.0, 500.0] and asked["design"].buffer.c_A == 9.0
    over = ["--over", "contact.law=hertz", "--over", "scenario.approach_speed=0.1,0.2"]
    assert run(["sweep", *over, "--output", "out"]) == 0 and computed.calls[-1][1]["design"].contact.law == "hertz"
    found = jb.load(tmp_path / "out").sweep.peak_force
    assert found.dims == ("contact.law", "scenario.approach_speed") and found["contact.law"].item() == "hertz"


def test_summary_counts_outcomes_and_names_the_worst_and_the_failed(computed, capsys):
    computed.outcomes = {1: Outcome.escaped, 4: Outcome.failed_step_size}
    assert run(["sweep", *TWO]) == 0, "a capture that fails is a result"
    shown = capsys.readouterr().out
    words = " ".join(shown.split())
    for part in (
        "Sweep of 6 captures: 3 approach_speed × 2 k_A",
        "scenario.approach_speed 0.1, 0.2, 0.3 m/s",
        "captured: the tip centre crossed the capture plane inwards 4 66.7 %",
        "escaped: the tip left the cone 1 16.7 %",
        "Quantities of the 5 captures that were solved",
        "greatest peak force 400 N at approach_speed 0.3 m/s, k_A 1000 N/m: upper flank after 0.02 s, 3 impacts",
        "least peak force of those captured 110 N at approach_speed 0.1 m/s, k_A 100 N/m",
        f"approach_speed 0.3 m/s, k_A 100 N/m: {Outcome.failed_step_size.reason}",
    ):
        assert part in words, part
    (peaks,) = (line.split() for line in shown.splitlines() if line.startswith(" peak_force"))
    assert [float(x) for x in peaks[2:]] == [110.0, 146.0, 210.0, 360.0, 400.0], "of 110, 200, 210, 300 and 400 N"


def test_files(computed, capsys, tmp_path):
    computed.outcomes = {1: Outcome.escaped, 4: Outcome.failed_step_size}
    assert run(["sweep", *TWO, "--probe.tip_mass", "0.05", "--output", "out"]) == 0
    printed = capsys.readouterr().out
    folder = tmp_path / "out"
    assert {path.name for path in folder.iterdir()} == set(FILES)
    rows = table((folder / "sweep.csv").read_text())
    assert [row["outcome"] for row in rows] == [
        "captured",
        "escaped",
        "captured",
        "captured",
        "failed_step_size",
        "captured",
    ]
    assert [float(row["buffer.k_A [N/m]"]) for row in rows] == [100.0, 1000.0] * 3
    assert [row["peak_force [N]"] for row in rows] == ["110.0", "200.0", "210.0", "300.0", "", "400.0"]
    assert (rows[0]["peak_flank"], rows[4]["peak_flank"], rows[0]["impact_count"]) == ("upper", "", "3")
    found = jb.load(folder)
    force = found.sweep.peak_force
    assert force.shape == (3, 2) and np.isnan(force.values[2, 0]) and force.units == "N"
    assert force.values[2, 1] == pytest.approx(400.0, rel=1e-15)
    assert found.sweep["buffer.k_A"].values.tolist() == [100.0, 1000.0]
    assert found.design.probe.tip_mass == 0.05
    assert (folder / "sweep.txt").read_text() in printed
    assert (folder / "sweep.png").read_bytes().startswith(b"\x89PNG")
    assert run(["sweep", *TWO, "--output", "out"]) == 2
    assert "sweep.csv and 5 more exist; --force overwrites, another --output keeps them" in capsys.readouterr().err
    assert run(["sweep", "--output", "out", "--force"]) == 0
    assert len(table((folder / "sweep.csv").read_text())) == 121


def test_ctrl_c_keeps_what_was_done(computed, no_figures, capsys, tmp_path):
    computed.interrupt_after = 4
    assert run(["sweep", *TWO, "--output", "out"]) == 130
    shown = capsys.readouterr()
    assert "interrupted, 4 of them done" in shown.out and "wrote out" in shown.out
    assert shown.err.endswith("interrupted\n")
    assert len(table((tmp_path / "out" / "sweep.csv").read_text())) == 4
    outcomes = jb.load(tmp_path / "out").sweep.outcome.values.ravel().tolist()
    assert outcomes == ["captured"] * 4 + ["not computed"] * 2


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["scenario.aproach_speed=0.1"], "scenario.aproach_speed is unknown; did you mean scenario.approach_speed?"),
        (["probe.free_tip=1"], "probe.free_tip = 1.0 must be true or false"),
        (["contact.law=hertz,exat"], "contact.law = 'exat' is unknown; choose one of"),
        (["buffer.k_A=100:200:0"], "count = 0"),
        (["buffer.k_A="], "expected FIELD=FROM:TO:COUNT[:log] or FIELD=VALUE,VALUE"),
        (["buffer.k_A=1:2:1e12"], "TiB of memory"),
        (["scenario.contact_distance=0.01:0.09:3"], "scenario.contact_distance = 0.09 m is out of range"),
        (["buffer.k_A=1", "buffer.k_A=2"], "--over buffer.k_A is given more than once"),
    ],
)
def test_bad_grids_are_one_line_and_exit_code_2(computed, capsys, tmp_path, words, message):
    assert run(["sweep", "--output", "out", *(part for word in words for part in ("--over", word))]) == 2
    shown = capsys.readouterr()
    assert message in shown.err and shown.err.count("\n") == 1
    assert all(name == "configure" for name, _ in computed.calls) and list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", [["sweep"], ["sample", "--count", "4"]])
def test_without_a_single_answer_the_solver_failed(computed, capsys, command):
    computed.outcomes = dict.fromkeys(range(4), Outcome.failed_step_size)
    ranges = {"sweep": ["--over", "buffer.k_A=100:400:4"], "sample": ["--over", "buffer.k_A=100:400"]}[command[0]]
    assert run([*command, *ranges]) == 3
    assert "none of the 4 captures was solved" in capsys.readouterr().err


def test_a_tuned_design_keeps_its_limits(computed, no_figures, capsys, tmp_path):
    """Tuned, then simulated, swept and tuned again: the study's limits hold throughout, and no others."""
    (tmp_path / "study.toml").write_text(
        "[problem.constraints]\nstroke = '30 mm'\npeak_force = {min = 1, max = 240}\nimpacts = 50\n"
    )
    assert run(["tune", "study.toml", "--output", "tuned"]) == 0
    assert limits(load(tmp_path / "tuned" / "design.toml").table, PROBE_CONE) == limits(
        load(tmp_path / "study.toml").table, PROBE_CONE
    )
    assert "\nrequire_success = true\n" in (tmp_path / "tuned" / "design.toml").read_text()
    assert run(["simulate", "tuned/design.toml"]) == 1
    assert "[problem.constraints] not kept: peak_force 250 N is above 240 N" in capsys.readouterr().err
    assert run(["sweep", "tuned/design.toml", *TWO]) == 0
    asked = "Safe (captured, peak force ≤ 240 N, stroke ≤ 30 mm, peak force ≥ 1 N, impacts ≤ 50)"
    shown = capsys.readouterr().out
    assert all(word in shown for word in asked.removeprefix("Safe (").rstrip(")").split(", "))
    assert run(["sweep", *TWO]) == 0
    assert "Safe (captured): " in capsys.readouterr().out, "a study without limits has none"


def test_a_map_of_an_interrupted_sweep(computed, capsys, tmp_path):
    computed.interrupt_after, computed.outcomes = 3, dict.fromkeys(range(3, 6), -1)
    assert run(["sweep", *TWO, "--output", "out"]) == 130
    assert {"sweep.csv", "sweep.png", "envelope.png"} <= {path.name for path in (tmp_path / "out").iterdir()}
    assert "Safe (captured): 3 of 3 captures run, of 6" in capsys.readouterr().out


def test_help_teaches(computed, capsys):
    assert run(["sweep", "--help"]) == 0
    shown = capsys.readouterr().out
    for part in (
        *FILES,
        "--over scenario.approach_speed=0.05:0.3:20",
        '{from = 100, to = 2000, count = 8, scale = "log"}',
    ):
        assert part in shown


SPEEDS = {"from": 0.1, "to": 0.3, "count": 5}
SPRINGS = {"from": 100.0, "to": 1000.0, "count": 4, "scale": "log"}
OUTCOMES = {1: Outcome.escaped, 2: Outcome.timeout, 3: Outcome.failed_not_finite}


def test_figure_over_one_field():
    figure = sweep_figure(swept({"buffer.k_A": SPRINGS, "buffer.c_A": 5.0}, OUTCOMES))
    assert len(figure.axes) == 4 and {axes.get_xlabel() for axes in figure.axes} == {"k_A [N/m]"}
    axes = figure.axes[0]
    assert (axes.get_xscale(), axes.get_ylabel()) == ("log", "peak contact force [N]")
    np.testing.assert_allclose(axes.lines[0].get_ydata()[:3], 100.0 + 0.1 * np.geomspace(100, 1000, 4)[:3])
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["escaped", "timeout", "failed"]
    assert "c_A 5 N s/m" in figure.get_suptitle()


def test_figure_over_two_fields_marks_what_was_not_captured():
    done = np.arange(20) < 18
    figure = sweep_figure(swept({"scenario.approach_speed": SPEEDS, "buffer.k_A": SPRINGS}, OUTCOMES, done))
    axes = figure.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("approach speed [m/s]", "k_A [N/m]")
    image, *marks = axes.collections
    assert image.get_array().shape == (4, 5), "speed runs to the right"
    assert image.get_array()[0, 4] == pytest.approx(310.0) and image.get_array().mask[3, 0], "a failed one is blank"
    places = [tuple(mark.get_offsets()[0]) for mark in marks]
    expected = [(0.1, 10 ** (7 / 3)), (0.1, 10 ** (8 / 3)), (0.1, 1000.0), (0.3, 10 ** (8 / 3))]
    np.testing.assert_allclose(places, expected)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["escaped", "timeout", "failed", "not computed"]
    assert png(figure).startswith(b"\x89PNG")


def test_cells_reach_halfway_to_their_neighbours_on_the_axis_own_scale():
    figure = sweep_figure(swept({"scenario.approach_speed": [0.3, 0.1], "buffer.k_A": SPRINGS}))
    corners = figure.axes[0].collections[0].get_coordinates()
    np.testing.assert_allclose(corners[0, :, 0], [0.0, 0.2, 0.4], atol=1e-15)
    np.testing.assert_allclose(corners[:, 0, 1], 100.0 * 10.0 ** (np.arange(-1, 8, 2) / 6))
    assert figure.axes[0].collections[0].get_array()[0, 1] == pytest.approx(310.0), "sorted, values with them"


def test_figure_over_more_fields_is_cut_into_slices():
    asked = {
        "buffer.c_A": [2.0, 5.0],
        "scenario.approach_speed": SPEEDS,
        "buffer.k_A": SPRINGS,
        "buffer.c_T": {"from": 1.0, "to": 2.0, "count": 3},
        "probe.tip_mass": [0.05, 0.06, 0.07],
    }
    figure = sweep_figure(swept(asked))
    assert "9 of 18 slices" in figure.get_suptitle()
    panels = [axes for axes in figure.axes if axes.get_xlabel()]
    assert len(panels) == 9
    first, last = (panel.get_title(loc="left").replace("\n", " ") for panel in (panels[0], panels[-1]))
    assert first == "c_A 2 N s/m, c_T 1 N m s/rad, tip mass 0.05 kg"
    assert last == "c_A 5 N s/m, c_T 2 N m s/rad, tip mass 0.07 kg"
    check_readable(figure)


@pytest.mark.slow
def test_report_prints_its_abstract_and_no_summary_again(computed, no_figures, capsys, tmp_path):
    for words in (["simulate"], ["sensitivity"], ["tune"], ["sweep", *TWO]):
        assert run([*words, "--output", words[0]]) == 0
        printed = {line for line in capsys.readouterr().out.splitlines() if not line.startswith("wrote")}
        assert run(["report", words[0]]) == 0
        *abstract, wrote = capsys.readouterr().out.splitlines()
        assert wrote == f"wrote {words[0]}/report.html"
        assert 1 <= len(abstract) <= 3 and not printed & set(abstract)
        page = html.unescape((tmp_path / words[0] / "report.html").read_text())
        assert all(line in page for line in abstract[-1:])


def test_report_without_results(capsys, tmp_path):
    assert run(["report", str(tmp_path / "none")]) == 2
    assert "none: no such folder" in capsys.readouterr().err
    assert run(["report", str(tmp_path)]) == 2
    made_by = "simulate, sensitivity, sweep, tune, sample, pareto, choose or fit"
    assert f"holds no results of {made_by}" in capsys.readouterr().err
    (tmp_path / "sweep.npz").write_bytes(b"not one")
    assert run(["report", str(tmp_path)]) == 2
    assert "sweep.npz was written by an earlier version, or is damaged; sweep again" in capsys.readouterr().err


def test_arrays_of_an_earlier_version_are_refused_by_its_name(tmp_path):
    np.savez(tmp_path / "sweep.npz", sweep=np.array(json.dumps({"jaxbuffer": "0.0.9"})))
    with pytest.raises(InputError, match=r"sweep\.npz was written by jaxbuffer 0\.0\.9.*; sweep again"):
        jb.load(tmp_path)


def test_data_of_something_else_are_refused(tmp_path):
    xr.Dataset({"x": 1.0}).to_netcdf(tmp_path / "sweep.nc", engine="h5netcdf")
    with pytest.raises(InputError, match=r"sweep\.nc is damaged or no result of jaxbuffer"):
        jb.load(tmp_path)
