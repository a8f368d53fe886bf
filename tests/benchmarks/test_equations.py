"""How much of a program runs once, in equations: each of them is compiled, and none of them is in the loop that steps.

A mechanism's equations are traced once for a program's start and once for the instants that are read off. One more copy
of them, a few hundred to two thousand equations, goes beyond these limits.
"""

import jax
import jax.numpy as jnp
import pytest

import jaxbuffer as jb
from benchmarks.equations import Case, Size, cases, programs, size_of

MOST = {  # outside of the loop: a run's two programs together, and one of jax.grad
    "capture": (4_250, 7_900),
    "docking": (5_550, 10_900),
    "slider_crank": (3_300, 6_550),
    "bar_drop": (2_000, 2_800),
}


@pytest.fixture(scope="module")
def known() -> dict[str, Case]:
    jb.configure()
    return cases()


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name == "bar_drop" else pytest.mark.slow) for name in MOST]
)
def test_what_a_run_compiles_to_run_once(known, name):
    made = programs(known[name])
    stepping, reading = (made[f"run, {part}"] for part in ("stepping", "reading off"))
    before, after = size_of(stepping[0], *stepping[1]), size_of(reading[0], *reading[1], once=True)
    assert before.outside + after.outside <= MOST[name][0]
    assert before.outside < 0.15 * before.loop


@pytest.mark.slow
@pytest.mark.parametrize("name", ["capture", "bar_drop"])
def test_what_a_gradient_compiles_to_run_once(known, name):
    function, arguments = programs(known[name])["jax.grad"]
    assert size_of(function, *arguments).outside <= MOST[name][1]


def test_equations_are_counted_where_they_run():
    """Four in the longer loop, its condition among them; a shorter loop and a scan count once each; calls, and what
    nothing uses, do not."""

    def program(x):
        jnp.tanh(x)
        x = jax.jit(lambda x: x * 2.0 + 1.0)(x)
        x, _ = jax.lax.scan(lambda x, _: (jnp.sin(x), None), x, None, length=5)
        x = jax.lax.while_loop(lambda x: x < 3.0, lambda x: x + 1.0, x)
        return jax.lax.while_loop(lambda x: x < 9.0, lambda x: jnp.cos(x) * x + 1.0, x) - 1.0

    assert size_of(program, 1.0) == Size(loop=4, outside=2 + 1 + 2 + 1)
    assert size_of(program, 1.0, once=True) == Size(loop=0, outside=10)
