"""A function in two parts, each a program of its own, computes what it computes whole."""

import gc

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from in_short import quick
from jaxbuffer.hybrid import AUTOMATIC, Options
from jaxbuffer.mechanisms.mechanism import Request
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.programs.cache import Static, _built, _run, after
from jaxbuffer.programs.load import all_ready
from jaxbuffer.programs.store import store_in
from jaxbuffer.run.simulate import _simulate
from jaxbuffer.run.stepper import CHECKED
from jaxbuffer.sensitivities.gradients import _gradients
from jaxbuffer.sweeps.chunk import solve_chunk


def steps(base, times, label):
    """base^times by a loop, and a number that is not an array."""
    start = jnp.ones(())
    power, _ = jax.lax.while_loop(lambda c: c[1] < times, lambda c: (c[0] * base, c[1] + 1), (start, jnp.zeros(())))
    return {"power": power, "steps": times, label.value: base}


@after(steps)
def report(base, times, label, peak):
    return base, peak["power"] * 2.0 + peak[label.value], label


def test_both_parts_together(tmp_path):
    for folder in (None, tmp_path, tmp_path):
        report.programs.clear()
        store_in(folder)
        base, peak, label = report(1.5, 4.0, Static("base"))
        assert (base, label.value) == (1.5, "base")
        assert peak == pytest.approx(1.5**4 * 2.0 + 1.5, rel=1e-15)
    assert [len(program.parts) for program in report.programs.values()] == [2]


def test_inside_other_transformations():
    """There it is one function, with derivatives."""
    twice = lambda base: report(base, 4.0, Static("base"))[1]  # noqa: E731
    value, slope = jax.jvp(twice, (1.5,), (1.0,))
    assert slope == pytest.approx(8.0 * 1.5**3 + 1.0, rel=1e-14)
    np.testing.assert_allclose(jax.vmap(twice)(jnp.array([1.5, 2.0])), [value, 34.0], rtol=1e-14)
    assert jax.jit(twice)(1.5) == pytest.approx(float(value), rel=1e-15)


def test_one_part():
    for keep in (False, True):
        parts, codes = _built([lambda x: [2.0 * x]], (np.asarray(2.0),), keep)
        assert len(parts) == 1 and len(codes) == keep
        assert _run(parts, (np.asarray(2.0),)) == [4.0]
    assert _run(all_ready(codes), (np.asarray(3.0),)) == [6.0]


@pytest.mark.parametrize("asked", quick([_simulate, _gradients, solve_chunk], _simulate))
def test_the_time_loop_is_in_the_first_program_alone(asked):
    design, scenario = (jax.tree.map(lambda x: jnp.asarray(x, float), x) for x in (jb.table2(), jb.Scenario()))
    rtol, duration, gain = jnp.asarray(1e-6), jnp.asarray(8.0), jnp.asarray(20.0)
    runs = jax.tree.map(lambda x: jnp.full(2, x), (design, scenario, duration))
    arguments = {
        _simulate: (
            Request(PROBE_CONE, (design, scenario, gain), duration, (rtol, rtol), Options(max_events=8)),
            CHECKED,
        ),
        _gradients: (
            *(PROBE_CONE, (design, scenario, duration, rtol), jnp.array([500.0]), Static(("buffer.k_A",))),
            *(AUTOMATIC, None),
        ),
        solve_chunk: (
            PROBE_CONE,
            runs,
            jnp.array([True, False]),
            rtol,
            gain,
            AUTOMATIC,
            Static(tuple(PROBE_CONE.swept)),
        ),
    }[asked]
    arrays, rest = eqx.partition(arguments, eqx.is_array)
    whole = lambda arrays: eqx.combine(arrays, rest)  # noqa: E731
    first, result = jax.make_jaxpr(lambda arrays: asked.first(*whole(arrays)), return_shape=True)(arrays)
    last = jax.make_jaxpr(lambda arrays, result: asked.last(*whole(arrays), result))(arrays, result)
    loops = [str(part).count("custom_vmap_call[") for part in (first, last)]
    assert loops[0] >= 1 and loops[1] == 0, "runs are stepped one by one: sequential_vmap"


def test_an_error_in_the_second_part_is_raised():
    with pytest.raises(ZeroDivisionError):
        _built([lambda x: [x + 1.0], lambda x, y: [x / (1 // 0)]], (np.asarray(2.0),), keep=False)


def test_garbage_is_collected_again_afterwards():
    assert gc.isenabled()
    with pytest.raises(ZeroDivisionError):
        _built([lambda x: [x / (1 // 0)]], (np.asarray(2.0),), keep=False)
    assert gc.isenabled()
