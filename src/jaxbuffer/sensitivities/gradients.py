"""The gradient program: a run with first derivatives of all its quantities, shared by `sensitivity` and `tune`."""

from collections.abc import Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from .._types import Scalar
from ..fields import Part, with_values
from ..hybrid import AUTOMATIC, Solver
from ..mechanisms.mechanism import Mechanism, Request
from ..mechanisms.quantity import IMPACT_UNITS, LOAD_UNITS, of_impact
from ..mechanisms.run import Run
from ..programs.cache import Static, after
from ..run.request import DEFAULT_TOLERANCE, request
from ..run.stepper import run_of, stepper_of


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
        """Return the gradient of one quantity (addresses,); NaN for an impact that the run does not have."""
        address = of_impact(name)
        if address is None:
            return np.asarray(self.gradients[list(self.run.mechanism.quantities).index(name)])
        rows = np.asarray(self.by_impact[address.field])
        return rows[address.slot] if address.slot < int(self.run.impacts.count) else np.full(rows.shape[1], np.nan)


def gradients(
    mechanism: Mechanism,
    design: Part,
    scenario: Part,
    addresses: Sequence[str],
    values: Sequence[float] | np.ndarray,
    duration: Scalar,
    *,
    rtol: Scalar = DEFAULT_TOLERANCE,
    solver: Solver = AUTOMATIC,
    names: Sequence[str] = (),
) -> Gradients:
    """Run the design and scenario with ``addresses`` set to ``values``, and return the run with its derivatives by
    those.

    All quantities have them whatever is asked for, but for the loads of impacts: those of ``names`` alone.

    One compiled program serves all designs, scenarios, durations, tolerances and quantities of a mechanism.
    """
    inputs = jax.tree.map(lambda x: np.asarray(x, float), (design, scenario, duration, rtol))
    # Each name that has a load of an impact, and each impact once.
    loaded = {address.slot for name in names if (address := of_impact(name)) and address.field in LOAD_UNITS}
    slots = np.array(sorted(loaded)) if loaded else None
    return _gradients(mechanism, inputs, np.asarray(values, float), Static(tuple(addresses)), solver, slots)


Inputs = tuple[Any, Any, Array, Array]  # design, scenario, duration [s], rtol [-]


def _moved(mechanism: Mechanism, inputs: Inputs, values: list[Array], addresses: Static, solver: Solver) -> Request:
    """Request the run whose ``addresses`` have the ``values``."""
    design, scenario, duration, rtol = inputs
    moved = with_values(design, scenario, dict(zip(addresses.value, values, strict=True)))
    return request(mechanism, *moved, duration, solver, (rtol, rtol))


def _stepped(
    mechanism: Mechanism,
    inputs: Inputs,
    values: Float[Array, " addresses"],
    addresses: Static,
    solver: Solver,
    slots: Int[Array, " impacts"] | None,
) -> Any:
    """Step the run with a tangent for each address."""
    separate = [values[k] for k in range(len(addresses.value))]

    def make(values: list[Array], inputs: Inputs) -> Request:
        return _moved(mechanism, inputs, values, addresses, solver)

    return stepper_of(mechanism).step_with_tangents(make, separate, inputs)


@after(_stepped, seconds=20.0, what="a run with its derivatives")
def _gradients(
    mechanism: Mechanism,
    inputs: Inputs,
    values: Float[Array, " addresses"],
    addresses: Static,
    solver: Solver,
    slots: Int[Array, " impacts"] | None,
    result: Any,
) -> Gradients:
    catalogue = mechanism.quantities

    def make(values: list[Array]) -> Request:
        return _moved(mechanism, inputs, values, addresses, solver)

    def read(values: list[Array], result: Any) -> tuple[Run, Array, dict[str, Array]]:
        run = run_of(make(values), result)
        unknown = jnp.full((), jnp.nan)  # of what has no derivatives
        numbers = [it.of(run) if it.differentiable else unknown for it in catalogue.values()]
        results = jnp.stack(numbers) if numbers else jnp.zeros(0)
        impacts = {name: getattr(run.impacts, name) for name in IMPACT_UNITS}
        if slots is not None:
            others = jnp.full(run.impacts.time.shape, jnp.nan)
            impacts |= {name: others.at[slots].set(run.loads(name, slots)) for name in LOAD_UNITS}
        return run, results, impacts

    separate = [values[k] for k in range(len(addresses.value))]
    # The tangents of the run are there already: each quantity is pushed forward from them.
    (run, results, impacts), slopes = stepper_of(mechanism).with_derivatives(read, make, separate, result)

    def last(slopes: Array | None, of: Array) -> Array:
        return jnp.zeros((*of.shape, len(separate))) if slopes is None else jnp.moveaxis(slopes, 0, -1)

    _, of_results, of_impacts = slopes
    by_impact = {name: last(of_impacts[name], it) for name, it in impacts.items()}
    return Gradients(run, results, last(of_results, results), by_impact)
