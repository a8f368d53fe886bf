"""`simulate`: one run of any mechanism, from a design and a scenario to everything one wants to know of it."""

import functools
from typing import Any, overload

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from .._types import Scalar
from ..errors import InputError, check_flag, check_single, check_whole
from ..fields import Part
from ..hybrid import Result, Solver, solver_named
from ..mechanisms.mechanism import LIMITS, Mechanism, Request
from ..mechanisms.registry import mechanism_of
from ..mechanisms.run import DesignOf, R, Run
from ..programs.cache import Static, after, stored
from .history import trimmed
from .instants import at_times
from .request import DEFAULT_TOLERANCE, ONE_RUN, check_assembly, check_pair, options_of, request
from .stepper import CHECKED, HISTORY_STEPS, run_of, stepped, stepper_of


@overload
def simulate(
    design: DesignOf[R],
    scenario: Part | None = ...,
    duration: Scalar | None = ...,
    *,
    solver: Solver | str | None = ...,
    rtol: Scalar = ...,
    atol: Scalar | None = ...,
    history: bool | int = ...,
    times: Any = ...,
    max_steps: int = ...,
    max_events: int = ...,
    stabilisation: Scalar = ...,
) -> R: ...
@overload
def simulate(
    design: Part,
    scenario: Part | None = ...,
    duration: Scalar | None = ...,
    *,
    solver: Solver | str | None = ...,
    rtol: Scalar = ...,
    atol: Scalar | None = ...,
    history: bool | int = ...,
    times: Any = ...,
    max_steps: int = ...,
    max_events: int = ...,
    stabilisation: Scalar = ...,
) -> Run: ...
def simulate(
    design: Part,
    scenario: Part | None = None,
    duration: Scalar | None = None,
    *,
    solver: Solver | str | None = None,
    rtol: Scalar = DEFAULT_TOLERANCE,
    atol: Scalar | None = None,
    history: bool | int = False,
    times: Any = None,
    max_steps: int = 200_000,
    max_events: int = 512,
    stabilisation: Scalar = 20.0,
) -> Run:
    """Simulate one run of the mechanism that the design is of. Works under `jit`, `vmap`, `grad`, `jacfwd` and `jvp`.

    **Arguments:**

    - ``design``: of any mechanism, such as ``jb.table2()``.
    - ``scenario`` (default: the mechanism's own).
    - ``duration``: after which a run is over [s] (default: the mechanism's, 8 s for a capture).
    - ``solver``: a name in `hybrid.SOLVER_NAMES` or a `hybrid.Solver` (`jb.Diffrax` takes the smooth contact law).
    - ``rtol``, ``atol``: local error allowed in a step, of a component's size and of its natural scale [-] (``atol``
      defaults to ``rtol``).
    - ``history``: whether to keep time histories, of 20 000 steps at most; a number is another limit.
    - ``times``: (instants,) of the history that is wanted, in place of the steps [s] (`at_times` says how it is
      followed between these). Derivatives are those at fixed times, under the steps' own error control.
    - ``max_steps``: limit whose passing is a failed outcome.
    - ``max_events``: room for events in order; of later ones only the maxima, the end and the number of impacts are
      known.
    - ``stabilisation``: Baumgarte's gain [1/s].

    **Returns:** a `Run`; of the probe-cone mechanism a `Capture`. Not converging is an outcome, not an error.

    **Raises:** `InputError` for values out of range, and for a design of no mechanism.

    **Example:**

    >>> capture = jb.simulate(jb.table2(), jb.Scenario(approach_speed=0.1))
    >>> print(f"{capture.outcome.name}: {float(capture.peak_force):.2f} N at {float(capture.peak_time):.4f} s")
    captured: 253.13 N at 0.4881 s
    """
    mechanism = mechanism_of(design)
    scenario = mechanism.scenario() if scenario is None else scenario
    check_pair(mechanism, design, scenario)
    duration = mechanism.duration(design) if duration is None else duration
    atol = rtol if atol is None else atol
    one = ONE_RUN.format(mechanism.view.run_name)
    for name, value, unit in (
        ("duration", duration, "s"),
        ("rtol", rtol, "-"),
        ("atol", atol, "-"),
        ("stabilisation", stabilisation, "1/s"),
    ):
        check_single(name, value, unit, one, **LIMITS[name])
    check_whole("max_steps", max_steps, 1)
    check_whole("max_events", max_events, 1)
    options = options_of(max_steps, max_events, _kept_steps(history, times))
    solver = solver_named(solver)
    given = request(mechanism, design, scenario, duration, solver, (rtol, atol), stabilisation, options)
    leaves, traced = jax.tree.leaves(given), False
    # A design of Python's numbers alone, the usual one, goes to the program as it is.
    if not all(type(leaf) is float for leaf in leaves):
        traced = any(isinstance(leaf, jax.core.Tracer) for leaf in leaves)
        given = jax.tree.map(_array, given)
        for path, leaf in jax.tree_util.tree_leaves_with_path((design, scenario)):
            if np.ndim(leaf):
                name = "".join(str(key) for key in path[1:]).lstrip(".")
                raise InputError(f"{name} has shape {np.shape(leaf)}; {one}")
    # Traced numbers have no values to check yet: the program does it, and such a run ends with `failed_input`.
    run = _traced(given) if traced else _simulate(given, CHECKED)
    if not traced and run.outcome.failed:
        check_assembly(mechanism, design, scenario, stabilisation)
    return _with_history(run, mechanism, times)


def _kept_steps(history: bool | int, times: Any) -> int:
    """Return of how many steps a history is kept at most. **Raises:** `InputError` for what says no such number."""
    if type(history) is int:
        check_whole("history", history, 1)
        return history
    check_flag("history", history)
    return HISTORY_STEPS if history or times is not None else 0


def _with_history(run: Run, mechanism: Mechanism, times: Any) -> Run:
    """Return a run whose history has the steps that there were, or the instants at some ``times``."""
    # Traced, a history keeps its size, since the number of steps is not known yet.
    if run.history is not None and not isinstance(run.code, jax.core.Tracer):
        rows = stepper_of(mechanism).rows(run)
        run = eqx.tree_at(lambda r: r.history, run, trimmed(run.history, rows))
    if times is not None:
        run = eqx.tree_at(lambda r: r.history, run, at_times(run, times))
    return run


def _array(value: Any) -> Any:
    """Return a number as an array; Python's numbers go through NumPy, which is ten times quicker than through a
    device."""
    return jnp.asarray(value, float) if isinstance(value, jax.Array) else np.asarray(value, float)


@after(stepped, what="a run")
def _simulate(request: Request, unchecked: Static, result: Result) -> Run:
    return run_of(request, result)


@functools.partial(stored, what="a run")
def _traced(request: Request) -> Run:
    """Run within a larger program, which may differentiate it."""
    return stepper_of(request.mechanism).run(request)
