"""Files for MATLAB, read again by SciPy."""

import io

import numpy as np
import pytest
import scipy

import jaxbuffer as jb
from jaxbuffer.output.matlab import _content, _valid, design_mat, run_mat
from made_up import made_up_capture


def read(content):
    return scipy.io.loadmat(io.BytesIO(content), simplify_cells=True)


def test_a_run_has_what_its_labelled_data_have():
    run = made_up_capture()
    data, found = run.to_xarray(), read(run_mat(run))
    assert found["outcome"] == run.outcome.name and found["units"]["peak_force"] == "N"
    for name, array in data.variables.items():
        values = np.squeeze(np.asarray(array))
        if values.dtype.kind in "fi":
            assert np.array_equal(
                np.atleast_1d(np.asarray(found[name], float)), np.atleast_1d(values), equal_nan=True
            ), name
        else:
            assert np.atleast_1d(found[name]).tolist() == np.atleast_1d(values).tolist(), name
    assert found["design"]["buffer"]["k_A"] == run.design.buffer.k_A
    assert found["scenario"]["approach_speed"] == run.scenario.approach_speed


def test_a_design_has_its_sections_curves_and_units():
    design = jb.replace(jb.table2(), {"buffer.damper_curve": [[0.1, 1.0], [0.2, 4.0]]})
    found = read(design_mat(design))
    assert found["design"]["buffer"]["damper_curve"].tolist() == [[0.1, 1.0], [0.2, 4.0]]
    assert np.size(found["design"]["buffer"]["c_A"]) == 0, "what is not set is []"
    assert found["design"]["contact"]["law"] == "lankarani-nikravesh" and found["units"]["probe"]["tip_mass"] == "kg"
    assert found["design"]["probe"]["tip_mass"] == pytest.approx(design.probe.tip_mass, rel=0.0)


def test_the_same_design_gives_the_same_bytes():
    assert design_mat(jb.table2()) == design_mat(jb.table2()) and design_mat(jb.table2())[:10] == b"MATLAB 5.0"


def test_names_that_matlab_cannot_have_are_replaced_and_listed():
    long = "x" * 70
    values = {"länge": 1.0, "lange": 2.0, long: 3.0, long[:65]: 4.0, "end": 5.0, "1st": 6.0, "part": {"höhe": 7.0}}
    read = scipy.io.loadmat(io.BytesIO(_content(values, [])), simplify_cells=True)
    originals = dict(read["original_names"])
    assert read["lange"] == 2.0 and read["part"]["hohe"] == 7.0
    assert all(len(name) <= 63 and name.isascii() and name.isidentifier() for name in originals)
    assert set(originals.values()) == {"länge", long, long[:65], "end", "1st", "höhe"}
    assert {original: read[name] for name, original in originals.items() if name in read} == {
        original: values[original] for original in values if original not in ("lange", "part")
    }


def test_a_quantity_called_like_a_part_of_the_file_hides_nothing():
    renamed = []
    assert _valid({"units": 1.0, "units_2": 2.0}, renamed, taken=("units",)) == {"units_3": 1.0, "units_2": 2.0}
    assert renamed == [("units_3", "units")]
