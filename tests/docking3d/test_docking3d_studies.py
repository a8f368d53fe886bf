"""Each command to its end on a study in space of 20 ms: the first impact alone, by programs that the tests share."""

import csv
import json

import numpy as np
import pytest

from jaxbuffer.cli.entry import run as command

pytestmark = [pytest.mark.slow, pytest.mark.long]

STUDY = """kind = "docking3d"
[scenario]
azimuth = 0.7
passive_pitch = "1 deg"
[options]
duration = "20 ms"
[problem.variables]
buffer.k_A = [300, 900]
[problem.constraints]
stroke = "25 mm"
require_success = false
[tune]
starts = 1
iterations = 3
[sweep]
scenario.passive_pitch = ["1 deg", "-1 deg"]
[sample]
count = 8
[sample.ranges]
scenario.passive_pitch = ["-1 deg", "1 deg"]
scenario.azimuth = ["0 deg", "90 deg"]
"""
PARTS = """
[parts.spring]
S1 = {buffer.k_A = 300}
S2 = {buffer.k_A = 900}
[choose]
optimum = false
"""
FIT = """
[fit.parameters]
buffer.k_A = [300, 900]
[[fit.tests]]
file = "test.csv"
[fit.tests.columns]
"stroke [mm]" = {quantity = "stroke", noise = "2 um"}
"beta [deg]" = {quantity = "hinge_beta", noise = "0.2 mdeg"}
"""
TRUTH = 500.0  # N/m, the stiffness of the design that is tested


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the study, and the run of its scenario in `run`."""
    folder = tmp_path_factory.mktemp("space")
    (folder / "study.toml").write_text(STUDY)
    (folder / "parts.toml").write_text(STUDY.replace("[problem.variables]\nbuffer.k_A = [300, 900]\n", "") + PARTS)
    (folder / "fit.toml").write_text(STUDY.replace("[scenario]", "[buffer]\nk_A = 700\n[scenario]") + FIT)
    assert command(["simulate", str(folder / "study.toml"), "--output", str(folder / "run")]) in (0, 1)
    return folder


def ran(folder, name, *options, study="study.toml", status=(0,)):
    """The folder of results of a command."""
    assert command([name, str(folder / study), *options, "--output", str(folder / name), "--force"]) in status
    return folder / name


def test_simulate_writes_both_views_and_all_of_space(folder):
    record = json.loads((folder / "run" / "capture.json").read_text())
    assert record["outcome"] == "timeout" and len(record["impacts"]) > 0 and record["impacts"][0]["cone"] == "cone"
    with (folder / "run" / "history.csv").open() as lines:
        names = next(csv.reader(lines))
    assert {"hinge_alpha [rad]", "tip_z [m]", "passive velocity spin_x [rad/s]", "tip_force_z [N]"} <= set(names)
    motion = json.loads((folder / "run" / "motion.json").read_text())
    assert "along the cone's axis" in json.dumps(motion)


def test_sweep_has_the_run_among_its_own(folder):
    with (ran(folder, "sweep") / "sweep.csv").open() as lines:
        rows = list(csv.DictReader(lines))
    record = json.loads((folder / "run" / "capture.json").read_text())
    assert len(rows) == 2 and float(rows[0]["peak_force [N]"]) == pytest.approx(record["peak_force [N]"], rel=1e-6)
    assert float(rows[1]["peak_force [N]"]) != pytest.approx(record["peak_force [N]"], rel=1e-4)


def test_sample_tells_which_number_matters(folder, capsys):
    ran(folder, "sample", "--indices")
    shown = capsys.readouterr().out
    assert "Sobol' indices of peak_force" in shown and "scenario.azimuth" in shown


def test_sensitivity_agrees_with_differences(folder):
    record = json.loads((ran(folder, "sensitivity", "--wrt", "buffer.k_A") / "sensitivity.json").read_text())
    assert record["certificate"]["verdict"] == "trusted"


def test_tune_keeps_its_limits_and_gets_no_worse(folder):
    tuned = json.loads((ran(folder, "tune") / "tuned.json").read_text())
    assert tuned["feasible"] and tuned["objective_after"] <= tuned["objective_before"]


def test_pareto_has_two_ends(folder):
    found = ran(folder, "pareto", "--objectives", "peak_force,stroke", "--points", "2")
    with (found / "pareto.csv").open() as lines:
        assert len(list(csv.DictReader(lines))) == 2


def test_choose_ranks_both_springs(folder):
    found = json.loads((ran(folder, "choose", study="parts.toml") / "choice.json").read_text())
    assert len(found["ranking"]) == 2


def test_fit_finds_the_stiffness(folder):
    history = np.genfromtxt(folder / "run" / "history.csv", delimiter=",", names=True, deletechars="")
    with (folder / "run" / "history.csv").open() as lines:
        names = next(csv.reader(lines))
    columns = {name: history[key] for name, key in zip(names, history.dtype.names, strict=True)}
    random, at = np.random.default_rng(4), np.linspace(0.0, 0.0195, 60)
    stroke, beta = (np.interp(at, columns["time [s]"], columns[name]) for name in ("stroke [m]", "hinge_beta [rad]"))
    noisy = [1e3 * stroke + random.normal(0.0, 2e-3, 60), np.degrees(beta) + random.normal(0.0, 2e-4, 60)]
    table = np.stack([at, *noisy], axis=1)
    np.savetxt(folder / "test.csv", table, delimiter=",", header="time [s],stroke [mm],beta [deg]", comments="")
    found = json.loads((ran(folder, "fit", study="fit.toml") / "fit.json").read_text())
    stiffness = found["parameters"]["buffer.k_A"]
    assert stiffness["low"] < TRUTH < stiffness["high"] < 1.1 * stiffness["low"]


def test_animate_makes_a_film(folder):
    film = folder / "film.gif"
    assert command(["animate", str(folder / "study.toml"), "--output", str(film)]) in (0, 1)
    image = pytest.importorskip("PIL.Image").open(film)
    assert image.n_frames > 50 and image.size[0] > 800  # both views side by side


def test_report_has_the_motion_in_both_views(folder):
    assert command(["report", str(folder / "run")]) == 0
    page = (folder / "run" / "report.html").read_text()
    assert "along the cone's axis" in page and "flank" not in page
