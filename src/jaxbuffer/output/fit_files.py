"""The files of a fit: names, and what makes their contents."""

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from ..fields import get
from ..fitting.fitted import Fitted, FittedNumber
from ..labelled.record import json_number, part_record
from ..mechanisms.registry import mechanism_of
from ..study.design_toml import design_toml
from ..version import version
from . import style
from .fit_figure import fit_figure
from .formats import Contents, Made, csv_text
from .provenance import record_text

COLUMNS = ("test", "column", "time [s]", "measured [SI]", "fitted [SI]", "residual [-]")


def fit_files(fitted: Fitted, made: Made = None, units: Mapping[str, str] = MappingProxyType({})) -> Contents:
    """Return the files of `jaxbuffer fit`. ``made``: how it came about; ``units``: that numbers were typed with."""
    return {
        "design.toml": lambda: _design(fitted, units),
        "fit.json": lambda: record_text(fit_record(fitted), made),
        "fit.csv": lambda: csv_text(COLUMNS, _rows(fitted)),
        "fit.txt": lambda: f"{fitted!r}\n",
        **style.both("fit", lambda: fit_figure(fitted)),
    }


def fit_record(fitted: Fitted) -> dict[str, Any]:
    """Return a fit as a record, in SI units; with several tests a name of one of them begins with "TEST: "."""
    own = lambda table: {fitted.own_name(test, name): it for test, rows in table.items() for name, it in rows.items()}  # noqa: E731
    return {
        "kind": mechanism_of(fitted.start).name,
        "parameters": {
            path: {**_estimate(it), "start": float(get(fitted.start, path))} for path, it in fitted.parameters.items()
        },
        "nuisance": {name: _estimate(it) for name, it in own(fitted.nuisance).items()},
        "residual": {name: json_number(it) for name, it in own(fitted.residual).items()},
        "noise": {name: json_number(it) for name, it in own(fitted.noise).items()},
        "columns": {
            fitted.own_name(test, column): {"quantity": quantity, "unit": unit}
            for test, record in fitted.records.items()
            for column, quantity, unit in zip(record.columns, record.quantities, record.units, strict=True)
        },
        "rows": dict(fitted.rows),
        "converged": fitted.converged,
        "explained": fitted.explained,
        "doubtful": list(fitted.doubtful),
        "outliers": {name: list(it) for name, it in own(fitted.outliers).items()},
        "clipped": {name: list(it) for name, it in own(fitted.clipped).items()},
        "variance_factor": fitted.inflation,
        "not_told_apart": list(fitted.not_told_apart),
        "correlation": {"names": list(fitted.names), "matrix": fitted.correlation.tolist()},
        "runs": fitted.evaluations,
        "design": part_record(fitted.design),
        "scenario": part_record(fitted.scenario),
        "jaxbuffer": version(),
    }


def _estimate(it: FittedNumber) -> dict[str, Any]:
    numbers = {"value": json_number(it.value), "low": json_number(it.low), "high": json_number(it.high)}
    return {**numbers, "unit": it.unit, "at_bound": it.at_bound}


def _rows(fitted: Fitted) -> Iterator[tuple[Any, ...]]:
    for test, record in fitted.records.items():
        for k, column in enumerate(record.columns):
            residual = record.residual(k, fitted.noise[test][column])
            for row in zip(record.times, record.measured[k], record.fitted[k], residual, strict=True):
                yield test, column, *map(float, row)


def _design(fitted: Fitted, units: Mapping[str, str]) -> str:
    tests = ", ".join(fitted.rows)
    lines = [f"Fitted to {tests}: {fitted.verdict}. {fitted.interval_name}s:"]
    lines += [f"  {path}: {it.low:.6g} to {it.high:.6g} {it.unit}" for path, it in fitted.parameters.items()]
    # Fitted numbers have no typed text of their own: what they were typed with says only in which unit.
    return design_toml(fitted.design, (), "\n".join(lines), units, first=fitted.scenario)
