"""What meshes have at a few instants of a run: a figure, and VTK files where meshio is installed."""

import functools
import importlib.util
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .._types import Axes, Figure, PolyCollection
from ..mechanisms.picture import Meshed
from ..mechanisms.run import Run
from .formats import Contents
from .style import both, panels, styled

WIDTH, HEIGHT = 4.6, 2.8  # inch, of a panel
EMPTY = "#DDDDDD"  # cells that have no value
MARGIN = 0.04  # of what is seen, about it


def field_files(run: Run) -> Contents:
    """Return fields.png and fields.svg; with meshio a .vtu of each instant; nothing for a mechanism without meshes."""
    snapshots = [] if run.history is None else run.mechanism.view.meshes(run)
    if not snapshots:
        return {}
    drawn = both("fields", lambda: fields_figure(snapshots))
    if not _meshio():
        return drawn
    return {**drawn, **{f"{mesh.name}.vtu": functools.partial(vtu, mesh) for mesh in snapshots}}


def left_out(contents: Contents) -> str:
    """Return what is not among a run's files, and why; "" if nothing is."""
    if "fields.png" not in contents or _meshio():
        return ""
    return "no fields.vtu for ParaView: it needs meshio, pip install 'jaxbuffer[mesh]'"


def _meshio() -> bool:
    return importlib.util.find_spec("meshio") is not None


@styled
def fields_figure(snapshots: Sequence[Meshed]) -> Figure:
    """Draw a row for each instant and a column for each value that is not the same everywhere.

    A column's colours mean the same in all rows.
    """
    varies = lambda values: np.nanmax(values) > np.nanmin(values)  # noqa: E731
    names = [name for name in snapshots[0].values if any(varies(mesh.values[name]) for mesh in snapshots)]
    figure, grid = panels(WIDTH * len(names), HEIGHT * len(snapshots), len(snapshots), len(names))
    # One frame for all rows: the mesh keeps its place and scale from instant to instant.
    everything = np.concatenate([mesh.nodes for mesh in snapshots])
    for column, name in enumerate(names):
        values = np.concatenate([mesh.values[name] for mesh in snapshots])
        ends = float(np.nanmin(values)), float(np.nanmax(values))
        for axes, mesh in zip(grid[:, column], snapshots, strict=True):
            drawn = coloured(axes, mesh, name, ends)
            axes.figure.colorbar(drawn, ax=axes, label=name, orientation="horizontal", shrink=0.7, aspect=40)
            axes.set_title(mesh.title)
            frame(axes, everything)
    return figure


def coloured(axes: Axes, mesh: Meshed, name: str, ends: tuple[float, float]) -> PolyCollection:
    """Draw a mesh, its cells coloured by one of its values between two ``ends``."""
    from matplotlib.collections import PolyCollection

    values, corners = mesh.values[name], mesh.nodes[mesh.cells]
    empty = np.isnan(values)
    axes.add_collection(PolyCollection(list(corners[empty]), facecolor=EMPTY, edgecolor="none"))
    # Edges in the cells' own colours close the fine gaps that antialiasing leaves between them.
    drawn = PolyCollection(list(corners[~empty]), array=values[~empty], edgecolor="face", linewidth=0.2)
    drawn.set_clim(*ends)
    axes.add_collection(drawn)
    return drawn


def frame(axes: Axes, nodes: np.ndarray) -> None:
    """Show all of these ``nodes`` [m], true to scale."""
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    room = MARGIN * (high - low)
    axes.set(xlim=(low[0] - room[0], high[0] + room[0]), ylim=(low[1] - room[1], high[1] + room[1]))
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    axes.grid(False)


def vtu(mesh: Meshed) -> bytes:
    """Return a mesh as VTK's unstructured grid."""
    import meshio

    # VTK's points have three coordinates.
    points = np.column_stack([mesh.nodes, np.zeros(len(mesh.nodes))])
    written = meshio.Mesh(points, [("quad", mesh.cells)], cell_data={k: [v] for k, v in mesh.values.items()})
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mesh.vtu"
        written.write(path)
        return path.read_bytes()
