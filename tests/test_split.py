"""A program cut behind its loop computes what it computed whole."""

import gc

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer import Scenario, get, table2
from jaxbuffer.compiling import split
from jaxbuffer.compiling.programs import Static
from jaxbuffer.compiling.split import compiled, run
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.run.simulate import _options, _simulate
from jaxbuffer.sensitivities.gradients import _gradients

PARAMETERS = PROBE_CONE.defaults.parameters

TABLE = np.array([1.0, 2.0, 4.0])


def powers(base, times):
    """base^times by a loop, with what leads there and what follows; a smaller loop after it."""
    doubled = 2.0 * base
    total, steps = jax.lax.while_loop(
        lambda c: c[1] < times, lambda c: (jnp.where(c[1] >= 0, c[0] * base, 0.0), c[1] + 1), (jnp.ones(()), 0)
    )
    again = jax.lax.fori_loop(0, 3, lambda _, x: x + 1.0, total)
    return [base, total, steps, doubled, total * doubled + jnp.sum(TABLE), again, jnp.ones(2)]


def expected(base, times):
    power = base**times
    return [base, power, times, 2.0 * base, power * 2.0 * base + 7.0, power + 3.0, [1.0, 1.0]]


def close(found, wanted):
    assert len(found) == len(wanted)
    for ours, exact in zip(found, wanted, strict=True):
        np.testing.assert_allclose(ours, exact, rtol=1e-14)


@pytest.mark.parametrize(("worth", "parts"), [(1, 2), (10**6, 1)])
def test_whole_or_cut_it_computes_the_same(monkeypatch, worth, parts):
    monkeypatch.setattr(split, "WORTH", worth)
    program = compiled(powers, (np.asarray(1.5), np.asarray(4)))
    assert len(program) == parts
    for base, times in ((1.5, 4), (-2.0, 7), (3.0, 0)):
        close(run(program, (np.asarray(base), np.asarray(times))), expected(base, times))


@pytest.mark.parametrize("within", [jax.jit, jax.checkpoint, jax.custom_batching.sequential_vmap])
def test_the_loop_of_a_function_within(monkeypatch, within):
    """What follows a function that holds the loop is cut off as if the loop stood there itself."""
    monkeypatch.setattr(split, "WORTH", 5)

    def outer(base, times):
        found = within(powers)(base, times)
        return [found[1], jnp.sin(found[1]) + jnp.cos(found[5]) * jnp.tanh(base) + jnp.sqrt(base)]

    program = compiled(outer, (np.asarray(1.5), np.asarray(4)))
    assert len(program) == 2
    power = 1.5**4
    exact = [power, np.sin(power) + np.cos(power + 3.0) * np.tanh(1.5) + np.sqrt(1.5)]
    close(run(program, (np.asarray(1.5), np.asarray(4))), exact)


def test_gradients_are_cut_and_captures_stay_whole():
    """Where a second program is worth its call (docs/numerics.md)."""
    design, scenario = (jax.tree.map(lambda x: jnp.asarray(x, float), x) for x in (table2(), Scenario()))
    rtol, duration, gain = jnp.asarray(1e-6), jnp.asarray(8.0), jnp.asarray(20.0)
    values = jnp.array([get(table2(), path) for path in PARAMETERS])
    capture = lambda d, s: _simulate.function((d, s, gain), duration, (rtol, rtol), _options(1000, 512, 0))  # noqa: E731
    gradient = lambda d, s: _gradients.function((d, s, duration, rtol), values, Static(PARAMETERS), None)  # noqa: E731
    assert split._cut(jax.make_jaxpr(capture)(design, scenario)) is None
    first, second = split._cut(jax.make_jaxpr(gradient)(design, scenario))
    loops = [sum(e.primitive.name == "custom_vmap_call" for e in part.jaxpr.eqns) for part in (first, second)]
    assert loops == [1, 0], "the time loop, one lane after the other under vmap, is in the first part alone"


def test_without_operations():
    program = compiled(lambda x: [x], (np.asarray(2.0),))
    assert len(program) == 1
    close(run(program, (np.asarray(2.0),)), [2.0])


def test_garbage_is_collected_again_afterwards():
    assert gc.isenabled()
    with pytest.raises(ZeroDivisionError):
        compiled(lambda x: [x / (1 // 0)], (np.asarray(2.0),))
    assert gc.isenabled()
