"""The own quantities of a problem by the chain rule: values and slopes from those of the quantities they are made of.

The largest contact force is a maximum over impacts, max p_i, and another impact may take over within a step d. So the
slope at a fixed largest force and the derivative by that force are kept apart, and h(max p_i, x) becomes
h + ∂h/∂p (max (p_i + ∇p_i d) - max p_i) + ∂h/∂x ∇x d, with the linear model of every impact inside (a composite
function; Fletcher, *Practical Methods of Optimization*, chapter 14).
"""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from ..errors import InputError
from .problem import Problem


class Composed(NamedTuple):
    """The own quantities of every case.

    ``values`` in their units; ``slopes`` by the scaled variables at a fixed largest contact force; ``by_peak``: their
    derivatives by that force [unit/N].
    """

    values: Float[np.ndarray, "cases own"]
    slopes: Float[np.ndarray, "cases own variables"]
    by_peak: Float[np.ndarray, "cases own"]

    @property
    def finite(self) -> Bool[np.ndarray, " cases"]:
        """Which cases have numbers throughout."""
        known = np.isfinite(self.values) & np.isfinite(self.by_peak) & np.all(np.isfinite(self.slopes), axis=2)
        return np.asarray(np.all(known, axis=1))


def composed(
    problem: Problem,
    peak: Float[np.ndarray, " cases"],
    rest: Float[np.ndarray, "cases measured-1"],
    rest_slope: Float[np.ndarray, "cases measured-1 variables"],
) -> Composed:
    """The own quantities from the measured ones.

    **Arguments:** ``peak``: the largest contact force [N]; ``rest``: the others of ``problem.measured``, with their
    slopes by the scaled variables.
    """
    count, variables = len(peak), rest_slope.shape[2]
    own = len(problem.quantities)
    found = Composed(np.zeros((count, own)), np.zeros((count, own, variables)), np.zeros((count, own)))
    known = np.column_stack([peak, rest])
    for k, derived in enumerate(problem.quantities.values()):
        columns = [problem.measured.index(name) for name in derived.parameters]
        values, partials = map(np.asarray, derived.linearised(jnp.asarray(known[:, columns])))
        found.values[:, k] = values
        for column, partial in zip(columns, partials.T, strict=True):
            if column == 0:
                found.by_peak[:, k] = partial
            else:
                found.slopes[:, k] += partial[:, None] * rest_slope[:, column - 1]
    return found


def check_start(
    problem: Problem, peak: Float[np.ndarray, " cases"], rest: Float[np.ndarray, "cases measured-1"], case: int
) -> None:
    """Raise `InputError` with the own quantity that has no number, or no derivative, in a case of the start."""
    known = dict(zip(problem.measured, [float(peak[case]), *map(float, rest[case])], strict=True))
    for name, derived in problem.quantities.items():
        given = [known[parameter] for parameter in derived.parameters]
        values, partials = (np.asarray(found)[0] for found in derived.linearised(jnp.array([given])))
        units = (problem.catalogue[parameter].unit for parameter in derived.parameters)
        at = ", ".join(
            f"{p} = {x:.4g} {u}".rstrip(" -") for p, x, u in zip(derived.parameters, given, units, strict=True)
        )
        where = f"at the start, {problem.cases[case].label(problem.cases)}, where {at}"
        if not np.isfinite(values):
            raise InputError(f"quantities.{name}: {derived.label} is {float(values):g} {where}")
        for parameter, partial in zip(derived.parameters, partials, strict=True):
            if not np.isfinite(partial):
                told = f"its derivative by {parameter} is {float(partial):g}"
                raise InputError(f"quantities.{name}: {derived.label}: {told} {where}")
