"""Sized dockings are held as wished, from 4 kg to 420 t: closed forms against runs."""

import pytest

import jaxbuffer as jb
from jaxbuffer.cli.entry import run
from jaxbuffer.run.sized import Sized
from jaxbuffer.study.load import load
from vehicles import VEHICLES, written


@pytest.mark.slow
@pytest.mark.parametrize("name", VEHICLES)
def test_closed_forms_are_what_runs_do(name, tmp_path):
    given = load(str(written(tmp_path, *VEHICLES[name])))
    scenarios = [case.scenario for case in given.cases]
    sized = jb.size(given.design, scenarios, given.options.duration, stroke=given.table.constraints.at_most["stroke"])
    assert sized.missed == []
    found = {it: sized.confirmed[it].value / sized.parts.estimates[it].value for it in sized.confirmed}
    # The fastest approach stops on the buffer as one mass does: within 4 %, impacts of the light tip on top.
    assert found["peak_buffer_force"] == pytest.approx(1.0, abs=0.04)
    assert found["peak_latch_force"] == pytest.approx(1.0, abs=0.15)
    # Bounds: the tip comes nearer while the latch closes, and goes on while the buffer is pushed in.
    assert 0.2 < found["latch_energy_share"] < 1.0 and 0.3 < found["stroke"] < 1.0
    assert 0.7 < found["settling_time"] < 1.0
    assert "not simulated" not in repr(sized)
    few = Sized(sized.parts, sized.runs, sized.duration, 20)
    assert "16 of the 20 scenarios were not simulated" in " ".join(repr(few).split())


@pytest.mark.slow
def test_the_command_sizes_a_study_and_says_what_stands_in_the_way(tmp_path, capsys):
    file = written(tmp_path, *VEHICLES["20 kg"])
    out = tmp_path / "out"
    assert run(["size", str(file), "--output", str(out)]) == 0
    assert {it.name for it in out.iterdir()} == {"design.toml", "size.json", "size.png", "size.txt"}
    sized = load(str(out / "design.toml"))
    assert sized.design.buffer.max_stroke == 0.025 and sized.problem().limits.held
    assert run(["simulate", str(out / "design.toml"), "--scenario-number", "1", "--trust", "off"]) == 0
    capsys.readouterr()
    assert run(["size", str(file), "--settling-time", "1 s", "--format", "none"]) == 1
    shown = capsys.readouterr()
    assert "latch_energy_share keeps the latch soft" in shown.out and "not as wished: settling_time" in shown.err


def test_bounds_of_a_tuning_hold_what_was_sized(tmp_path):
    from jaxbuffer.study.sized_toml import sized_toml

    given = load(str(written(tmp_path, *VEHICLES["20 kg"])))
    design = jb.replace(given.design, {"latch.stiffness": 1.0, "buffer.k_A": 1e5})
    again = tmp_path / "again.toml"
    again.write_text(sized_toml(given, design, 30.0, "sized"), encoding="utf-8")
    read = load(str(again)).problem()
    bounds = {it.path: (it.low, it.high) for it in read.variables}
    assert bounds["latch.stiffness"][0] <= 1.0 and bounds["buffer.k_A"][1] >= 1e5
    assert read.design == design and read.duration == 30.0


def test_one_design_is_sized(tmp_path, capsys):
    (tmp_path / "study.toml").write_text('[problem.grid]\n"active.mass" = [20.0, 22.0]\n', encoding="utf-8")
    assert run(["size", str(tmp_path / "study.toml")]) == 2
    assert "[problem.grid] lists values of active.mass" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--stroke", "2 s"], "size.stroke"),
        (["--latch-energy-share", "120"], "size.latch_energy_share"),
        (["--stroke", "1"], "buffer.free_length"),
    ],
)
def test_bad_wishes_are_one_line(words, said, tmp_path, capsys):
    file = written(tmp_path, *VEHICLES["20 kg"])
    capsys.readouterr()
    assert run(["size", str(file), *words]) == 2
    err = capsys.readouterr().err
    assert said in err and err.count("\n") == 1
