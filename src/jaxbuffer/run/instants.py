"""A run's history at any times, between its steps too."""

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..errors import InputError, concrete, shown
from ..fields import in_unit
from ..hybrid.hermite import cubic, state_within
from ..mechanisms.history import History
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.run import Run
from ..mechanisms.system import ContactSystem
from ..programs.cache import stored
from .history import history_at

BLOCK = 256  # instants looked at together
ROUNDING = 1e-14  # relative, of a quintic's change within a step
SMALL = 1e-6  # of the change of a velocity within a step, what rounding may add to it


def at_times(run: Run, times: Float[np.ndarray, " instants"]) -> History:
    """Return the history at given times.

    Between two steps the state is the polynomial that has the same state and rate at both: Hermite's cubic; for
    positions, which have the same accelerations too, a quintic, whose rates are the velocities. Forces are those that
    the system exerts in that state. A history without states, read from a file say, is followed in straight lines.

    **Arguments:** ``run``: one simulated with ``history=True``; ``times``: [s], those outside the run at its ends.

    **Returns:** a `History` with an entry an instant, its ``others`` by name. Under `jax.jacfwd` and other
    transformations its derivatives are those at fixed times, as a history's are.

    **Raises:** `InputError` for a run without a history, and for times that are no list of numbers.

    **Example:** how high the ball of a dropping bar is between steps.

    >>> import numpy as np
    >>> run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.1, history=True)
    >>> seen = jb.at_times(run, np.array([0.0, 0.05, 0.1]))
    >>> [f"{1e3 * gap:.1f} mm" for gap in seen.gap[:, 0]]
    ['194.0 mm', '187.4 mm', '164.2 mm']
    """
    history = run.history
    if history is None:
        raise InputError("this run has no history to draw; simulate it with history=True")
    if isinstance(times, jax.core.Tracer) or any(isinstance(x, jax.core.Tracer) for x in jax.tree.leaves(run)):
        return _traced(run, history, times)
    known, times = np.asarray(history.time), instants_of(times)
    # One instant is looked at for the shapes, and cut off again.
    if not times.size:
        return jax.tree.map(lambda values: np.asarray(values)[:0], at_times(run, known[:1]))
    times = np.clip(times, known[0], known[-1])
    first = np.clip(np.searchsorted(known, times, side="right") - 1, 0, max(len(known) - 2, 0))
    after = np.minimum(first + 1, len(known) - 1)
    if history.state is None or history.closed is None:
        length = np.where(known[after] > known[first], known[after] - known[first], 1.0)
        share = (times - known[first]) / length
        return jax.tree.map(lambda values: _straight(np.asarray(values), first, after, share), history)
    state, closed = np.asarray(history.state), np.asarray(history.closed)
    # The end of the run, or of a step, is the step's own state: with the contacts that are closed from then on.
    on_end = times >= known[after]
    first = np.where(on_end, after, first)
    given = (known[first], known[after], times, closed[first], state[first], state[after])
    parameters = (run.design, run.scenario, run.stabilisation)
    blocks = [_instants(run.mechanism, parameters, *block) for block in _blocks(given, len(times))]
    return jax.tree.map(lambda *parts: np.concatenate([np.asarray(part) for part in parts])[: len(times)], *blocks)


def _traced(run: Run, history: History, times: Any) -> History:
    """Return the history at given times of a run that is differentiated or compiled: the step of an instant is found
    in the compiled code."""
    if history.state is None or history.closed is None:
        raise InputError("this history has no states, between which a traced run could be followed")
    # A history's derivatives are those at fixed times.
    known = jax.lax.stop_gradient(history.time)
    times = times if isinstance(times, jax.core.Tracer) else jnp.asarray(instants_of(times))
    times = jnp.clip(times, known[0], known[-1])
    first = jnp.clip(jnp.searchsorted(known, times, side="right") - 1, 0, max(len(known) - 2, 0))
    after = jnp.minimum(first + 1, len(known) - 1)
    first = jnp.where(times >= known[after], after, first)
    states = (history.closed[first], history.state[first], history.state[after])
    parameters = (run.design, run.scenario, run.stabilisation)
    return _instants(run.mechanism, parameters, known[first], known[after], times, *states)


def instants_of(times: Any) -> Float[np.ndarray, " instants"]:
    """Return times as an array. **Raises:** `InputError` for what is no list of finite numbers."""
    times = in_unit("times", times, "s")
    instants = concrete(times)
    if instants is None or instants.ndim != 1 or not np.all(np.isfinite(instants)):
        shape = "" if instants is None else f", of the shape {instants.shape}"
        raise InputError(f"times = {shown(times)}{shape}: expected an array (n,) of times [s], [0.0, 0.1] say")
    return instants


def _straight(values: np.ndarray, first: np.ndarray, after: np.ndarray, share: np.ndarray) -> np.ndarray:
    share = share.reshape(-1, *[1] * (values.ndim - 1))
    return (1.0 - share) * values[first] + share * values[after]


def _blocks(given: tuple[np.ndarray, ...], count: int) -> list[tuple[np.ndarray, ...]]:
    """Cut rows into blocks of one size, the last row repeated, so that one program serves all."""
    rows = np.minimum(np.arange(-(-count // BLOCK) * BLOCK), count - 1).reshape(-1, BLOCK)
    return [tuple(part[row] for part in given) for row in rows]


def _within(
    system: ContactSystem, start: tuple[Array, Array], end: tuple[Array, Array], length: Array, x: Array
) -> Array:
    """Return the state at the fraction x of a step, as `state_within`, in steps of any ``length`` [s].

    A step that ends at a maximum may be as short as time itself is rounded. The positions' rounding, divided by such a
    length, would be larger than the velocities: there a cubic of the velocities takes the place of the quintic's rate.
    """
    (y0, f0), (y1, f1) = start, end
    places, own = system.places["q"], system.places["v"]
    state = state_within(system, start, end, length, x)
    rounded = ROUNDING * jnp.maximum(jnp.abs(y0[places]), jnp.abs(y1[places])) / length
    # Where velocities are not the positions' rates, each of them may have to do with any position.
    rounded = rounded if system.velocities == system.coordinates else jnp.max(rounded)
    change = jnp.maximum(jnp.abs(y1[own] - y0[own]), length * jnp.maximum(jnp.abs(f0[own]), jnp.abs(f1[own])))
    smooth = cubic(y0[own], y1[own], length * f0[own], length * f1[own], x)
    return state.at[own].set(jnp.where(rounded > SMALL * change, smooth, state[own]))


@functools.partial(stored, what="instants of a run")
def _instants(
    mechanism: Mechanism,
    parameters: tuple[Any, Any, Array],
    start: Float[Array, " instants"],
    end: Float[Array, " instants"],
    time: Float[Array, " instants"],
    closed: Float[Array, "instants contacts"],
    before: Float[Array, "instants state"],
    after: Float[Array, "instants state"],
) -> History:
    """Return the history at times between steps from ``start`` to ``end``, whose states are ``before`` and
    ``after``."""
    return history_within(mechanism.system(*parameters), start, end, time, closed, before, after)


def history_within(
    system: ContactSystem,
    start: Float[Array, " instants"],
    end: Float[Array, " instants"],
    time: Float[Array, " instants"],
    closed: Float[Array, "instants contacts"],
    before: Float[Array, "instants state"],
    after: Float[Array, "instants state"],
) -> History:
    """Return the history at times between the ``start`` and ``end`` of steps [s], from the states there."""

    def at(start: Array, end: Array, time: Array, closed: Array, before: Array, after: Array) -> History:
        length = jnp.where(end > start, end - start, 1.0)  # the last step of a history has none after it
        first = before, system.derivative(start, before, closed)
        last = after, system.derivative(end, after, closed)
        state = _within(system, first, last, length, (time - start) / length)
        return history_at(system, time, closed, state)

    return jax.vmap(at)(start, end, time, closed, before, after)
