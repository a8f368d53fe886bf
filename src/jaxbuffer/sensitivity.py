"""Gradients and elasticities of a capture, with a certificate of how far to trust them."""

from collections.abc import Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ._types import Scalar
from .capture import DEFAULT_DURATION, DEFAULT_TOLERANCE, ONE_CAPTURE, TOLERANCES, Capture, simulate
from .certificate import Certificate, judge, peak_report
from .errors import InputError, check_choice, check_names, check_single
from .evidence import CHECK_TOLERANCE as CHECK_TOLERANCE
from .evidence import TightSolves, each, together
from .integrate import Solver, solver_named
from .mechanisms import Design, Scenario, check_fit, get, replace
from .mechanisms.design import POSITIVE
from .programs import Static, kept
from .quantities import IMPACT_UNITS, check_quantities, is_signed, of_impact, value_of
from .quantities import QUANTITIES as CATALOGUE

PARAMETERS = ("buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T", "probe.tip_mass")
QUANTITIES = ("peak_force", "peak_hinge_force", "stroke", "hinge_angle", "end_time")
CERTIFICATES = ("quick", "thorough", "none")
ZERO = 1e-15  # a result below has no elasticities


class Sensitivity(eqx.Module):
    """Gradients of a capture's quantities with respect to design parameters. Print it for a table.

    ``paths`` and their ``values``; ``quantities`` and their ``results``; ``gradients`` (quantities, paths) in units of
    quantity over parameter; ``elasticities`` d ln quantity / d ln parameter [-] (NaN where the quantity is zero, and of
    quantities that can change sign, such as capture_margin: their gradients say more); ``certificate``: the estimated
    error of each, what the peak is and what comes next, and a verdict; None if not
    asked for.
    """

    capture: Capture
    paths: tuple[str, ...]
    values: np.ndarray
    quantities: tuple[str, ...]
    results: np.ndarray
    gradients: np.ndarray
    elasticities: np.ndarray
    certificate: Certificate | None

    def __repr__(self) -> str:
        from .report import sensitivity_table

        return sensitivity_table(self)


def sensitivity(
    design: Design,
    scenario: Scenario | None = None,
    wrt: Sequence[str] = PARAMETERS,
    duration: Scalar = DEFAULT_DURATION,
    *,
    quantities: Sequence[str] = QUANTITIES,
    rtol: float = DEFAULT_TOLERANCE,
    solver: Solver | str | None = None,
    certify: str = "quick",
) -> Sensitivity:
    """Simulate a capture and differentiate it.

    **Arguments:** as for `simulate`; ``wrt``: dotted paths of numbers in the design, or "scenario.…" of the scenario;
    ``quantities``: names in `quantities.QUANTITIES`, or of an impact as in "impact.3.peak_force"; ``certify``: "quick"
    compares with the gradient at a tenth of the tolerance and with one difference of tight solves along all parameters
    together, "thorough" with differences of tight solves for each parameter, "none" with nothing.

    **Returns:** a `Sensitivity`. **Raises:** `InputError` for paths or names that are unknown or not numbers.
    """
    scenario = Scenario() if scenario is None else scenario
    check_fit(design, scenario)
    names = check_quantities(quantities)
    paths, values = parameters(design, scenario, wrt)
    check_choice("certify", certify, CERTIFICATES)
    check_single("duration", duration, "s", ONE_CAPTURE, **POSITIVE)
    check_single("rtol", rtol, "-", ONE_CAPTURE, **TOLERANCES)
    solver = None if solver is None else solver_named(solver)

    def gradients_at(rtol: float) -> tuple["Linearised", np.ndarray]:
        linear = linearised(design, scenario, paths, values, duration, rtol=rtol, solver=solver)
        return linear, np.array([linear.gradient(name) for name in names])

    linear, gradients = gradients_at(rtol)
    capture = linear.capture
    results = np.array([value_of(capture, name) for name in names])
    gradients = np.where(np.isfinite(results)[:, None], gradients, np.nan)
    nonzero = np.where(np.abs(results) < ZERO, np.nan, results)[:, None]
    signed = np.array([is_signed(name) for name in names])[:, None]
    elasticities = np.where(signed, np.nan, gradients * values / nonzero)
    found = Sensitivity(capture, paths, values, names, results, gradients, elasticities, None)
    if certify == "none":
        return found
    # Signed like elasticities, but finite where a parameter or a quantity is zero.
    moves = np.where(values == 0.0, 1.0, np.abs(values))
    sizes = np.where(np.isfinite(nonzero), np.abs(nonzero), 1.0)
    evidence = None
    if not capture.outcome.failed:
        changes = np.abs(gradients - gradients_at(rtol / 10.0 if rtol >= 1e-12 else 10.0 * rtol)[1]) * moves / sizes

        def inputs(values: np.ndarray) -> tuple[Design, Scenario]:
            return _with(design, scenario, paths, list(values))

        tight = TightSolves(inputs, capture, values, moves, names, duration, solver)
        by_differences = each if certify == "thorough" else together
        evidence = by_differences(tight, gradients * moves / sizes, sizes[:, 0], changes)
    peaks = peak_report(capture, np.asarray(linear.impact_gradients) * moves, paths)
    certificate = judge(capture, names, paths, gradients * moves / sizes, evidence, peaks)
    return eqx.tree_at(lambda s: s.certificate, found, certificate, is_leaf=lambda x: x is None)


def parameters(design: Design, scenario: Scenario, wrt: Sequence[str]) -> tuple[tuple[str, ...], np.ndarray]:
    """The dotted paths to differentiate by and their values (paths,). **Raises:** `InputError` for paths that are
    unknown, no numbers or given twice."""
    paths = check_names("wrt", wrt, "buffer.k_A")
    for path in paths:
        value = _get(design, scenario, path)
        if value is None or isinstance(value, (str, bool)):
            raise InputError(f"{path} = {value!r} is not a number that can be differentiated")
        check_single(path, value, "", ONE_CAPTURE)
    return paths, np.array([float(_get(design, scenario, path)) for path in paths])


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
    """A capture with first derivatives by the paths' values: ``results`` and ``gradients`` of all quantities in the
    catalogue, in its order, and of each number of every impact (``by_impact``, by the names in `Impacts`)."""

    capture: Capture
    results: Float[Array, " quantities"]
    gradients: Float[Array, "quantities paths"]
    by_impact: dict[str, Float[Array, "slots paths"]]

    @property
    def impact_gradients(self) -> Float[Array, "slots paths"]:
        """Gradients of every impact's peak force."""
        return self.by_impact["peak_force"]

    def gradient(self, name: str) -> np.ndarray:
        """The gradient of one quantity; NaN for an impact that the capture does not have."""
        asked = of_impact(name)
        if asked is None:
            return np.asarray(self.gradients[list(CATALOGUE).index(name)])
        present = asked.slot < int(self.capture.impacts.count)
        return np.asarray(self.by_impact[asked.field][asked.slot]) * (1.0 if present else np.nan)


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
    all designs, scenarios, tolerances and quantities, shared by `sensitivity` and `tune`."""
    inputs = jax.tree.map(lambda x: np.asarray(x, float), (design, scenario, duration, rtol))
    return _linearised(inputs, np.asarray(values, float), Static(tuple(paths)), solver)


@kept
def _linearised(
    inputs: tuple[Design, Scenario, Array, Array],
    values: Float[Array, " paths"],
    asked: Static,
    solver: Solver | None,
) -> Linearised:
    design, scenario, duration, rtol = inputs
    paths = asked.value

    def outputs(values: list[Array]) -> tuple[tuple[Array, dict[str, Array]], tuple[Capture, Array]]:
        capture = simulate(*_with(design, scenario, paths, values), duration, rtol=rtol, solver=solver)
        results = jnp.stack([quantity.of(capture) for quantity in CATALOGUE.values()])
        return (results, {name: getattr(capture.impacts, name) for name in IMPACT_UNITS}), (capture, results)

    separate = [values[k] for k in range(len(paths))]
    (gradients, by_impact), (capture, results) = jax.jacfwd(outputs, has_aux=True)(separate)
    by_impact = {name: jnp.stack(columns, axis=1) for name, columns in by_impact.items()}
    return Linearised(capture, results, jnp.stack(gradients, axis=1), by_impact)
