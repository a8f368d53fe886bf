"""`sensitivity`: gradients and elasticities of a run, with a certificate of how far to trust them."""

import dataclasses
from collections.abc import Sequence
from concurrent.futures import Executor
from typing import NamedTuple

import numpy as np

from .._types import Scalar
from ..cluster.pool import Pool
from ..errors import check_choice, check_single
from ..fields import POSITIVE, Part, check_numbers
from ..hybrid import Solver, name_of, solver_named
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.quantity import IMPACT_PEAK, check_differentiable, is_signed
from ..mechanisms.registry import mechanism_of
from ..mechanisms.run import value_of
from ..run.request import DEFAULT_TOLERANCE, ONE_RUN, TOLERANCES, check_pair
from .certificate import Certificate, judge, peak_report
from .evidence import TightSolve, TightSolves, course_of, each, together
from .gradients import Gradients, gradients
from .result import Sensitivity

CERTIFICATES = ("quick", "thorough", "none")
ZERO = 1e-15  # a result below has no elasticities


def sensitivity(
    design: Part,
    scenario: Part | None = None,
    wrt: Sequence[str] | None = None,
    duration: Scalar | None = None,
    *,
    quantities: Sequence[str] | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    solver: Solver | str | None = None,
    certify: str = "quick",
    executor: Executor | None = None,
) -> Sensitivity:
    """Simulate a run and differentiate it.

    **Arguments:**

    - ``design``, ``scenario``, ``duration`` [s], ``rtol`` [-], ``solver``: as for `simulate`.
    - ``wrt``: dotted paths of numbers in the design, or "scenario.…" of the scenario (default: the mechanism's).
    - ``quantities``: names in the mechanism's catalogue, or of an impact as in "impact.3.peak_force" (default: the
      mechanism's).
    - ``certify``: "quick" compares with the gradient at a tenth of the tolerance and with one to three differences
      of tight solves along all parameters together, "thorough" with differences of tight solves for each parameter,
      "none" with nothing.
    - ``executor``: solves in place of threads of this process: any executor of `concurrent.futures`, as for `sweep`;
      the numbers are the same (docs/clusters.md).

    **Returns:** a `Sensitivity`.

    **Raises:** `InputError` for paths or names that are unknown or not numbers, for values out of range, and with
    ``executor`` for a solver that has no name.

    **Example:** 1 % more stiffness is 0.34 % more peak force.

    >>> found = jb.sensitivity(jb.table2(), jb.Scenario(), wrt=["buffer.k_A"], quantities=["peak_force"])
    >>> print(f"{found.elasticities[0, 0]:.2f}, {found.certificate.verdict.name}")
    0.34, trusted
    """
    mechanism = mechanism_of(design)
    catalogue = mechanism.quantities
    scenario = mechanism.scenario() if scenario is None else scenario
    check_pair(mechanism, design, scenario)
    names = check_differentiable(
        catalogue, mechanism.defaults_for(design).differentiated if quantities is None else quantities
    )
    one = ONE_RUN.format(mechanism.view.run_name)
    paths, values = check_numbers(design, scenario, mechanism.parameters(design) if wrt is None else wrt, one)
    duration = mechanism.duration(design) if duration is None else duration
    check_choice("certify", certify, CERTIFICATES)
    check_single("duration", duration, "s", one, **POSITIVE)
    check_single("rtol", rtol, "-", one, **TOLERANCES)
    solver = solver_named(solver)
    # Another process makes the solver for itself, by its name.
    sent = solver if executor is None else name_of(solver)
    task = _Differentiation(mechanism, design, scenario, paths, values, names, duration, sent)
    with Pool(executor) as pool:
        if certify == "none":
            (solved,) = pool.map(task.gradients_at, [rtol])
            return task.uncertified(solved)
        # Upwards where a tenth is below 1e-13, the least tolerance allowed.
        solved, again = pool.map(task.gradients_at, [rtol, rtol / 10.0 if rtol >= 1e-12 else 10.0 * rtol])
        result = task.uncertified(solved)
        certificate = _certificate(task, result, solved, again, certify == "thorough", pool)
    return dataclasses.replace(result, certificate=certificate)


class _Differentiation(NamedTuple):
    """What is differentiated: as in `sensitivity`, checked; small enough to be sent to another process."""

    mechanism: Mechanism
    design: Part
    scenario: Part
    paths: tuple[str, ...]
    values: np.ndarray
    names: tuple[str, ...]
    duration: Scalar
    solver: Solver | str

    def gradients_at(self, rtol: float) -> Gradients:
        """Return the run and all its gradients at a tolerance."""
        at = (self.design, self.scenario, self.paths, self.values, self.duration)
        return gradients(self.mechanism, *at, rtol=rtol, solver=solver_named(self.solver), names=self.names)

    def slopes(self, solved: Gradients) -> np.ndarray:
        """Return the gradients asked for (quantities, paths)."""
        return np.array([solved.of(name) for name in self.names])

    def uncertified(self, solved: Gradients) -> Sensitivity:
        """Return the result without a certificate."""
        run, catalogue = solved.run, solved.run.mechanism.quantities
        results = np.array([value_of(run, name) for name in self.names])
        slopes = np.where(np.isfinite(results)[:, None], self.slopes(solved), np.nan)
        signed = np.array([is_signed(catalogue, name) for name in self.names])[:, None]
        # A quantity that can change sign may be near zero, and a change relative to it says nothing.
        elasticities = np.where(signed, np.nan, slopes * self.values / _nonzero(results)[:, None])
        return Sensitivity(run, self.paths, self.values, self.names, results, slopes, elasticities, None)


def _nonzero(results: np.ndarray) -> np.ndarray:
    """Return the results that have elasticities, NaN for the others."""
    return np.where(np.abs(results) < ZERO, np.nan, results)


def _certificate(
    task: _Differentiation,
    result: Sensitivity,
    solved: Gradients,
    again: Gradients,
    thorough: bool,
    pool: Pool,
) -> Certificate:
    """Return the certificate of a result, from its gradients ``solved`` and ``again`` at another tolerance."""
    run, names, values = result.run, task.names, task.values
    # Signed like elasticities, but finite where a parameter or a quantity is zero.
    moves = np.where(values == 0.0, 1.0, np.abs(values))
    nonzero = _nonzero(result.results)
    sizes = np.where(np.isfinite(nonzero), np.abs(nonzero), 1.0)
    claimed, evidence = result.gradients * moves / sizes[:, None], None
    if not run.outcome.failed:
        changes = np.abs(result.gradients - task.slopes(again)) * moves / sizes[:, None]
        inputs = (task.mechanism, task.design, task.scenario, task.paths, names, task.duration, task.solver)
        tight = TightSolves(TightSolve(*inputs, int(run.code), course_of(run)), values, moves, pool)
        evidence = (each if thorough else together)(tight, claimed, sizes, changes)
    peaks = peak_report(run, np.asarray(solved.by_impact[IMPACT_PEAK]) * moves, task.paths)
    return judge(run, names, task.paths, claimed, evidence, peaks)
