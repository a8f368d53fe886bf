"""A sensitivity result as tables, for people."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table

from ..fields import unit_at
from ..mechanisms.quantity import is_signed, unit_of
from ..tables import table, text
from .advice import advice

if TYPE_CHECKING:
    from ..mechanisms.mechanism import Mechanism
    from .certificate import Certificate
    from .sensitivity import Sensitivity


def sensitivity_table(result: "Sensitivity") -> str:
    """The tables as text."""
    return text(*sensitivity_parts(result))


def sensitivity_parts(result: "Sensitivity") -> list[str | Table]:
    """Elasticities of every quantity (derivatives of those that can change sign), gradients and the certificate."""
    run, mechanism = result.run, result.run.mechanism
    catalogue = mechanism.quantities
    units = [unit_at(run.design, run.scenario, path) for path in result.paths]
    signed = [is_signed(catalogue, name) for name in result.quantities]

    def slope(i: int, k: int) -> str:
        return f"{result.gradients[i, k]:+.5g} {per(unit_of(catalogue, result.quantities[i]), units[k])}"

    elastic = table("Elasticities: per cent change of a quantity for one per cent more of a parameter")
    _by_parameter(
        elastic, result, np.flatnonzero(np.logical_not(signed)), lambda i, k: f"{result.elasticities[i, k]:+.4f}"
    )
    derivatives = table("Derivatives of quantities that can change sign")
    _by_parameter(derivatives, result, np.flatnonzero(signed), slope)
    main, certificate = result.quantities[0], result.certificate
    gradient = table(f"Gradient of {main}")
    for heading in ("parameter", "value", "gradient", "estimated error"):
        gradient.add_column(heading, justify="left" if heading == "parameter" else "right")
    for k, path in enumerate(result.paths):
        error = "not verified" if certificate is None else f"{certificate.error[0, k]:.1e}"
        gradient.add_row(path, f"{result.values[k]:.5g} {units[k]}", slope(0, k), error)
    tables = ([] if all(signed) else [elastic]) + ([derivatives] if any(signed) else [])
    parts: list[str | Table] = [
        f"Sensitivity at {mechanism.label(run.scenario)}; {run.outcome.reason}",
        *tables,
        gradient,
    ]
    if certificate is not None:
        parts.append(certificate_text(certificate, result.quantities, mechanism, result.run.design))
    if not run.outcome.failed:
        parts += mechanism.notes(run)
    if lines := advice(result):
        parts.append("\n".join(lines))
    return parts


def _by_parameter(filled: Table, result: "Sensitivity", which: np.ndarray, cell: Callable[[int, int], str]) -> None:
    """A column for each quantity in ``which``, a row for each parameter."""
    filled.add_column("parameter")
    for i in which:
        name = result.quantities[i]
        filled.add_column(
            f"{name}\n{result.results[i]:.5g} {unit_of(result.run.mechanism.quantities, name)}", justify="right"
        )
    for k, path in enumerate(result.paths):
        filled.add_row(path, *(cell(i, k) for i in which))


def certificate_text(certificate: "Certificate", quantities: Sequence[str], mechanism: "Mechanism", design: Any) -> str:
    """Verdict, reason, active peak and runner-up, in a line each."""
    lines = [f"Certificate: {certificate.verdict.name.upper()}: {certificate.reason}"]
    less = [f"{n} {v.name}" for n, v in zip(quantities, certificate.verdicts, strict=True) if v]
    if less and len(less) < len(quantities):
        lines.append(f"  not all trusted      {', '.join(less)}; the others are")
    if (peaks := certificate.peaks) is not None:
        lines.append(
            f"  active peak          {peaks.force:.6g} N at {peaks.time:.6g} s,"
            f" {mechanism.contact_in_words(mechanism.names(design).contacts[peaks.contact])}, impact {peaks.impact + 1}"
        )
        if peaks.runner_up_impact < 0:
            lines.append("  runner-up            none: no other impact")
        else:
            swap = f"; {100.0 * peaks.swap_change:+.3g} % of {peaks.swap_path} would make it the peak (first order)"
            lines.append(
                f"  runner-up            {peaks.runner_up_force:.6g} N, impact {peaks.runner_up_impact + 1},"
                f" {100.0 * peaks.margin:.3g} % below" + (swap if peaks.swap_path else "")
            )
    kind = "a difference for each parameter" if certificate.thorough else "one difference along all parameters together"
    if certificate.solves:
        lines.append(f"  evidence             gradient at another tolerance; {kind}, {certificate.solves} tight solves")
    lines.append("  errors are relative to the elasticity, those below 0.001 counting as 0.001")
    return "\n".join(lines)


def per(above: str, below: str) -> str:
    """The unit of a quotient: N/kg, N/(N/m)."""
    return f"{above}/({below})" if {" ", "/"} & set(below) else f"{above}/{below}"
