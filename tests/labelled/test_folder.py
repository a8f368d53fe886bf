"""`jb.load`, `load_design` and `save_design`: what is written is read back, and damage is told in a line."""

import jax
import pytest

import jaxbuffer as jb
from computed import stand_in
from jaxbuffer.cli.entry import run
from jaxbuffer.labelled.record import Record
from made_up import made_up_capture


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Of commands whose results are made up."""
    place = tmp_path_factory.mktemp("results")
    (place / "study.toml").write_text("[scenario]\napproach_speed = 0.15\n[buffer]\nc_A = 7.0\n")
    study, out = str(place / "study.toml"), ["--output", str(place / "out"), "--format", "none"]
    with pytest.MonkeyPatch.context() as patched:
        stand_in(patched)
        assert run(["simulate", study, *out]) == 0
        assert run(["sensitivity", study, "--wrt", "buffer.c_A", *out]) == 0
    return place / "out"


def test_a_folder_as_one_object(folder):
    found = jb.load(folder)
    assert found.run.attrs["kind"] == "probe_cone" and found.run.sizes["step"] > 10
    assert found.sweep is None and found.tuned is None
    assert found.sensitivity == Record.from_json((folder / "sensitivity.json").read_text())
    assert found.design == jb.replace(jb.table2(), {"buffer.c_A": 7.0})
    made = made_up_capture(jb.Scenario(approach_speed=0.15), design=found.design)
    assert float(found.run.peak_force) == float(made.peak_force) == found.sensitivity["peak_force"]
    shown = repr(found)
    assert "captured; " in shown and "derivatives" in shown and "tuned" not in shown
    assert "<table>" in found._repr_html_()


def test_nothing_there(tmp_path):
    with pytest.raises(jb.InputError, match="no such folder"):
        jb.load(tmp_path / "none")
    with pytest.raises(
        jb.InputError, match="results of simulate, sensitivity, sweep, tune, sample, pareto, choose or fit"
    ):
        jb.load(tmp_path)


@pytest.mark.parametrize(
    ("name", "damage"),
    [
        ("drop.nc", b""),
        ("drop.nc", b"not one"),
        ("drop.nc", None),  # cut in half
        ("sweep.nc", b"\x89HDF\r\n\x1a\n"),
        ("tuned.json", b"{"),
        ("sensitivity.json", b"\xff\xfe"),
        ("sensitivity.json", b"[]"),
    ],
)
def test_damaged_files_are_named(folder, tmp_path, name, damage):
    half = (folder / "capture.nc").read_bytes()
    (tmp_path / name).write_bytes(half[: len(half) // 2] if damage is None else damage)
    with pytest.raises(jb.InputError, match=rf"{name} is (damaged|not a sweep's result)") as error:
        jb.load(tmp_path)
    assert "\n" not in str(error.value)


def test_two_runs_in_a_folder(folder, tmp_path):
    for name in ("drop.nc", "capture.nc"):
        (tmp_path / name).write_bytes((folder / "capture.nc").read_bytes())
    with pytest.raises(jb.InputError, match=r"holds several runs, capture\.nc, drop\.nc; keep one in a folder"):
        jb.load(tmp_path)


@pytest.mark.parametrize("kind", [jb.table2, jb.BarDrop, jb.SliderCrank])
def test_designs_make_the_round_trip_exactly(kind, tmp_path):
    design, file = kind(), tmp_path / "design.toml"
    number = next(path for path in jb.paths(design) if isinstance(jb.get(design, path), float))
    design = jb.replace(design, {number: jb.get(design, number) * (1.0 + 1e-15)})
    default = jb.load_design(save(file, design))[1][0]
    field = next(jb.paths(default))
    scenarios = tuple(jb.replace(default, {field: factor * jb.get(default, field) / 3.0}) for factor in (1.0, 2.0))
    jb.save_design(file, design, scenarios, "two scenarios", overwrite=True)
    assert jb.load_design(file) == (design, scenarios)
    assert file.read_text().startswith("# two scenarios\n")


def save(file, design):
    jb.save_design(file, design)
    return file


def test_a_design_is_not_overwritten_unasked(tmp_path):
    save(tmp_path / "design.toml", jb.table2())
    with pytest.raises(jb.InputError, match=r"design\.toml exists; overwrite=True replaces it"):
        save(tmp_path / "design.toml", jb.BarDrop())
    assert jb.load_design(tmp_path / "design.toml")[0] == jb.table2()


def test_what_is_no_single_design_is_refused(tmp_path):
    many = jb.replace(jb.table2(), {"buffer.k_A": [1.0, 2.0]})
    with pytest.raises(jb.InputError, match=r"buffer.k_A has shape \(2,\).*a file of its own"):
        jb.save_design(tmp_path / "many.toml", many)
    with pytest.raises(jb.InputError, match="is not a BarDropScenario"):
        jb.save_design(tmp_path / "other.toml", jb.BarDrop(), [jb.Scenario()])
    assert not list(tmp_path.iterdir())


def test_arrays_of_one_number_are_saved_as_numbers(tmp_path):
    design = jax.tree.map(jax.numpy.asarray, jb.replace(jb.BarDrop(), {"bar.length": 0.48}))
    jb.save_design(tmp_path / "design.toml", design)
    assert jb.get(jb.load_design(tmp_path / "design.toml")[0], "bar.length") == 0.48
