"""Sweeps, samples and fronts as records: what can be read off their runs, each number with its unit."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..fields.record import record
from ..version import version
from .formats import Made
from .provenance import MADE

if TYPE_CHECKING:
    from ..experiments.indices import Indices
    from ..experiments.rectangle import SafeRectangle
    from ..experiments.sample import Sample
    from ..experiments.surface import Surface
    from ..sweeps.columns import RunTable
    from ..sweeps.result import Sweep
    from ..tuning.pareto import Front


def sweep_record(swept: "Sweep", envelope: "SafeRectangle | None", made: Made) -> dict[str, Any]:
    """How many runs ended how, and what is safe; the runs themselves are in sweep.npz."""
    axes = [{**_field(it), "values": np.asarray(it.values).tolist(), "scale": it.scale} for it in swept.grid.axes]
    safe = None if envelope is None else _envelope(envelope)
    return _whole(swept, {"axes": axes, "envelope": safe}, made)


def _field(axis: Any) -> dict[str, str]:
    """A swept or sampled field: its path, the unit of its numbers, and the one in which people are shown them."""
    return {"path": axis.path, "unit": axis.unit, "shown_in": axis.typed or axis.unit}


def _envelope(found: "SafeRectangle") -> dict[str, Any]:
    """What is asked of a safe run, how many there are, and the largest rectangle of them."""
    ranges = zip(found.axes, (found.first, found.second), strict=True)
    return {
        "asked": found.asked,
        "safe_runs": int(found.safe.sum()),
        "runs": int(found.safe.size),
        "runs_in_rectangle": int(found.runs),
        "rectangle": [
            {**_field(axis), "low": float(part[0]), "high": float(part[1])} for axis, part in ranges if part is not None
        ],
        "reasons": dict(Counter(str(reason) for reason in found.reasons[~found.safe])),
        "between": None
        if (between := found.between) is None
        else {"runs": between.runs, "unsafe_runs": between.unsafe, "words": between.words},
    }


def sample_record(
    sample: "Sample", indices: "Indices | None", surfaces: "Sequence[Surface]", made: Made
) -> dict[str, Any]:
    """Ranges, how many runs ended how, indices with intervals, surfaces with cross-validated errors."""
    points = sample.grid
    told = {
        "method": points.method,
        "seed": points.seed,
        "ranges": [{**_field(it), "low": it.low, "high": it.high, "scale": it.scale} for it in points.axes],
        "indices": [] if indices is None else _indices(indices),
        "surfaces": [_surface(surface) for surface in surfaces],
    }
    return _whole(sample, told, made)


def _indices(indices: "Indices") -> list[dict[str, Any]]:
    return [
        {
            "quantity": name,
            "number": path,
            "first_order [-]": float(it.first[k]),
            "first_order_interval [-]": it.first_interval[:, k].tolist(),
            "total [-]": float(it.total[k]),
            "total_interval [-]": it.total_interval[:, k].tolist(),
            "confidence [-]": indices.confidence,
            "rows": it.rows,
            "rows_asked": indices.asked,
            "from": "response surface" if name in indices.surfaces else "runs",
        }
        for name, it in indices.estimates.items()
        for k, path in enumerate(indices.paths)
    ]


def _surface(surface: "Surface") -> dict[str, Any]:
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


def front_record(front: "Front", table: tuple[list[str], Iterable[Sequence[Any]]], made: Made) -> dict[str, Any]:
    """The front's points, as in pareto.csv (``table``)."""
    header, rows = table
    told = {
        "kind": front.problem.mechanism.name,
        "objectives": list(front.objectives),
        "scenarios": len(front.problem.cases),
        "samples": front.problem.samples,
        "points": [dict(zip(header, row, strict=True)) for row in rows],
        "design": record(front.problem.design),
        "jaxbuffer": version(),
    }
    return told if made is None else {**told, MADE: made}


def _whole(swept: "RunTable", told: dict[str, Any], made: Made) -> dict[str, Any]:
    mechanism = swept.mechanism
    outcomes = Counter(mechanism.outcomes(int(code)).name for code in swept.code[swept.done])
    found = {
        "kind": mechanism.name,
        **told,
        "runs": len(swept.grid),
        "done": int(swept.done.sum()),
        "outcomes": dict(outcomes),
        "design": record(swept.design),
        "scenario": record(swept.scenario),
        "jaxbuffer": version(),
    }
    return found if made is None else {**found, MADE: made}
