"""A sample's files: runs, indices and surfaces as tables and figures."""

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from .formats import Contents, Made, csv_text, json_text

if TYPE_CHECKING:
    from ..experiments.indices import Indices
    from ..experiments.sample import Sample
    from ..experiments.surface import Surface

SAMPLE = ("sample.csv", "sample.png", "sample.txt", "sample.nc", "sample.json")
INDICES = ("indices.csv", "indices.png")
SURFACE = ("surface.csv", "surface.png")


@dataclasses.dataclass
class Told:
    """What was read off a sample: its ``indices``, if they were asked for, and ``surfaces``."""

    indices: "Indices | None" = None
    surfaces: "list[Surface]" = dataclasses.field(default_factory=list)


def sample_files(sample: "Sample", told: Told | None = None, text: str = "", made: Made = None) -> Contents:
    """Of `jaxbuffer sample`. ``told``: what was read off it; ``text``: the summary, the sample's own by default;
    ``made``: how it came about."""
    from ..labelled.netcdf import content
    from ..sweeps.table import sweep_rows
    from .experiment_records import sample_record
    from .sample_figures import indices_figure, sample_figure, surfaces_figure
    from .style import both

    told = Told() if told is None else told
    files: dict[str, Callable[[], str | bytes]] = {
        "sample.csv": lambda: csv_text(*sweep_rows(sample)),
        "sample.json": lambda: json_text(sample_record(sample, told.indices, told.surfaces, made)),
        "sample.txt": lambda: f"{text or repr(sample)}\n",
        **both("sample", lambda: sample_figure(sample)),
        "sample.nc": lambda: content(sample.to_xarray()),
    }
    indices, surfaces = told.indices, told.surfaces
    if indices is not None:
        files["indices.csv"] = lambda: csv_text(*indices_rows(indices))
        files |= both("indices", lambda: indices_figure(indices))
    if surfaces:
        files["surface.csv"] = lambda: csv_text(*surface_rows(surfaces))
        files |= both("surface", lambda: surfaces_figure(surfaces))
    return files


def indices_rows(indices: "Indices") -> tuple[list[str], Iterator[Sequence[Any]]]:
    """A row for each quantity and number."""
    header = ["quantity", "number", "first_order [-]", "first_order_low [-]", "first_order_high [-]"]
    header += ["total [-]", "total_low [-]", "total_high [-]", "rows", "from"]
    return header, (
        [
            *(name, path, it.first[k], *it.first_interval[:, k], it.total[k], *it.total_interval[:, k], it.rows),
            "response surface" if name in indices.surfaces else "runs",
        ]
        for name, it in indices.estimates.items()
        for k, path in enumerate(indices.paths)
    )


def surface_rows(surfaces: "Sequence[Surface]") -> tuple[list[str], Iterator[Sequence[Any]]]:
    """A row for each run that a surface was fitted to; the prediction is by a fit without that run's fold."""
    return ["quantity", "unit", "computed", "predicted", "kind"], (
        [surface.quantity, surface.unit, x.item(), y.item(), surface.kind]
        for surface in surfaces
        for x, y in zip(surface.computed, surface.predicted, strict=True)
    )
