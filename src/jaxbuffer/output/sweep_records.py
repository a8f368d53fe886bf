"""Sweeps and samples as records, and what a sample's fits are as rows."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..experiments.indices import Indices
from ..experiments.rectangle import SafeRectangle
from ..experiments.sample import Sample
from ..experiments.surface import Surface
from ..labelled.record import Record, amount, headings, part_record
from ..sweeps.columns import RunTable
from ..sweeps.result import Sweep
from ..version import version
from .records import Table


def sweep_record(swept: Sweep, envelope: SafeRectangle | None) -> dict[str, Any]:
    """Return how many runs ended how, and what is safe; the runs themselves are in sweep.nc."""
    # Runs that were given one by one have no grid: their numbers are in sweep.nc.
    places = () if swept.grid is None else swept.grid.axes
    axes = [{**_field(it), "values": np.asarray(it.values).tolist(), "scale": it.scale} for it in places]
    return _of_many(swept, {"axes": axes, "envelope": None if envelope is None else _envelope(envelope)})


def _field(axis: Any) -> dict[str, str]:
    """Return a swept or sampled field: its path, the unit of its numbers, and the one in which people are shown
    them."""
    return {"path": axis.path, "unit": axis.unit, "display_unit": axis.typed or axis.unit}


def _envelope(rectangle: SafeRectangle) -> dict[str, Any]:
    """Return what is asked of a safe run, how many there are, and the largest rectangle of them."""
    ranges = zip(rectangle.axes, (rectangle.first, rectangle.second), strict=True)
    return {
        "criterion": rectangle.criterion,
        "safe_runs": int(rectangle.safe.sum()),
        "runs": int(rectangle.safe.size),
        "done": rectangle.done,
        "runs_in_rectangle": int(rectangle.runs),
        "rectangle": [
            {**_field(axis), "low": float(part[0]), "high": float(part[1])} for axis, part in ranges if part is not None
        ],
        "reasons": dict(Counter(str(reason) for reason in rectangle.reasons[~rectangle.safe])),
        "between": None
        if (between := rectangle.between) is None
        else {
            "runs": between.runs,
            "total_runs": between.total,
            "unsafe_runs": between.unsafe,
            "words": between.words,
        },
    }


def sample_record(sample: Sample, indices: Indices | None, surfaces: Sequence[Surface]) -> dict[str, Any]:
    """Return ranges, how many runs ended how, indices with intervals, surfaces with cross-validated errors."""
    points = sample.grid
    own = {
        "method": points.method,
        "seed": points.seed,
        "ranges": [{**_field(it), "low": it.low, "high": it.high, "scale": it.scale} for it in points.axes],
        "indices": [] if indices is None else _indices(indices),
        "surfaces": [_surface(surface) for surface in surfaces],
    }
    return _of_many(sample, own)


def _indices(indices: Indices) -> list[dict[str, Any]]:
    return [
        {
            "quantity": name,
            "number": path,
            "first_order": amount(it.first[k], "-"),
            "first_order_interval": it.first_interval[:, k].tolist(),
            "total": amount(it.total[k], "-"),
            "total_interval": it.total_interval[:, k].tolist(),
            "confidence": amount(indices.confidence, "-"),
            "rows": it.rows,
            "requested_rows": indices.requested_rows,
            "from": "response surface" if name in indices.surfaces else "runs",
        }
        for name, it in indices.estimates.items()
        for k, path in enumerate(indices.paths)
    ]


def _surface(surface: Surface) -> dict[str, Any]:
    return {
        "quantity": surface.quantity,
        "unit": surface.unit,
        "kind": surface.kind,
        "runs": len(surface.computed),
        "left_out": dict(surface.left_out),
        "trusted": bool(surface.trusted),
        "cross_validated": {
            kind: {name: float(value) for name, value in error._asdict().items()}
            for kind, error in surface.errors.items()
        },
    }


def indices_rows(indices: Indices) -> Table:
    """Return a row for each quantity and number."""
    shares = [f"{kind}{end}" for kind in ("first_order", "total") for end in ("", "_low", "_high")]
    rows: list[Sequence[Any]] = []
    for it in map(Record.of, _indices(indices)):
        numbers = [it["first_order"], *it["first_order_interval"], it["total"], *it["total_interval"]]
        rows.append([it["quantity"], it["number"], *numbers, it["rows"], it["from"]])
    return ["quantity", "number", *headings(dict.fromkeys(shares, "-")), "rows", "from"], rows


def surface_rows(surfaces: Sequence[Surface]) -> Table:
    """Return a row for each run that a surface was fitted to; the prediction is by a fit without that run's fold."""
    return ["quantity", "unit", "computed", "predicted", "kind"], [
        [surface.quantity, surface.unit, x.item(), y.item(), surface.kind]
        for surface in surfaces
        for x, y in zip(surface.computed, surface.predicted, strict=True)
    ]


def _of_many(swept: RunTable, own: dict[str, Any]) -> dict[str, Any]:
    """Return what sweeps and samples have in common around what is their own; of runs given one by one, whose inputs
    sweep.nc has, neither design nor scenario."""
    mechanism, both = swept.mechanism, {}
    outcomes = Counter(mechanism.outcomes(int(code)).name for code in swept.code[swept.done])
    if swept.grid is not None:
        both = {"design": part_record(swept.design), "scenario": part_record(swept.scenario)}
    return {
        "kind": mechanism.name,
        **own,
        "runs": len(swept),
        "done": int(swept.done.sum()),
        "outcomes": dict(outcomes),
        **both,
        "jaxbuffer": version(),
    }
