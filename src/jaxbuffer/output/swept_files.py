"""The files of a sweep and of a sample: names, and what makes their contents."""

from collections.abc import Sequence

from ..experiments.indices import Indices
from ..experiments.rectangle import SafeRectangle
from ..experiments.sample import Sample
from ..experiments.surface import Surface
from ..labelled.netcdf import content
from ..sweeps.columns import RunTable
from ..sweeps.result import Sweep
from ..sweeps.table import sweep_rows
from . import style, sweep_records
from .envelope_figure import envelope_figure
from .formats import Contents, Made, Writers, csv_text, table_json
from .provenance import record_text
from .sample_figures import indices_figure, sample_figure, surfaces_figure
from .sweep_figures import sweep_figure


def swept_json(swept: RunTable) -> str:
    """Return a sweep or a sample as JSON: its table, a record for each run."""
    return table_json("runs", *sweep_rows(swept))


def swept_files(swept: Sweep, made: Made = None, envelope: SafeRectangle | None = None) -> Contents:
    """Return the files of `jaxbuffer sweep`.

    **Arguments:** ``made``: how it came about; ``envelope``: what is safe of a sweep over two fields.
    """
    files: Writers = {
        "sweep.csv": lambda: csv_text(*sweep_rows(swept)),
        "sweep.txt": lambda: "".join(f"{it!r}\n" for it in (swept, envelope) if it is not None),
        "sweep.nc": lambda: content(swept.to_xarray()),
        "sweep.json": lambda: record_text(sweep_records.sweep_record(swept, envelope), made),
    }
    if swept.grid is not None:
        files |= style.both("sweep", lambda: sweep_figure(swept))
    if envelope is not None:
        files |= style.both("envelope", lambda: envelope_figure(envelope))
    return files


def sample_files(
    sample: Sample, made: Made = None, indices: Indices | None = None, surfaces: Sequence[Surface] = ()
) -> Contents:
    """Return the files of `jaxbuffer sample`.

    **Arguments:** ``made``: how it came about; ``indices``, ``surfaces``: what was computed from the sample.
    """
    files: Writers = {
        "sample.csv": lambda: csv_text(*sweep_rows(sample)),
        "sample.json": lambda: record_text(sweep_records.sample_record(sample, indices, surfaces), made),
        "sample.txt": lambda: f"{sample_text(sample, indices, surfaces)}\n",
        "sample.nc": lambda: content(sample.to_xarray()),
        **style.both("sample", lambda: sample_figure(sample)),
    }
    if indices is not None:
        files["indices.csv"] = lambda: csv_text(*sweep_records.indices_rows(indices))
        files |= style.both("indices", lambda: indices_figure(indices))
    if surfaces:
        files["surface.csv"] = lambda: csv_text(*sweep_records.surface_rows(surfaces))
        files |= style.both("surface", lambda: surfaces_figure(surfaces))
    return files


def sample_text(sample: Sample, indices: Indices | None, surfaces: Sequence[Surface]) -> str:
    """Return the summaries of a sample and of what was computed from it."""
    return "\n\n".join(map(repr, [sample, *([] if indices is None else [indices]), *surfaces]))
