"""What Python computes is saved, loaded and reported as what the commands compute."""

import json

import numpy as np
import pytest

import jaxbuffer as jb
from computed import stand_in
from jaxbuffer.experiments.sample import sample
from jaxbuffer.output.formats import write_all
from jaxbuffer.sweeps.grid import grid
from jaxbuffer.sweeps.result import Sweep
from jaxbuffer.tuning.report.front import Front
from made_up import made_up_capture, made_up_sensitivity, made_up_sweep, made_up_tuning
from pages.report_folders import every_kind

OVER = {"scenario.approach_speed": [0.1, 0.2, 0.3], "buffer.k_A": [100.0, 1000.0]}
RANGES = {"scenario.approach_speed": (0.1, 0.3), "buffer.k_A": (100.0, 1000.0)}
BAR_PROBLEM = jb.Problem(
    jb.BarDrop(), [jb.BarDropScenario()], [jb.Variable("impact.stiffness", 1e10, 1e12)], duration=0.25
)


def problem():
    return jb.Problem(jb.table2(), [jb.Scenario()], [jb.Variable("buffer.k_A", 100.0, 2000.0)])


def swept():
    asked = grid(OVER, jb.table2(), jb.Scenario())
    runs = made_up_sweep(*asked.applied(jb.table2(), jb.Scenario()), {})
    return Sweep(runs.mechanism, runs.columns, jb.table2(), jb.Scenario(), asked)


def sampled():
    with pytest.MonkeyPatch.context() as patched:
        stand_in(patched)
        return sample(jb.table2(), jb.Scenario(), RANGES, 32, progress=lambda done, count: None)


def front():
    points = tuple(made_up_tuning(problem()) for _ in range(2))
    return Front(problem(), ("peak_force", "stroke"), np.full((2, 1), np.inf), points)


MADE = {
    "run": made_up_capture,
    "sensitivity": made_up_sensitivity,
    "sweep": swept,
    "sample": sampled,
    "tuned": lambda: made_up_tuning(problem()),
    "front": front,
}


@pytest.fixture(scope="module")
def of_commands(tmp_path_factory):
    """Folders that the commands made, to compare with."""
    small = {".png": b"\x89PNG", ".svg": b"<svg/>"}
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(
            "jaxbuffer.output.style.both",
            lambda name, draw: {f"{name}{ending}": (lambda it=it: it) for ending, it in small.items()},
        )
        return every_kind(tmp_path_factory.mktemp("commands"))


@pytest.mark.parametrize("kind", MADE)
def test_a_result_is_saved_loaded_and_reported(kind, of_commands, no_figures, tmp_path):
    result = MADE[kind]()
    with pytest.MonkeyPatch.context() as patched:
        stand_in(patched)
        written = result.save(tmp_path / "out")
    names = {path.name for path in written}
    assert names == {path.name for path in (tmp_path / "out").iterdir()}
    extra = {"indices", "surface", "envelope"}  # what the commands compute beside them
    assert names == {path.name for path in of_commands[kind].iterdir() if path.stem not in extra}
    found = jb.load(tmp_path / "out")
    one, two = found.records[kind], jb.load(of_commands[kind]).records[kind]
    assert one.keys() == two.keys() and one["made"]["command"] == "in Python"
    assert found.design is not None
    page = jb.report(tmp_path / "out", to=tmp_path / "page.html", title="Saved from Python")
    assert page == tmp_path / "page.html" and "Saved from Python" in page.read_text()


def test_nothing_is_overwritten_unasked(tmp_path):
    result = made_up_sensitivity()
    first = result.save(tmp_path)
    first[0].write_text("mine")
    with pytest.raises(jb.InputError, match=r"and 3 more exist; force=True overwrites, another folder keeps them"):
        jb.save(result, tmp_path)
    assert first[0].read_text() == "mine"
    jb.save(result, tmp_path, force=True)
    assert first[0].read_text() != "mine"
    assert not list(tmp_path.glob(".*")), "no lock is left"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda place: jb.save(3.0, place), "expected a result of simulate, .* found a float"),
        (lambda place: made_up_capture(outcome=jb.Outcome.failed_steps).save(place), "the capture failed, "),
        (lambda place: made_up_sensitivity().save(place / "a.json"), "has the ending of a file and names a folder"),
        (lambda place: jb.report(), "report needs a folder of results"),
        (jb.report, "holds no results of simulate"),
    ],
)
def test_bad_calls_are_one_line_and_leave_nothing(call, message, tmp_path):
    with pytest.raises(jb.InputError, match=message) as error:
        call(tmp_path)
    assert "\n" not in str(error.value) and not list(tmp_path.iterdir())


@pytest.mark.parametrize("place", [100, 500, -200])
def test_a_flipped_bit_in_labelled_data_is_found(place, tmp_path):
    swept().save(tmp_path, figures=False)
    file = tmp_path / "sweep.nc"
    content = bytearray(file.read_bytes())
    content[place] ^= 1
    file.write_bytes(content)
    with pytest.raises(jb.InputError, match=r"sweep\.nc is damaged or no result of jaxbuffer: its checksum"):
        jb.load(tmp_path)


def test_a_result_is_told_once_its_numbers_are_on_disk(tmp_path):
    """Before the files that take a while: other forms of the numbers, and figures."""
    order = []
    names = ("a.png", "a.nc", "a.json", "a.mat", "a.csv")
    contents = {name: lambda name=name: order.append(name) or "content" for name in names}
    written, failure = write_all(tmp_path, contents, False, written_so_far=lambda done: order.append("told"))
    assert failure is None and order == ["a.json", "a.csv", "told", "a.nc", "a.mat", "a.png"]
    assert [path.name for path in written] == ["a.json", "a.csv", "a.nc", "a.mat", "a.png"]


def test_a_page_replaces_no_other_file(tmp_path):
    made_up_sensitivity().save(tmp_path)
    (tmp_path / "mine.html").write_text("mine")
    with pytest.raises(jb.InputError, match=r"mine\.html exists and is no page of jaxbuffer's; choose another file"):
        jb.report(tmp_path, to=tmp_path / "mine.html")
    assert jb.report(tmp_path) == jb.report(tmp_path) == tmp_path / "report.html"


def test_what_was_computed_beside_it_is_saved_too(no_figures, tmp_path):
    drawn = sampled()
    surface = jb.response_surface(drawn, "peak_force")
    jb.save(drawn, tmp_path, surfaces=[surface])
    assert json.loads((tmp_path / "sample.json").read_text())["surfaces"][0]["quantity"] == "peak_force"
    assert repr(surface) in (tmp_path / "sample.txt").read_text()


@pytest.mark.parametrize(
    ("compute", "file"),
    [
        (
            lambda place: jb.sweep(jb.BarDrop(), jb.BarDropScenario(height=[0.1, 0.15]), 0.22, folder=place),
            "sweep.json",
        ),
        (
            lambda place: jb.sweep(
                jb.BarDrop(), jb.BarDropScenario(), 0.22, over={"scenario.height": [0.1, 0.15]}, folder=place
            ),
            "sweep.json",
        ),
        (
            lambda place: jb.sample(
                jb.BarDrop(), jb.BarDropScenario(), {"scenario.height": (0.1, 0.2)}, 4, duration=0.22, folder=place
            ),
            "sample.json",
        ),
        (lambda place: jb.tune(BAR_PROBLEM, starts=1, iterations=2, folder=place), "tuned.json"),
        (
            lambda place: jb.pareto(
                BAR_PROBLEM, ["peak_force", "penetration"], points=2, starts=1, iterations=2, folder=place
            ),
            "pareto.json",
        ),
    ],
    ids=["sweep", "grid", "sample", "tune", "pareto"],
)
@pytest.mark.slow
def test_what_is_computed_in_a_folder_is_a_result_there(compute, file, tmp_path):
    compute(tmp_path)
    assert (tmp_path / file).is_file() and not list(tmp_path.glob("*.png"))
    found = jb.load(tmp_path)
    assert found.mechanism.name == "bar_drop"
    assert "Nothing is recorded" not in jb.report(tmp_path).read_text()
