"""`as_diffrax`: a design in a scenario as a problem for `diffrax.diffeqsolve`."""

import jax
import jax.numpy as jnp

from ..fields import Part
from ..hybrid.diffrax_problem import DiffraxProblem, diffrax_problem
from ..mechanisms.registry import mechanism_of
from ..programs.process import check_ready
from .simulate import check_pair


def as_diffrax(design: Part, scenario: Part | None = None) -> DiffraxProblem:
    """Return a run, with the smooth contact law, as terms, initial state, arguments and event for
    `diffrax.diffeqsolve`.

    **Arguments:**

    - ``design``: a capture's ``contact.memory`` is taken as "smooth".
    - ``scenario`` (default: the mechanism's own).

    **Returns:** a `DiffraxProblem`, whose ``args`` are the design and the scenario.

    **Raises:** `InputError` where design and scenario don't fit, for a contact law whose force jumps at touchdown, and
    for parts that begin or end at events.

    **Example:** the end of a capture, where the first of the guards, capture, ends the solve.

    >>> import diffrax
    >>> problem = jb.as_diffrax(jb.table2(), jb.Scenario())
    >>> solution = diffrax.diffeqsolve(
    ...     problem.term, diffrax.Tsit5(), 0.0, 8.0, problem.dt0, problem.y0, args=problem.args, event=problem.event,
    ...     stepsize_controller=diffrax.PIDController(rtol=1e-6, atol=1e-6 * problem.scales), max_steps=8192,
    ... )
    >>> f"guard {problem.ended_by(solution.ys[0], problem.args)} at {float(solution.ts[0]):.4f} s"
    'guard 0 at 0.7193 s'
    """
    mechanism = mechanism_of(design)
    scenario = mechanism.scenario() if scenario is None else scenario
    check_pair(mechanism, design, scenario)
    check_ready()
    smooth = mechanism.smooth(design, scenario)
    args = jax.tree.map(lambda number: jnp.asarray(number, float), (smooth, scenario))
    return diffrax_problem(mechanism.system, args)
