"""Newton's method for the implicit stages of diffrax's Runge-Kutta methods, with the matrix that our own loop uses.

Diffrax's root finder takes the whole Jacobian by as many push-forwards as there are states, factorises it in a library,
and asks for rates as exact as the tolerance of states. This one inverts a matrix of the rank of the stiff forces once a
step, and iterates until what changes is far below the allowed error of a step.
"""

from collections.abc import Callable
from typing import Any

import diffrax
import equinox as eqx
import jax.numpy as jnp
import optimistix as optx
from jaxtyping import Array, Float, Int

from ..system import Linearisation
from .newton import NewtonMatrix
from .stages import CONVERGED

DIVERGING = 2.0  # ratio of successive changes above which the iteration is given up


class NewtonState(eqx.Module):
    """Where an iteration stands: the ``matrix``; the ``size`` of the last change, over CONVERGED of what is allowed,
    and that of the ``previous`` one; the number of ``steps``."""

    matrix: NewtonMatrix
    size: Float[Array, ""]
    previous: Float[Array, ""]
    steps: Int[Array, ""]


class LowRankNewton(optx.AbstractRootFinder):
    """An `optimistix` root finder for a stage f = F(t, y + γ h f) of a state of shape (state,) or, with tangents beside
    it, (state, columns).

    ``rtol``, ``atol``, ``norm``: of the step size controller. ``linearise``: from time [s], state or columns and the
    solve's ``args`` to the stiff part of F's Jacobian.
    """

    rtol: Any
    atol: Any
    norm: Callable[[Any], Float[Array, ""]]
    linearise: Callable[[Any, Array, Any], Linearisation]

    def init(self, fn, y, args, options, f_struct, aux_struct, tags):
        if "init_state" in options:  # what an earlier stage of the step returned: one matrix a step
            return options["init_state"]
        stage = _Stage(args)
        shift = jnp.asarray(stage.diagonal * stage.control, float)
        stiff = self.linearise(stage.time, stage.state(y), stage.args)
        infinite = jnp.asarray(jnp.inf)
        return NewtonState(NewtonMatrix.of(stiff, shift), infinite, infinite, jnp.asarray(0))

    def step(self, fn, y, args, options, state, tags):
        residual, aux = fn(y, args)
        columns = residual.reshape(len(residual), -1)
        change = -state.matrix.solve(columns).reshape(residual.shape)
        stage = _Stage(args)
        allowed = self.atol + self.rtol * jnp.abs(stage.state(y + change))
        # The unknown is a slope: the tolerance is about the change of the state that it makes.
        size = self.norm(stage.gain * change / allowed) / CONVERGED
        return y + change, NewtonState(state.matrix, size, state.size, state.steps + 1), aux

    def terminate(self, fn, y, args, options, state, tags):
        results = optx.RESULTS
        growing = (state.steps >= 2) & (state.size > DIVERGING * state.previous)
        lost = (state.steps >= 1) & ~jnp.isfinite(state.size) | growing
        converged = state.size < 1.0
        failure = results.where(lost, results.nonlinear_divergence, results.successful)
        return converged | lost, results.where(converged, results.successful, failure)

    def postprocess(self, fn, y, aux, args, options, state, tags, result):
        return y, aux, {}


class _Stage:
    """The arguments that diffrax gives a root finder, which it passes on "so that custom nonlinear solvers can
    special-case": methods whose last slope is the next step's first solve for rates (with one entry more), the
    others for rates times the step."""

    def __init__(self, arguments: tuple[Any, ...]):
        self.diagonal = arguments[1]
        self.time, self.known, self.args, self.control = arguments[-4:]
        self.gain = self.diagonal * (self.control if len(arguments) == 8 else 1.0)

    def state(self, unknown: Array) -> Array:
        """Return the state of the stage from the unknown that is solved for."""
        return self.known + self.gain * unknown


def with_root_finder(
    method: diffrax.AbstractSolver, linearise: Callable[[Any, Array, Any], Linearisation]
) -> diffrax.AbstractSolver:
    """Give an implicit method `LowRankNewton`, at the tolerances of the step size controller, in place of diffrax's
    default root finder; return any other method as it is."""
    # A root finder that differs from the class's own was chosen by the user, and stays.
    if not isinstance(method, diffrax.AbstractImplicitSolver) or method.root_finder != type(method)().root_finder:
        return method
    finder = diffrax.with_stepsize_controller_tols(LowRankNewton)(linearise=linearise)
    return eqx.tree_at(lambda m: m.root_finder, method, finder)
