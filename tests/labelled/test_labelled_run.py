"""A run of any mechanism as labelled arrays, against the run itself and the independent numbers of the bar drop."""

import json

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.labelled.netcdf import content, read
from jaxbuffer.labelled.record import amount, part_from_json

PEAK, CONTACT = 1831.464, 0.2114478  # N, s: the bar drop's peak of mechanisms.md, section 1, by SciPy


@pytest.fixture(scope="module")
def drop():
    return jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.22, history=True)


def test_quantities_and_impacts_carry_units(drop, evidence):
    data = drop.to_xarray()
    error = abs(float(data.peak_force) / PEAK - 1.0)
    source = "SciPy, minimal coordinates, located events"
    evidence("labelled data", "peak force of the dropped bar in its dataset", error, 1e-6, source, "-")
    evidence("labelled data", "time of that peak", abs(float(data.peak_time) - CONTACT), 1e-7, source, "s")
    for name in drop.mechanism.swept:
        assert data[name].units == drop.mechanism.quantities[name].unit and data[name].long_name, name
    assert data.sizes["impact"] == int(drop.impacts.count) < drop.impacts.time.size
    assert data.impact_contact.values.tolist() == ["plate"] * data.sizes["impact"]
    assert (data.impact_time.units, data.impact_approach_speed.units, data.impact_peak_force.units) == ("s", "m/s", "N")
    assert data.attrs["kind"] == "bar_drop" and data.attrs["outcome"] == "finished" and data.attrs["jaxbuffer"]


def test_the_history_lies_along_steps_with_bodies_and_contacts_by_name(drop):
    data = drop.to_xarray()
    assert data.time.dims == ("step",) and data.time.units == "s" and data.sizes["step"] == int(drop.accepted)
    force = data.contact_force.sel(contact="plate")
    np.testing.assert_array_equal(force, np.asarray(drop.history.contact_force)[:, 0])
    angle = data.position_angle.sel(body="bar")
    np.testing.assert_array_equal(angle, np.asarray(drop.history.position)[:, 0, 2])
    assert angle.units == "rad" and float(angle[0]) == pytest.approx(np.arcsin(0.194 / 0.24), rel=1e-12)
    total = data.energy_history.sel(energy="total")
    assert float(abs(total - total[0]).max()) < 1e-6 and total.units == "J"
    assert float(data.energy_at_end.sel(energy="total")) == pytest.approx(float(total[-1]), rel=1e-9)
    assert set(drop.history.others) == {name.removesuffix("_history") for name in data if name.endswith("_history")} - {
        "energy"
    }


def test_the_table_is_that_of_the_file(drop):
    table = drop.to_dataframe()
    assert len(table) == int(drop.accepted) and "contact_force plate [N]" in table and "energy total [J]" in table
    np.testing.assert_array_equal(table["time [s]"], np.asarray(drop.history.time))


@pytest.mark.slow
def test_without_a_history_there_are_no_steps(drop):
    short = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.01)
    data = short.to_xarray()
    assert "step" not in data.dims and data.sizes["impact"] == 0 and data.impact_contact.size == 0
    assert read_back(data).identical(data), "without impacts too"
    with pytest.raises(jb.InputError, match=r"the run has no history; jb\.simulate"):
        short.to_dataframe()


def read_back(data, folder=None):
    import tempfile
    from pathlib import Path

    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / "run.nc"
        file.write_bytes(content(data))
        return read(file)


def test_a_file_holds_the_same_and_stands_on_its_own(drop):
    data = drop.to_xarray()
    assert content(data) == content(data), "the same bytes each time"
    back = read_back(data)
    assert back.identical(data)
    assert part_from_json(jb.BarDrop(), back.attrs["design"]) == drop_design()
    assert json.loads(back.attrs["scenario"]) == {"height": amount(0.194, "m"), "gravity": amount(9.81, "m/s²")}


def drop_design():
    return jb.BarDrop()


def test_a_batch_is_refused(drop):
    import jax

    runs = jax.tree.map(lambda one: np.stack([one, one]), drop)  # as from jax.vmap
    with pytest.raises(jb.InputError, match="takes one run that is solved"):
        runs.to_xarray()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("design", "scenario", "duration"),
    [(jb.table2, jb.Scenario, 1.0), (jb.SliderCrank, jb.SliderCrankScenario, 0.003)],
)
def test_every_mechanism_has_labelled_runs(design, scenario, duration):
    run = jb.simulate(design(), scenario(), duration, history=True)
    data = run.to_xarray()
    names = run.mechanism.view.names(run.design)
    assert tuple(data.body.values) == names.bodies and tuple(data.contact.values) == names.contacts
    assert data.sizes["impact"] == int(run.impact_count) > 0
    assert read_back(data).identical(data)
    assert part_from_json(design(), data.attrs["design"]) == run.design
    assert "<table>" in run._repr_html_() and len(run.to_dataframe()) == data.sizes["step"]
