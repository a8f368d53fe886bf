"""The slider-crank on the command line: a run's files, and what is refused."""

import pytest

from jaxbuffer.cli.entry import run as command


def test_the_command_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "crank.toml").write_text('kind = "slider_crank"\n[crank_pin]\njoint = "clearance"\n')
    assert command(["simulate", "crank.toml", "--slider.mass", "0.2", "--output", "out"]) == 0
    shown = capsys.readouterr()
    assert "share of contact" in shown.out and "impacts can be trusted one by one" in shown.err
    assert (tmp_path / "out" / "run.png").stat().st_size > 1000
    header = (tmp_path / "out" / "history.csv").read_text().splitlines()[0]
    assert "contact_force piston [N]" in header and "gap crank [m]" in header and "drive_torque [N m]" in header


@pytest.mark.quick
@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--crank.length", "0.2"], "rod.length must be above crank.length"),
        (["--piston_pin.clearance", "0.02"], "piston_pin.clearance must be below piston_pin.bush_radius"),
        (["--scenario.crank_speed", "0"], "keeps it so, and nothing moves"),
        (["--piston_pin.law", "jonson"], "piston_pin.law = 'jonson'"),
        (["--piston_pin.exponent", "0.5"], "only piston_pin.law = 'adams'"),
        (["--piston_pin.law", "liu", "--piston_pin.stiffness", "1e9"], "takes its stiffness from the materials"),
        (["--drive.torque", "-1"], "drive.torque = -1 N m is out of range"),
        (["--pistn_pin.law", "liu"], "pistn_pin.law is unknown"),
    ],
)
def test_bad_input(tmp_path, monkeypatch, capsys, words, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "crank.toml").write_text('kind = "slider_crank"\n')
    assert command(["simulate", "crank.toml", *words]) == 2
    assert message in capsys.readouterr().err
