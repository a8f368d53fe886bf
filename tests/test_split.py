"""A function in two parts, each a program of its own, computes what it computes whole."""

import gc

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.compiling.programs import Static, after, store_in
from jaxbuffer.compiling.split import compiled, run


def steps(base, times, label):
    """base^times by a loop, and a number that is not an array."""
    start = jnp.ones(())
    power, _ = jax.lax.while_loop(lambda c: c[1] < times, lambda c: (c[0] * base, c[1] + 1), (start, jnp.zeros(())))
    return {"power": power, "steps": times, label.value: base}


@after(steps)
def report(base, times, label, found):
    return base, found["power"] * 2.0 + found[label.value], label


def test_both_parts_together(tmp_path):
    for folder in (None, tmp_path, tmp_path):
        report.programs.clear()
        store_in(folder)
        base, found, label = report(1.5, 4.0, Static("base"))
        assert (base, label.value) == (1.5, "base")
        assert found == pytest.approx(1.5**4 * 2.0 + 1.5, rel=1e-15)
    assert [len(program.parts) for program in report.programs.values()] == [2]


def test_inside_other_transformations():
    """There it is one function, with derivatives."""
    twice = lambda base: report(base, 4.0, Static("base"))[1]  # noqa: E731
    value, slope = jax.jvp(twice, (1.5,), (1.0,))
    assert slope == pytest.approx(8.0 * 1.5**3 + 1.0, rel=1e-14)
    np.testing.assert_allclose(jax.vmap(twice)(jnp.array([1.5, 2.0])), [value, 34.0], rtol=1e-14)
    assert jax.jit(twice)(1.5) == pytest.approx(float(value), rel=1e-15)


def test_one_part():
    program = compiled(lambda x: [2.0 * x], (np.asarray(2.0),))
    assert len(program) == 1
    assert run(program, (np.asarray(2.0),)) == [4.0]


def test_an_error_in_the_second_part_waits_for_the_first():
    with pytest.raises(ZeroDivisionError):
        compiled(lambda x, y: [x / (1 // 0)], (np.asarray(2.0),), lambda x: [x + 1.0])


def test_garbage_is_collected_again_afterwards():
    assert gc.isenabled()
    with pytest.raises(ZeroDivisionError):
        compiled(lambda x: [x / (1 // 0)], (np.asarray(2.0),))
    assert gc.isenabled()
