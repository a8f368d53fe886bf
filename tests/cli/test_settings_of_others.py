"""Paths that are no UTF-8, and matplotlib's settings of the user: nothing that was computed is lost by them."""

import json
import os
import subprocess
import sys

import matplotlib
import pytest
from test_lost_work import FILES

import jaxbuffer as jb
from in_short import quick
from jaxbuffer.cli.entry import run

LATIN = os.fsdecode(b"Messger\xe4t")  # as another system wrote it


@pytest.mark.parametrize("command", quick(FILES, "simulate", "sweep"))
def test_a_path_that_is_no_utf_8_loses_nothing(computed, no_figures, tmp_path, command):
    study = tmp_path / f"{LATIN}.toml"
    study.write_text("[scenario]\napproach_speed = 0.1\n")  # m/s
    over = ["--over", "scenario.approach_speed=0.1,0.2", "--over", "scenario.misalignment=0,0.01"]
    words = [command, study.name, *(over if command == "sweep" else []), "--output", f"{LATIN}/out"]
    assert run(words) == 0
    assert {file.name for file in (tmp_path / LATIN / "out").iterdir()} >= FILES[command]
    records = [json.loads(file.read_text(encoding="utf-8")) for file in (tmp_path / LATIN / "out").glob("*.json")]
    commands = [record["made"]["command"] for record in records if "made" in record]
    assert commands and all(LATIN in it for it in commands), "and the record has the very path"


@pytest.mark.parametrize("command", quick(["report", "compare"], "report"))
def test_a_page_of_such_a_folder(computed, no_figures, tmp_path, command):
    for number in (1, 2):
        assert run(["simulate", "--output", f"{LATIN}/{number}"]) == 0
    assert run([command, f"{LATIN}/1", f"{LATIN}/2", "--html", f"{LATIN}.html"]) == 0
    assert (tmp_path / f"{LATIN}.html").read_bytes().decode().lower().startswith("<!doctype html>")


SETTINGS = {"text.usetex": True, "axes.facecolor": "black", "text.color": "white", "font.size": 31.0, "savefig.dpi": 9,
            "savefig.bbox": "tight", "lines.linewidth": 9.0, "svg.fonttype": "none", "axes.grid": False}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("command", quick(["simulate", "tune"], "simulate"))
def test_figures_look_alike_whatever_the_user_s_matplotlibrc_says(computed, tmp_path, command):
    """By the bytes of PNG and SVG."""
    assert run([command, "--output", "plain", "--format", "both"]) == 0
    with matplotlib.rc_context(SETTINGS):
        before = dict(matplotlib.rcParams)
        assert run([command, "--output", "styled", "--format", "both"]) == 0
        assert dict(matplotlib.rcParams) == before, "and they are left as they were"
    names = [file.name for file in (tmp_path / "plain").iterdir() if file.suffix in (".png", ".svg")]
    assert names
    for name in names:
        assert (tmp_path / "styled" / name).read_bytes() == (tmp_path / "plain" / name).read_bytes(), name


@pytest.mark.parametrize(
    "error",
    [RuntimeError("latex was not able to process\nthe string"), pytest.param(MemoryError(), marks=pytest.mark.slow)],
)
def test_a_figure_that_fails_is_one_line_after_all_data(computed, monkeypatch, capsys, tmp_path, error):
    def fails(*_):
        raise error

    monkeypatch.setattr("jaxbuffer.output.run_files.run_figure", fails)
    assert run(["simulate", "--output", "out"]) == 3
    assert {file.name for file in (tmp_path / "out").iterdir()} == FILES["simulate"] - {"capture.png"}
    shown = capsys.readouterr()
    last = shown.err.strip().splitlines()[-1]
    assert last.startswith(f"error: out/capture.png: cannot be drawn, {type(error).__name__}")
    assert "captured" in shown.out and "Traceback" not in shown.err


@pytest.mark.slow
@pytest.mark.parametrize(
    ("chosen", "endings"),
    [("svg", {".svg"}), pytest.param("both", {".png", ".svg"}, marks=pytest.mark.slow), ("none", set())],
)
def test_figures_come_in_the_format_that_is_asked_for(computed, tmp_path, chosen, endings):
    """And one of an earlier format does not stay, since a page would show it."""
    assert run(["simulate", "--output", "out"]) == 0
    assert run(["simulate", "--output", "out", "--format", chosen, "--force"]) == 0
    drawn = {file.suffix for file in (tmp_path / "out").iterdir() if file.stem in ("capture", "motion")}
    assert drawn & {".png", ".svg"} == endings


def test_an_unknown_format_is_refused_before_anything_is_computed(computed, capsys, tmp_path):
    assert run(["simulate", "--output", "out", "--format", "pdf"]) == 2
    assert "--format = 'pdf' is unknown; choose one of png, svg, both, none" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_figures_are_saved_last(computed, tmp_path):
    """What a kill then costs is pictures."""
    assert run(["simulate", "--output", "out"]) == 0
    files = sorted((tmp_path / "out").iterdir(), key=lambda file: file.stat().st_mtime_ns)
    drawn = [file.suffix in (".png", ".svg") for file in files]
    assert drawn == sorted(drawn)


PICTURE = """
import os, sys
from jaxbuffer.output.style import panels, png, require_matplotlib, styled
require_matplotlib()
picture = png(styled(lambda: panels(2.0, 1.0, 1, 1)[0])())
assert os.environ.get("MPLBACKEND") == {backend!r}
sys.stdout.buffer.write(picture)
"""


@pytest.mark.slow
def test_an_unknown_backend_changes_no_picture(tmp_path):
    def picture(backend):
        words = [sys.executable, "-c", PICTURE.format(backend=backend)]
        given = {**os.environ, "MPLBACKEND": backend}
        return subprocess.run(words, check=True, capture_output=True, env=given, cwd=tmp_path, timeout=120).stdout

    assert picture("nonsense") == picture("agg")


def test_a_matplotlibrc_that_cannot_be_read_is_said_before_anything_is_computed(tmp_path):
    (tmp_path / "matplotlibrc").write_bytes(b"\xff\xfe")
    words = [sys.executable, "-m", "jaxbuffer", "simulate", "--output", "out"]
    found = subprocess.run(words, check=False, capture_output=True, text=True, cwd=tmp_path, timeout=120)
    assert found.returncode == 2 and "figures need matplotlib, which cannot be imported here: " in found.stderr
    assert "Traceback (most recent call last)" not in found.stderr.splitlines()[-1]


@pytest.mark.slow
def test_a_picture_in_python_is_drawn_in_our_style(tmp_path):
    with matplotlib.rc_context(SETTINGS):
        figure = jb.draw(jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.01), 0.06, history=True))
    assert not any(text.get_usetex() for axes in figure.axes for text in axes.texts)
