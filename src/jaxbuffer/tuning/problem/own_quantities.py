"""Quantities that a user makes of the mechanism's, in every load case of a tuning.

They follow by the chain rule from those of the mechanism. The largest contact force is a maximum over impacts,
max p_i, and another impact may take over within a step d. So the slope at a fixed largest force and the derivative by
that force are separate numbers, and h(max p_i, x) becomes h + ∂h/∂p (max (p_i + ∇p_i d) - max p_i) + ∂h/∂x ∇x d, with
the linear model of every impact inside (a composite function; Fletcher, *Practical Methods of Optimization*,
chapter 14).
"""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from ...errors import InputError
from ...value_text import with_unit
from .problem import Problem


class OwnQuantities(NamedTuple):
    """The own quantities of every load case.

    ``values`` in their units; ``slopes`` by the scaled variables at a fixed largest contact force; ``by_peak``: their
    derivatives by that force [unit/N].
    """

    values: Float[np.ndarray, "cases own"]
    slopes: Float[np.ndarray, "cases own variables"]
    by_peak: Float[np.ndarray, "cases own"]


def compose(
    problem: Problem,
    peak: Float[np.ndarray, "cases ..."],
    rest: Float[np.ndarray, "cases rest"],
    rest_slope: Float[np.ndarray, "cases rest variables"],
) -> OwnQuantities:
    """Compute the own quantities from the measured ones by the chain rule.

    **Arguments:** ``peak``: the largest contact force [N], in a column, none where the problem has no such quantity;
    ``rest``: ``problem.measured_rest``, with slopes by the scaled variables.
    """
    count, variables = len(rest), rest_slope.shape[2]
    own = len(problem.quantities)
    measured = np.column_stack([peak, rest])
    result = OwnQuantities(np.zeros((count, own)), np.zeros((count, own, variables)), np.zeros((count, own)))
    for k, derived in enumerate(problem.quantities.values()):
        columns = [problem.measured.index(name) for name in derived.parameters]
        values, partials = map(np.asarray, derived.linearised(jnp.asarray(measured[:, columns])))
        result.values[:, k] = values
        for name, partial in zip(derived.parameters, partials.T, strict=True):
            # The largest force has no slope of its own here: which impact has it may change within a step.
            if name == problem.peak_quantity:
                result.by_peak[:, k] = partial
            else:
                result.slopes[:, k] += partial[:, None] * rest_slope[:, problem.measured_rest.index(name)]
    return result


def check_start(problem: Problem, measured: Float[np.ndarray, "cases measured"], case: int) -> None:
    """Raise `InputError` with the own quantity that has no number, or no derivative, in a load case of the start."""
    known = dict(zip(problem.measured, map(float, measured[case]), strict=True))
    for name, derived in problem.quantities.items():
        values = [known[parameter] for parameter in derived.parameters]
        value, partials = (np.asarray(array)[0] for array in derived.linearised(jnp.array([values])))
        known_here = zip(derived.parameters, values, strict=True)
        at = ", ".join(f"{it} = {with_unit(x, problem.catalogue[it].unit, 4)}" for it, x in known_here)
        where = f"at the start, {problem.in_sentence(case)}, where {at}"
        if not np.isfinite(value):
            raise InputError(f"quantities.{name}: {derived.label} is {float(value):g} {where}")
        for parameter, partial in zip(derived.parameters, partials, strict=True):
            if not np.isfinite(partial):
                what = f"its derivative by {parameter} is {float(partial):g}"
                raise InputError(f"quantities.{name}: {derived.label}: {what} {where}")
