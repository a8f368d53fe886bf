"""A sensitivity as labelled arrays and as rows of a table."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..fields import unit_at
from ..labelled.arrays import Labelled, dataset
from ..mechanisms.dataset import attributes
from ..mechanisms.quantity import unit_of
from .summary import per

if TYPE_CHECKING:
    import xarray as xr

    from .sensitivity import Sensitivity


def sensitivity_dataset(result: "Sensitivity") -> "xr.Dataset":
    """See `Sensitivity.to_xarray`."""
    run, both, certificate = result.run, ("quantity", "parameter"), result.certificate
    units = [unit_of(run.mechanism.quantities, name) for name in result.quantities]
    below = [unit_at(run.design, run.scenario, path) for path in result.paths]
    quotients = [[per(above, under) for under in below] for above in units]
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


def sensitivity_rows(result: "Sensitivity") -> tuple[list[str], list[Sequence[Any]]]:
    """A row for each pair of quantity and parameter."""
    header = ["quantity", "parameter", "value", "parameter_unit", "gradient", "gradient_unit", "elasticity [-]"]
    certificate = result.certificate
    rows: list[Sequence[Any]] = []
    for i, quantity in enumerate(result.quantities):
        for k, path in enumerate(result.paths):
            symbol = unit_at(result.run.design, result.run.scenario, path)
            rows.append(
                [
                    quantity,
                    path,
                    _number(result.values[k]),
                    symbol,
                    _number(result.gradients[i, k]),
                    per(unit_of(result.run.mechanism.quantities, quantity), symbol),
                    _number(result.elasticities[i, k]),
                    None if certificate is None else _number(certificate.error[i, k]),
                    None if certificate is None else certificate.verdicts[i].name,
                ]
            )
    return [*header, "estimated_error [-]", "verdict"], rows


def _number(value: Any) -> float | None:
    number = float(value)
    return number if math.isfinite(number) else None
