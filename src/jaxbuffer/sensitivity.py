"""Gradients and elasticities of a capture, with evidence of their own error."""

import functools
from collections.abc import Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ._types import Scalar
from .capture import DEFAULT_DURATION, DEFAULT_TOLERANCE, Capture, simulate
from .errors import InputError
from .integrate import Solver
from .mechanisms import Design, Scenario, get, replace

PARAMETERS = ("buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T", "probe.tip_mass")
QUANTITIES = ("peak_force", "peak_hinge_force", "stroke", "hinge_angle", "end_time")

CHECK_TOLERANCE = 1e-10
CHECK_STEP = 1e-4  # relative; the second, half as long, takes the differences' own error out (Richardson)


class Sensitivity(eqx.Module):
    """Gradients of a capture's quantities with respect to design parameters. Print it for a table.

    ``paths`` and their ``values``; ``quantities`` and their ``results``; ``gradients`` (quantities, paths) in units of
    quantity over parameter; ``elasticities`` d ln quantity / d ln parameter [-]; ``error``: for each path, the
    difference between the gradient of the peak force and central differences of tight solves, relative to the latter
    (or to an elasticity of 1e-3 where it is smaller), or None if not verified.
    """

    capture: Capture
    paths: tuple[str, ...]
    values: np.ndarray
    quantities: tuple[str, ...]
    results: np.ndarray
    gradients: np.ndarray
    elasticities: np.ndarray
    error: np.ndarray | None

    def __repr__(self) -> str:
        from .report import sensitivity_table

        return sensitivity_table(self)


def sensitivity(
    design: Design,
    scenario: Scenario | None = None,
    wrt: Sequence[str] = PARAMETERS,
    duration: Scalar = DEFAULT_DURATION,
    *,
    rtol: float = DEFAULT_TOLERANCE,
    solver: Solver | None = None,
    verify: bool = True,
) -> Sensitivity:
    """Simulate a capture and differentiate it.

    **Arguments:** as for `simulate`; ``wrt``: dotted paths of numbers in the design, or "scenario.…" of the scenario;
    ``verify``: compare with central differences of captures solved at ``rtol`` 1e-10 (four captures a parameter).

    **Returns:** a `Sensitivity`. **Raises:** `InputError` for paths that are unknown or not numbers.
    """
    scenario = Scenario() if scenario is None else scenario
    paths = tuple(wrt)
    for path in paths:
        value = _get(design, scenario, path)
        if value is None or isinstance(value, (str, bool)):
            raise InputError(f"{path} = {value!r} is not a number that can be differentiated")
    values = np.array([float(_get(design, scenario, path)) for path in paths])
    linear = linearised(design, scenario, paths, values, duration, rtol=rtol, solver=solver)
    capture, results, gradients = linear.capture, np.asarray(linear.results), np.asarray(linear.gradients)
    with np.errstate(divide="ignore", invalid="ignore"):
        elasticities = gradients * values / results[:, None]
    error = None
    if verify and not capture.outcome.failed:
        peak = functools.partial(_peak, design, scenario, paths, duration, solver)
        scale = np.where(values == 0.0, 1.0, np.abs(values)) / results[0]
        expected = np.array([_difference(peak, values, k) for k in range(len(paths))]) * scale
        error = np.abs(gradients[0] * scale - expected) / np.maximum(np.abs(expected), 1e-3)
    return Sensitivity(capture, paths, values, QUANTITIES, results, gradients, elasticities, error)


def _split(path: str) -> tuple[bool, str]:
    return (True, path.removeprefix("scenario.")) if path.startswith("scenario.") else (False, path)


def _get(design: Design, scenario: Scenario, path: str) -> Any:
    of_scenario, name = _split(path)
    return get(scenario if of_scenario else design, name)


def _with(
    design: Design, scenario: Scenario, paths: Sequence[str], values: Sequence[Scalar]
) -> tuple[Design, Scenario]:
    pairs = [(*_split(path), value) for path, value in zip(paths, values, strict=True)]
    return (
        replace(design, {name: value for of_scenario, name, value in pairs if not of_scenario}),
        replace(scenario, {name: value for of_scenario, name, value in pairs if of_scenario}),
    )


class Linearised(eqx.Module):
    """A capture with first derivatives: ``results`` and ``gradients`` of `QUANTITIES`, and of every impact's peak force
    (``capture.impacts.peak_force``) with respect to the paths' values."""

    capture: Capture
    results: Float[Array, " quantities"]
    gradients: Float[Array, "quantities paths"]
    impact_gradients: Float[Array, "slots paths"]


def linearised(
    design: Design,
    scenario: Scenario,
    paths: Sequence[str],
    values: Sequence[float] | np.ndarray,
    duration: Scalar = DEFAULT_DURATION,
    *,
    rtol: Scalar = DEFAULT_TOLERANCE,
    solver: Solver | None = None,
) -> Linearised:
    """A capture of the design with ``paths`` set to ``values``, and its derivatives by those: one compiled program for
    all designs and scenarios of a kind, shared by `sensitivity` and `tune`."""
    inputs = jax.tree.map(lambda x: jnp.asarray(x, float), (design, scenario, duration, rtol))
    return _linearised(inputs, jnp.asarray(values, float), tuple(paths), solver)


@eqx.filter_jit
def _linearised(
    inputs: tuple[Design, Scenario, Array, Array],
    values: Float[Array, " paths"],
    paths: tuple[str, ...],
    solver: Solver | None,
) -> Linearised:
    design, scenario, duration, rtol = inputs

    def outputs(values: list[Array]) -> tuple[tuple[Array, Array], Capture]:
        capture = simulate(*_with(design, scenario, paths, values), duration, rtol=rtol, solver=solver)
        return (jnp.stack([getattr(capture, name) for name in QUANTITIES]), capture.impacts.peak_force), capture

    separate = [values[k] for k in range(len(paths))]
    (quantities, peaks), capture = jax.jacfwd(outputs, has_aux=True)(separate)
    results = jnp.stack([getattr(capture, name) for name in QUANTITIES])
    return Linearised(capture, results, jnp.stack(quantities, axis=1), jnp.stack(peaks, axis=1))


def _peak(
    design: Design,
    scenario: Scenario,
    paths: tuple[str, ...],
    duration: Scalar,
    solver: Solver | None,
    values: np.ndarray,
) -> float:
    moved = _with(design, scenario, paths, list(values))
    return float(simulate(*moved, duration, rtol=CHECK_TOLERANCE, solver=solver).peak_force)


def _difference(function: "functools.partial[float]", values: np.ndarray, k: int) -> float:
    """Central differences with two steps, extrapolated."""

    def central(relative: float) -> float:
        step = relative * (abs(values[k]) or 1.0)
        up, down = values.copy(), values.copy()
        up[k], down[k] = values[k] + step, values[k] - step
        return (function(up) - function(down)) / (up[k] - down[k])

    return (4.0 * central(CHECK_STEP / 2) - central(CHECK_STEP)) / 3.0
