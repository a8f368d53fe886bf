"""What a differentiation gives: gradients, elasticities and their certificate, as tables and as labelled arrays."""

from collections.abc import Callable, Sequence
from typing import Any

import equinox as eqx
import numpy as np
from rich.table import Table

from .._types import DataFrame, Dataset
from ..fields import as_displayed, display_unit, unit_at
from ..labelled.arrays import Labelled, dataset, frame
from ..labelled.record import headings, json_number
from ..labelled.saved import Saved
from ..mechanisms.dataset import attributes
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.quantity import Catalogue, is_signed, unit_of
from ..mechanisms.run import Run
from ..tables import html, table, text
from ..value_text import percent_text, quotient_unit, with_unit
from .certificate import Certificate

LARGEST = 1e6  # elasticity that is written in full: chaotic runs have far larger ones, which the certificate refuses

COLUMNS = {
    **dict.fromkeys(("quantity", "parameter", "value", "parameter_unit", "gradient", "gradient_unit"), ""),
    **{"elasticity": "-", "estimated_error": "-", "verdict": ""},
}
"""What a pair of quantity and parameter has, with units."""

FAR = 0.5  # relative change beyond which first order says little of its size


class Sensitivity(eqx.Module, Saved):
    """Gradients of a run's quantities with respect to numbers of design and scenario. Print it for a table.

    - ``run``: what was differentiated, also as ``capture``.
    - ``paths``: the numbers' addresses.
    - ``values``: the numbers themselves, each in its unit, shape (paths,).
    - ``quantities``: names of what was differentiated.
    - ``results``: their values, each in its unit, shape (quantities,).
    - ``gradients``: in units of quantity over parameter, shape (quantities, paths).
    - ``elasticities``: d ln quantity / d ln parameter, shape (quantities, paths) [-]; NaN where the quantity is zero,
      and of quantities that can change sign: their gradients say more.
    - ``certificate``: the estimated error of each, what the peak is and what comes next, and a verdict; None if not
      asked for.

    **Example:**

    >>> found = jb.sensitivity(jb.table2(), wrt=["buffer.k_A"], quantities=["peak_force"])
    >>> print(f"{found.results[0]:.2f} N, {found.gradients[0, 0]:+.4f} N/(N/m)")
    253.13 N, +0.1728 N/(N/m)
    """

    run: Run
    paths: tuple[str, ...]
    values: np.ndarray
    quantities: tuple[str, ...]
    results: np.ndarray
    gradients: np.ndarray
    elasticities: np.ndarray
    certificate: Certificate | None

    @property
    def capture(self) -> Run:
        """Return the run."""
        return self.run

    def to_xarray(self) -> Dataset:
        """Return labelled arrays: ``gradient``, ``elasticity`` and ``estimated_error`` by ``quantity`` and
        ``parameter``, with ``gradient_unit``, ``quantity_unit`` and ``parameter_unit`` beside them.

        **Example:**

        >>> found = jb.sensitivity(jb.table2(), wrt=["buffer.k_A"], quantities=["peak_force"], certify="none")
        >>> slope = found.to_xarray().gradient.sel(quantity="peak_force", parameter="buffer.k_A")
        >>> f"{float(slope):+.4f} {slope.gradient_unit.item()}"
        '+0.1728 N/(N/m)'
        """
        return _dataset(self)

    def to_dataframe(self) -> DataFrame:
        """Return a row for each pair of quantity and parameter, as in sensitivity.csv."""
        return frame(*sensitivity_rows(self))

    def __repr__(self) -> str:
        return text(*_tables(self))

    def _repr_html_(self) -> str:
        return html(*_tables(self))


def _tables(result: Sensitivity) -> list[str | Table]:
    """Return tables of the elasticities of every quantity (derivatives of those that can change sign), of gradients and
    of the certificate."""
    run, mechanism = result.run, result.run.mechanism
    catalogue = mechanism.quantities
    units = [unit_at(run.design, run.scenario, path) for path in result.paths]
    # A quantity that can change sign may be zero, where its elasticity is infinite.
    signed = [is_signed(catalogue, name) for name in result.quantities]

    shown = [display_unit(symbol) for symbol in units]

    def slope(i: int, k: int) -> str:
        (above, factor), (below, many) = shown_unit(catalogue, result.quantities[i]), shown[k]
        return with_unit(factor / many * result.gradients[i, k], quotient_unit(above, below), 5, sign=True)

    def elasticity(i: int, k: int) -> str:
        number = result.elasticities[i, k]
        return f"{number:+.3e}" if LARGEST < abs(number) < np.inf else f"{number:+.4f}"

    elastic = table("Elasticities: per cent change of a quantity for one per cent more of a parameter")
    _by_parameter(elastic, result, np.flatnonzero(np.logical_not(signed)), elasticity)
    derivatives = table("Derivatives of quantities that can change sign")
    _by_parameter(derivatives, result, np.flatnonzero(signed), slope)
    main, certificate = result.quantities[0], result.certificate
    gradient = table(f"Gradient of {main}")
    for column in ("parameter", "value", "gradient", "estimated error"):
        gradient.add_column(column, justify="left" if column == "parameter" else "right")
    for k, path in enumerate(result.paths):
        error = "not verified" if certificate is None else f"{certificate.error[0, k]:.1e}"
        gradient.add_row(path, with_unit(*as_displayed(result.values[k], units[k]), 5), slope(0, k), error)
    tables = ([] if all(signed) else [elastic]) + ([derivatives] if any(signed) else [])
    parts: list[str | Table] = [
        f"Sensitivity at {mechanism.view.label(run.scenario)}; {run.outcome.reason}",
        *tables,
        gradient,
    ]
    if certificate is not None:
        parts.append(_certificate_lines(certificate, result.quantities, mechanism, result.run.design))
    if not run.outcome.failed:
        parts += mechanism.view.notes(run)
    if lines := advice(result):
        parts.append("\n".join(lines))
    return parts


def _by_parameter(filled: Table, result: Sensitivity, which: np.ndarray, cell: Callable[[int, int], str]) -> None:
    """Add a column for each quantity in ``which`` and a row for each parameter to the table."""
    filled.add_column("parameter")
    for i in which:
        name = result.quantities[i]
        symbol, factor = shown_unit(result.run.mechanism.quantities, name)
        filled.add_column(f"{name}\n{with_unit(factor * result.results[i], symbol, 5)}", justify="right")
    for k, path in enumerate(result.paths):
        filled.add_row(path, *(cell(i, k) for i in which))


def _certificate_lines(certificate: Certificate, quantities: Sequence[str], mechanism: Mechanism, design: Any) -> str:
    """Return verdict, reason, active peak and runner-up, in a line each."""
    lines = [f"Certificate: {certificate.verdict.name.upper()}: {certificate.reason}"]
    less = [f"{n} {v.name}" for n, v in zip(quantities, certificate.verdicts, strict=True) if v]
    if less and len(less) < len(quantities):
        lines.append(f"  not all trusted      {', '.join(less)}; the others are")
    if (peaks := certificate.peaks) is not None:
        view, names = mechanism.view, mechanism.view.names(design)
        lines.append(
            f"  active peak          {peaks.force:.6g} N at {peaks.time:.6g} s,"
            f" {view.contact_in_words(names.contact(peaks.contact))}, impact {peaks.impact + 1}"
        )
        if peaks.runner_up_impact < 0:
            lines.append("  runner-up            none: no other impact")
        else:
            swap = f"; {percent_text(peaks.swap_change, '+.3g')} of {peaks.swap_path} would make it the peak"
            swap += " (first order)"
            lines.append(
                f"  runner-up            {peaks.runner_up_force:.6g} N, impact {peaks.runner_up_impact + 1},"
                f" {percent_text(peaks.margin, '.3g')} below" + (swap if peaks.swap_path else "")
            )
    kind = "a difference for each parameter" if certificate.thorough else "differences along all parameters together"
    if certificate.solves:
        lines.append(f"  evidence             gradient at another tolerance; {kind}, {certificate.solves} tight solves")
    lines.append("  errors are relative to the elasticity, those below 0.001 counting as 0.001")
    return "\n".join(lines)


def shown_unit(catalogue: Catalogue, name: str) -> tuple[str, float]:
    """Return the unit in which people are shown a quantity, or one of an impact, and how many of it its own is."""
    return catalogue[name].in_figures if name in catalogue else (unit_of(catalogue, name), 1.0)


def advice(result: Sensitivity) -> list[str]:
    """Return a line for each parameter that says by how much it would have to change for the mechanism's margin to be
    zero.

    The least relative change, to first order, comes first. There are no lines where the margin was not asked for, or
    the run succeeded.

    The change is -margin / (d margin / d ln parameter); the margin of a successful run is positive.
    """
    run, mechanism = result.run, result.run.mechanism
    name = mechanism.tuning.margin
    if name is None or name not in result.quantities or run.outcome.failed or mechanism.succeeded(run.code):
        return []
    i = result.quantities.index(name)
    # d margin / d ln parameter: changes are relative, so that parameters in different units can be compared.
    per_share = result.gradients[i] * result.values
    with np.errstate(divide="ignore", invalid="ignore"):
        change = -result.results[i] / per_share
    # A change of -100 % or more would take a parameter through zero, to the other sign.
    reachable = np.isfinite(change) & (change > -1.0)
    verdict = "not certified" if result.certificate is None else result.certificate.verdicts[i].name
    symbol, factor = shown_unit(mechanism.quantities, name)
    now = f"{name} = {with_unit(factor * result.results[i], symbol, 4)}"
    lines = [f"What to change first, so that {now} becomes positive (to first order, which is {verdict}):"]
    for k in (k for k in np.argsort(np.abs(change)) if reachable[k]):
        far = "; so far that only the direction counts" if abs(change[k]) > FAR else ""
        value = with_unit(*as_displayed(result.values[k], unit_at(run.design, run.scenario, result.paths[k])), 5)
        lines.append(f"  {result.paths[k]:20} {percent_text(change[k], '+.3g')} of {value}{far}")
    if left := [path for path, would_do in zip(result.paths, reachable, strict=True) if not would_do]:
        lines.append(f"  no value above zero of {', '.join(left)} would do, each alone")
    return lines


def _dataset(result: Sensitivity) -> Dataset:
    """Return the labelled arrays of `Sensitivity.to_xarray`."""
    run, both, certificate = result.run, ("quantity", "parameter"), result.certificate
    units = [unit_of(run.mechanism.quantities, name) for name in result.quantities]
    below = [unit_at(run.design, run.scenario, path) for path in result.paths]
    quotients = [[quotient_unit(above, under) for under in below] for above in units]
    variables = {
        "value": Labelled(("quantity",), result.results, "", "value of each quantity in its quantity_unit"),
        "parameter_value": Labelled(("parameter",), result.values, "", "value of each parameter in its parameter_unit"),
        "gradient": Labelled(both, result.gradients, "", "derivative, in its gradient_unit"),
        "elasticity": Labelled(both, result.elasticities, "-", "d ln quantity / d ln parameter"),
    }
    if certificate is not None:
        errors = np.asarray(certificate.error)
        variables["estimated_error"] = Labelled(both, errors, "-", "estimated error, relative to the elasticity")
        verdicts = [verdict.name for verdict in certificate.verdicts]
        variables["verdict"] = Labelled(("quantity",), verdicts, "", "how far to trust the gradients")
    coordinates = {
        "quantity": Labelled(("quantity",), list(result.quantities)),
        "parameter": Labelled(("parameter",), list(result.paths)),
        "quantity_unit": Labelled(("quantity",), units),
        "parameter_unit": Labelled(("parameter",), below),
        "gradient_unit": Labelled(both, quotients),
    }
    about = {**attributes(run.mechanism, run.design, run.scenario), "outcome": run.outcome.name}
    return dataset(variables, coordinates, about)


def sensitivity_rows(result: Sensitivity) -> tuple[list[str], list[Sequence[Any]]]:
    """Return a row for each pair of quantity and parameter."""
    certificate = result.certificate
    rows: list[Sequence[Any]] = []
    for i, quantity in enumerate(result.quantities):
        for k, path in enumerate(result.paths):
            symbol = unit_at(result.run.design, result.run.scenario, path)
            rows.append(
                [
                    quantity,
                    path,
                    json_number(result.values[k]),
                    symbol,
                    json_number(result.gradients[i, k]),
                    quotient_unit(unit_of(result.run.mechanism.quantities, quantity), symbol),
                    json_number(result.elasticities[i, k]),
                    None if certificate is None else json_number(certificate.error[i, k]),
                    None if certificate is None else certificate.verdicts[i].name,
                ]
            )
    return headings(COLUMNS), rows
