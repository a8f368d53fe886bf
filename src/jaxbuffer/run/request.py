"""Making requests for runs, and what they are checked for."""

import dataclasses
import functools
from typing import Any

from .._types import Scalar
from ..errors import check_type
from ..fields import Part
from ..hybrid import AUTOMATIC, Diffrax, Options, Solver
from ..mechanisms.mechanism import TOLERANCES, Mechanism, Request, Tolerances

DEFAULT_TOLERANCE = 1e-6
NO_TENTH = "a tenth of rtol is below 1e-13, the least allowed"
ONE_RUN = "simulate takes one {}: use jax.vmap or jb.sweep"


@functools.cache
def options_of(max_steps: int = 200_000, max_events: int = 512, keep: int = 0) -> Options:
    """Return the default options with these limits; they are made once, since building modules takes a while."""
    return Options(max_steps=max_steps, max_events=max_events, keep=keep)


def request(
    mechanism: Mechanism,
    design: Part,
    scenario: Part,
    duration: Scalar,
    solver: Solver = AUTOMATIC,
    tolerances: Tolerances = (DEFAULT_TOLERANCE, DEFAULT_TOLERANCE),
    stabilisation: Scalar = 20.0,
    options: Options | None = None,
) -> Request:
    """Make a request of unchecked numbers; ``tolerances``: rtol and atol [-]; the rest as for `simulate`."""
    options = options_of() if options is None else options
    # The options that are shared stay as they are; a solver of one's own goes into a copy.
    options = options if solver is options.solver else dataclasses.replace(options, solver=solver)
    if isinstance(options.solver, Diffrax):  # it has no events to set a memory at; the run's design says so
        design = mechanism.smooth(design, scenario)
    return Request(mechanism, (design, scenario, stabilisation), duration, tolerances, options)


def check_pair(mechanism: Mechanism, design: Any, scenario: Any) -> None:
    """Raise `InputError` where design and scenario are not of one mechanism, or do not fit."""
    kind = mechanism.scenario
    check_type("scenario", scenario, kind, f"the design first, then a scenario, such as {kind.__name__}()")
    mechanism.check_fit(design, scenario)


def check_assembly(mechanism: Mechanism, design: Part, scenario: Part, stabilisation: Scalar = 20.0) -> None:
    """Raise `InputError` where a run must fail because its parts do not go together, such as joints that hold one
    motion twice: assembled from numbers that are known, unlike in a compiled program, the mechanism says so."""
    if mechanism.stepper is None:
        mechanism.system(design, scenario, stabilisation)


def tenth(rtol: float) -> float | None:
    """Return a tenth of a tolerance [-]; None where that is below the least allowed."""
    return None if rtol < 10.0 * TOLERANCES["low"] else 0.1 * rtol
