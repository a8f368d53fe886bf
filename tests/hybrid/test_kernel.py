"""The loop must stay one kernel: XLA leaves out any loop that holds a call into a library."""

import jax
import jax.numpy as jnp
import pytest

import jaxbuffer as jb
from jaxbuffer.hybrid import Automatic, DiagonallyImplicit, ExplicitRungeKutta, Options
from jaxbuffer.mechanisms.mechanism import Request
from jaxbuffer.mechanisms.registry import mechanism_of
from jaxbuffer.run.simulate import _simulate
from jaxbuffer.run.stepper import CHECKED


def compiled(design, scenario, solver):
    numbers = jax.tree.map(lambda x: jnp.asarray(x, float), (design, scenario, 20.0))
    options = jax.tree.map(lambda x: jnp.asarray(x, float), Options(solver=solver))
    given = Request(mechanism_of(design), numbers, jnp.asarray(8.0), (jnp.asarray(1e-6),) * 2, options)
    return _simulate.jitted.lower(given, CHECKED).compile().as_text()


# The automatic solver has the steps of both others in its loop. `make test` has the smallest mechanism alone.
EACH = [
    pytest.param(Automatic(), marks=pytest.mark.slow),
    *(pytest.param(it, marks=pytest.mark.long) for it in (ExplicitRungeKutta(), DiagonallyImplicit())),
]


def test_no_library_calls_of_a_bar():
    check(jb.BarDrop(), jb.BarDropScenario(), Automatic())


@pytest.mark.parametrize("solver", EACH)
def test_no_library_calls(solver):
    check(jb.table2(), jb.Scenario(), solver)


def check(design, scenario, solver):
    program = compiled(design, scenario, solver)
    assert " while(" in program
    inside = [line for line in program.splitlines() if "/while/" in line]
    assert len(inside) > 100
    for forbidden in (" custom-call(", " dot(", " scatter(", " fft(", " sort("):
        assert not [line for line in inside if forbidden in line]
