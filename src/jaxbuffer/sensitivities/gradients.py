"""The gradient program: a run with first derivatives of all its quantities, shared by `sensitivity` and `tune`."""

from collections.abc import Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._types import Scalar
from ..fields import Part, with_values
from ..hybrid import HybridSystem, Result, Solver, differentiable, solve_with_tangents
from ..mechanisms.quantity import IMPACT_UNITS, of_impact
from ..mechanisms.registry import mechanism_of
from ..mechanisms.run import Run
from ..programs.cache import Static, after
from ..run.read_off import run_of
from ..run.request import CHECKED, DEFAULT_TOLERANCE, Request, allowed_of, request, stepped, with_tolerances


class Gradients(eqx.Module):
    """A run with first derivatives by the numbers at some addresses.

    ``run``; ``results`` and ``gradients`` (quantities, addresses) of all quantities in the mechanism's catalogue, in
    its order, in units of quantity over parameter; ``by_impact`` (slots, addresses): those of each number of every
    impact, by the names in `Impacts`.
    """

    run: Run
    results: Float[Array, " quantities"]
    gradients: Float[Array, "quantities addresses"]
    by_impact: dict[str, Float[Array, "slots addresses"]]

    def of(self, name: str) -> np.ndarray:
        """The gradient of one quantity (addresses,); NaN for an impact that the run does not have."""
        asked = of_impact(name)
        if asked is None:
            return np.asarray(self.gradients[list(self.run.mechanism.quantities).index(name)])
        present = asked.slot < int(self.run.impacts.count)
        return np.asarray(self.by_impact[asked.field][asked.slot]) * (1.0 if present else np.nan)


def gradients(
    design: Part,
    scenario: Part,
    addresses: Sequence[str],
    values: Sequence[float] | np.ndarray,
    duration: Scalar,
    *,
    rtol: Scalar = DEFAULT_TOLERANCE,
    solver: Solver | None = None,
) -> Gradients:
    """A run of the design and scenario with ``addresses`` set to ``values``, and its derivatives by those.

    One compiled program serves all designs, scenarios, durations, tolerances and quantities of a mechanism.
    """
    inputs = jax.tree.map(lambda x: np.asarray(x, float), (design, scenario, duration, rtol))
    return _gradients(inputs, np.asarray(values, float), Static(tuple(addresses)), solver)


Inputs = tuple[Any, Any, Array, Array]  # design, scenario, duration [s], rtol [-]


def _moved(inputs: Inputs, values: list[Array], asked: Static, solver: Solver | None) -> Request:
    """The run with the asked addresses at ``values``."""
    design, scenario, duration, rtol = inputs
    moved = with_values(design, scenario, dict(zip(asked.value, values, strict=True)))
    return request(*moved, duration, solver, (rtol, rtol))


def _stepped(inputs: Inputs, values: Float[Array, " addresses"], asked: Static, solver: Solver | None) -> Result | None:
    """What time stepping finds, with a tangent for each address; nothing of a mechanism with its own `Stepping`, which
    is differentiated as a whole."""
    if mechanism_of(inputs[0]).stepping is not None:
        return None
    separate = [values[k] for k in range(len(asked.value))]
    parameters, duration, tolerances, options = _moved(inputs, separate, asked, solver)
    mechanism = mechanism_of(inputs[0])
    allowed = allowed_of(mechanism, parameters, duration, tolerances)
    options = with_tolerances(options, parameters, tolerances)

    def assembled(values: list[Array], inputs: Inputs) -> HybridSystem:
        return mechanism.system(*_moved(inputs, values, asked, solver)[0])

    return solve_with_tangents(assembled, separate, inputs, duration, options, allowed)


@after(_stepped, seconds=20.0)
def _gradients(
    inputs: Inputs, values: Float[Array, " addresses"], asked: Static, solver: Solver | None, result: Result | None
) -> Gradients:
    catalogue = mechanism_of(inputs[0]).quantities

    def outputs(values: list[Array]) -> tuple[tuple[Array, dict[str, Array]], tuple[Run, Array]]:
        parameters, duration, _, options = given = _moved(inputs, values, asked, solver)
        found = stepped(*given, CHECKED) if result is None else differentiable(result, values)
        run = run_of(parameters, duration, options, found)
        results = jnp.stack([quantity.of(run) for quantity in catalogue.values()])
        return (results, {name: getattr(run.impacts, name) for name in IMPACT_UNITS}), (run, results)

    separate = [values[k] for k in range(len(asked.value))]
    (slopes, by_impact), (run, results) = jax.jacfwd(outputs, has_aux=True)(separate)
    by_impact = {name: jnp.stack(columns, axis=1) for name, columns in by_impact.items()}
    return Gradients(run, results, jnp.stack(slopes, axis=1), by_impact)
