"""`sensitivity`: gradients and elasticities of a run, with a certificate of how far to trust them."""

import contextlib
import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import equinox as eqx
import numpy as np

from .._types import Scalar
from ..cluster.pool import ClusterPool, pool_of
from ..errors import check_choice, check_single
from ..fields import POSITIVE, Part, check_numbers
from ..hybrid import Solver, name_of, solver_named
from ..mechanisms.quantity import check_quantities, is_signed, value_of
from ..mechanisms.registry import mechanism_of
from ..mechanisms.run import Run
from ..run.request import DEFAULT_TOLERANCE, ONE_RUN, TOLERANCES, check_pair
from ..threads import Pool
from .certificate import Certificate, judge, peak_report
from .evidence import TightSolve, TightSolves, course_of, each, together
from .gradients import Gradients, gradients

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

CERTIFICATES = ("quick", "thorough", "none")
ZERO = 1e-15  # a result below has no elasticities


class Sensitivity(eqx.Module):
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
        """The run."""
        return self.run

    def to_xarray(self) -> "xr.Dataset":
        """Labelled arrays: ``gradient``, ``elasticity`` and ``estimated_error`` by ``quantity`` and ``parameter``, with
        ``gradient_unit``, ``quantity_unit`` and ``parameter_unit`` beside them.

        **Example:**

        >>> found = jb.sensitivity(jb.table2(), wrt=["buffer.k_A"], quantities=["peak_force"], certify="none")
        >>> slope = found.to_xarray().gradient.sel(quantity="peak_force", parameter="buffer.k_A")
        >>> f"{float(slope):+.4f} {slope.gradient_unit.item()}"
        '+0.1728 N/(N/m)'
        """
        from .dataset import sensitivity_dataset

        return sensitivity_dataset(self)

    def to_pandas(self) -> "pd.DataFrame":
        """A row for each pair of quantity and parameter, as in sensitivity.csv."""
        from ..labelled.arrays import frame
        from .dataset import sensitivity_rows

        return frame(*sensitivity_rows(self))

    def __repr__(self) -> str:
        from .summary import sensitivity_table

        return sensitivity_table(self)

    def _repr_html_(self) -> str:
        from ..tables import html
        from .summary import sensitivity_parts

        return html(*sensitivity_parts(self))


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
    client: Any = None,
) -> Sensitivity:
    """Simulate a run and differentiate it.

    **Arguments:**

    - ``design``, ``scenario``, ``duration`` [s], ``rtol`` [-], ``solver``: as for `simulate`.
    - ``wrt``: dotted paths of numbers in the design, or "scenario.…" of the scenario (default: the mechanism's).
    - ``quantities``: names in the mechanism's catalogue, or of an impact as in "impact.3.peak_force" (default: the
      mechanism's).
    - ``certify``: "quick" compares with the gradient at a tenth of the tolerance and with one difference of tight
      solves along all parameters together, "thorough" with differences of tight solves for each parameter, "none" with
      nothing.
    - ``client``: a `distributed.Client`, the address of Dask's scheduler, "local" or "processes": its workers solve,
      rather than threads of this process; the numbers are the same (docs/clusters.md).

    **Returns:** a `Sensitivity`.

    **Raises:** `InputError` for paths or names that are unknown or not numbers, for values out of range, and with
    ``client`` for a solver that has no name and for a scheduler that does not answer.

    **Example:** 1 % more stiffness is 0.34 % more peak force.

    >>> found = jb.sensitivity(jb.table2(), jb.Scenario(), wrt=["buffer.k_A"], quantities=["peak_force"])
    >>> print(f"{found.elasticities[0, 0]:.2f}, {found.certificate.verdict.name}")
    0.34, trusted
    """
    mechanism = mechanism_of(design)
    defaults, catalogue = mechanism.defaults, mechanism.quantities
    scenario = mechanism.scenario() if scenario is None else scenario
    check_pair(mechanism, design, scenario)
    names = check_quantities(catalogue, defaults.differentiated if quantities is None else quantities)
    one = ONE_RUN.format(mechanism.run_name)
    paths, values = check_numbers(design, scenario, defaults.parameters if wrt is None else wrt, one)
    duration = defaults.duration if duration is None else duration
    check_choice("certify", certify, CERTIFICATES)
    check_single("duration", duration, "s", one, **POSITIVE)
    check_single("rtol", rtol, "-", one, **TOLERANCES)
    solver = None if solver is None else solver_named(solver)
    sent = solver if client is None else name_of(solver)
    asked = _Asked(design, scenario, paths, values, names, duration, sent)
    with contextlib.closing(pool_of(client)) as pool:
        if certify == "none":
            (solved,) = pool.map(asked.gradients_at, [rtol])
            return asked.uncertified(solved)
        solved, again = pool.map(asked.gradients_at, [rtol, rtol / 10.0 if rtol >= 1e-12 else 10.0 * rtol])
        found = asked.uncertified(solved)
        certificate = _certificate(asked, found, solved, again, certify == "thorough", pool)
    return dataclasses.replace(found, certificate=certificate)


class _Asked(NamedTuple):
    """What is differentiated: as in `sensitivity`, checked; small enough to be sent to another process."""

    design: Part
    scenario: Part
    paths: tuple[str, ...]
    values: np.ndarray
    names: tuple[str, ...]
    duration: Scalar
    solver: Solver | str | None

    def gradients_at(self, rtol: float) -> Gradients:
        """The run and all its gradients at a tolerance."""
        solver = None if self.solver is None else solver_named(self.solver)
        return gradients(self.design, self.scenario, self.paths, self.values, self.duration, rtol=rtol, solver=solver)

    def slopes(self, solved: Gradients) -> np.ndarray:
        """The gradients asked for (quantities, paths)."""
        return np.array([solved.of(name) for name in self.names])

    def uncertified(self, solved: Gradients) -> Sensitivity:
        """The result without a certificate."""
        run, catalogue = solved.run, solved.run.mechanism.quantities
        results = np.array([value_of(run, name) for name in self.names])
        slopes = np.where(np.isfinite(results)[:, None], self.slopes(solved), np.nan)
        signed = np.array([is_signed(catalogue, name) for name in self.names])[:, None]
        elasticities = np.where(signed, np.nan, slopes * self.values / _nonzero(results)[:, None])
        return Sensitivity(run, self.paths, self.values, self.names, results, slopes, elasticities, None)


def _nonzero(results: np.ndarray) -> np.ndarray:
    """Results that have elasticities, NaN for the others."""
    return np.where(np.abs(results) < ZERO, np.nan, results)


def _certificate(
    asked: _Asked, found: Sensitivity, solved: Gradients, again: Gradients, thorough: bool, pool: Pool | ClusterPool
) -> Certificate:
    """The certificate of a result, from its gradients ``solved`` and ``again`` at another tolerance."""
    run, names, values = found.run, asked.names, asked.values
    # Signed like elasticities, but finite where a parameter or a quantity is zero.
    moves = np.where(values == 0.0, 1.0, np.abs(values))
    nonzero = _nonzero(found.results)
    sizes = np.where(np.isfinite(nonzero), np.abs(nonzero), 1.0)
    claimed, evidence = found.gradients * moves / sizes[:, None], None
    if not run.outcome.failed:
        changes = np.abs(found.gradients - asked.slopes(again)) * moves / sizes[:, None]
        inputs = (asked.design, asked.scenario, asked.paths, names, asked.duration, asked.solver)
        tight = TightSolves(TightSolve(*inputs, int(run.code), course_of(run)), values, moves, pool)
        evidence = (each if thorough else together)(tight, claimed, sizes, changes)
    peaks = peak_report(run, np.asarray(solved.by_impact["peak_force"]) * moves, asked.paths)
    return judge(run, names, asked.paths, claimed, evidence, peaks)
