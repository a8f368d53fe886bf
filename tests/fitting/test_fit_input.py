"""What a fit and its study refuse before anything is computed."""

import dataclasses

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.cli.commands import fit as fit_command
from jaxbuffer.cli.entry import run
from jaxbuffer.fitting.fit import checked
from made_up_fit import made_up_fit

DESIGN = jb.replace(jb.table2(), {"buffer.friction": 0.3})
TIMES = np.linspace(0.0, 0.1, 11)
FREE = {"buffer.k_A": (100.0, 3000.0)}

STUDY = """
[fit.parameters]
buffer.k_A = ["100 N/m", "3 kN/m"]
[[fit.tests]]
file = "test.csv"
scenario.approach_speed = "13 cm/s"
time_shift = ["0 ms", "30 ms"]
[fit.tests.columns]
"stroke [mm]" = {quantity = "stroke", noise = "0.02 mm"}
"""


def test_quantities_have_the_names_of_a_history(tmp_path):
    units = jb.recorded_quantities(jb.table2())
    assert units["stroke"] == "m" and units["passive_acceleration_x"] == "m/s²" and units["hinge_force"] == "N"


def recording(channel=None, times=TIMES, **others):
    return jb.Recording("bench", times, {"s": 0.0 * times}, {"s": channel or jb.Channel("stroke")}, **others)


@pytest.mark.parametrize(
    ("parameters", "test", "said"),
    [
        ({"buffer.kA": (1.0, 2.0)}, recording(), "buffer.kA is unknown; did you mean buffer.k_A?"),
        ({"buffer.k_A": (100.0, 400.0)}, recording(), "buffer.k_A = 500 is outside of its bounds 100 and 400"),
        ({"buffer.k_A": (900.0, 400.0)}, recording(), "the low bound 900 must be below the high one, 400"),
        ({"buffer.k_A": 500.0}, recording(), "buffer.k_A: expected two bounds"),
        ({"latch.stiffness": (1.0, 2.0)}, recording(), "latch.stiffness is not set"),
        ({"contact.law": (1.0, 2.0)}, recording(), "contact.law = 'lankarani-nikravesh' is not a number"),
        (FREE, recording(jb.Channel("strok")), 'bench: column "s": quantity strok is unknown; did you mean stroke?'),
        (FREE, recording(jb.Channel("stroke", noise=-1.0)), "bench: s: noise = -1 m is out of range"),
        (FREE, recording(jb.Channel("stroke", gain=(1.1, 0.9))), "gain = (1.1, 0.9): the low bound must be below"),
        (FREE, recording(jb.Channel("stroke", offset="1 s")), "bench: s: offset = '1 s': s is a time"),
        (FREE, recording(jb.Channel("stroke", filter="1 mm")), "bench: s: filter = '1 mm': mm is a length"),
        (FREE, recording(jb.Channel("stroke", delay="1 mm")), "bench: s: delay = '1 mm': mm is a length"),
        (FREE, recording(times=100.0 * TIMES), "bench, row 9: the time 9 s is after the end of the run at 8 s"),
        (FREE, recording(time_shift=(0.0, "3 ms", 1.0)), "time_shift: 1 has no unit"),
    ],
)
def test_a_fit_that_makes_no_sense_is_refused(parameters, test, said):
    with pytest.raises(jb.InputError) as error:
        jb.fit(DESIGN, None, test, parameters)
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("noise", "nois", 'fit.tests[1].columns."stroke [mm]".nois is unknown; did you mean noise?'),
        ("time_shift", "shift", "fit.tests[1].shift is unknown; did you mean time_shift?"),
        ("file =", "files =", "fit.tests[1].files is unknown; did you mean file?"),
        ("buffer.k_A", "buffer.kA", "buffer.kA is unknown; did you mean buffer.k_A?"),
        ("approach_speed", "approch_speed", "did you mean"),
        ('quantity = "stroke", ', "", 'columns."stroke [mm]" names no quantity'),
        ("[[fit.tests]]", "[fit.tests]", "fit.tests is not a list of tables; write each under its own [[fit.tests]]"),
        ("test.csv", "other.csv", "other.csv: no such file"),
        ('"0.02 mm"', '"0.02 s"', "test.csv: stroke [mm]: noise = '0.02 s': s is a time"),
        ("", "", "test.csv, line 3: column"),
    ],
)
def test_what_is_wrong_in_a_study_ends_with_2_and_nothing_is_written(tmp_path, monkeypatch, capsys, old, new, said):
    monkeypatch.chdir(tmp_path)
    cell = "nan" if not old else "2"
    (tmp_path / "test.csv").write_text(f"time [s],stroke [mm]\n0,1\n0.1,{cell}\n0.2,3\n")
    (tmp_path / "study.toml").write_text(STUDY.replace(old, new) if old else STUDY)
    assert run(["fit", "study.toml", "--output", "out"]) == 2
    assert said in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_a_study_without_tests_says_what_is_missing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text("[buffer]\nk_A = 600.0\n")
    assert run(["fit", "study.toml"]) == 2
    assert "fit needs [fit.parameters] in the study" in capsys.readouterr().err


@pytest.mark.parametrize(("residual", "code"), [(3.1, 1), (0.98, 0)])
def test_a_fit_that_does_not_explain_its_test_is_saved_and_ends_with_1(tmp_path, monkeypatch, capsys, residual, code):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "test.csv").write_text("time [s],stroke [mm]\n0,1\n0.1,2\n0.2,3\n")
    (tmp_path / "study.toml").write_text(STUDY)
    doubt = 'column "stroke [mm]": unit or sign?'
    monkeypatch.setattr(fit_command, "compute", lambda *_, **__: made_up_fit(residual=residual, doubtful=(doubt,)))
    assert run(["fit", "study.toml", "--output", "out"]) == code
    assert (tmp_path / "out" / "design.toml").exists()
    error = capsys.readouterr().err
    assert (doubt in error and "does not explain the test" in error) == bool(code)


def test_tests_of_one_name_get_names_that_are_free():
    named = [dataclasses.replace(recording(), name=name) for name in ("a", "a", "a (2)")]
    _, predictions = checked(DESIGN, jb.Scenario(), named, FREE)
    assert [it.recording.name for it in predictions] == ["a (1)", "a (3)", "a (2)"]
