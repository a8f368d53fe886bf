"""What meshes have at instants of a run, as a figure and as VTK."""

import meshio
import numpy as np

from jaxbuffer.mechanisms.picture import Meshed
from jaxbuffer.output import field_files
from jaxbuffer.output.field_files import fields_figure, vtu

NODES = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0]])
CELLS = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
MESH = Meshed(
    "end, 1 ms",
    "fields_end",
    NODES,
    CELLS,
    {"stress [MPa]": np.array([1.0, 3.0]), "strain [-]": np.zeros(2), "pressure [kPa]": np.array([np.nan, 2.0])},
)


def test_a_value_that_is_the_same_everywhere_is_not_drawn():
    figure = fields_figure([MESH, MESH])
    titles = [axes.get_title(loc="left") for axes in figure.axes if axes.get_title(loc="left")]
    labels = [axes.get_xlabel() for axes in figure.axes]
    assert titles == ["end, 1 ms"] * 2 and labels.count("stress [MPa]") == 2
    assert not any(label.startswith(("strain", "pressure")) for label in labels)


def test_a_run_without_meshes_has_no_such_files():
    class Plain:
        history = object()

        class mechanism:
            class view:
                meshes = staticmethod(lambda run: [])

    assert field_files.field_files(Plain()) == {}


def test_what_a_missing_package_leaves_out_is_said(monkeypatch):
    monkeypatch.setattr(field_files, "_meshio", lambda: False)
    assert "pip install 'jaxbuffer[mesh]'" in field_files.left_out({"fields.png": bytes})
    assert field_files.left_out({"capture.png": bytes}) == ""


def test_vtk_has_the_cells_and_their_values(tmp_path):
    (tmp_path / "mesh.vtu").write_bytes(vtu(MESH))
    found = meshio.read(tmp_path / "mesh.vtu")
    assert np.array_equal(found.points[:, :2], NODES) and np.array_equal(found.cells[0].data, CELLS)
    for name, values in MESH.values.items():
        assert np.array_equal(found.cell_data[name][0], values, equal_nan=True)
