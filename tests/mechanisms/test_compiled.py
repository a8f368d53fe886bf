"""The equations of motion compile into one kernel: nothing in them becomes a library call."""

import jax
import jax.numpy as jnp
import pytest

from in_short import quick
from mechanisms.states import mechanism, pressed

# What XLA hands to a library or refuses to fuse into a loop's single kernel.
FORBIDDEN = ("dot_general", "scatter", "cholesky", "triangular_solve", " lu[", "sort", "fft", "custom_call", "callback")

each_tip = pytest.mark.parametrize("free", quick([False, True], False), ids=["welded tip", "free tip"])


def programs(free):
    assembled = mechanism(free)
    state, active = pressed(assembled, "lower flank", 0)

    def derivative(state):
        return assembled.derivative(jnp.zeros(()), state, active)

    def push(state, move):
        return jax.jvp(derivative, (state,), (move,))

    return jax.make_jaxpr(derivative)(state), jax.make_jaxpr(push)(state, state)


@pytest.mark.quick
@each_tip
def test_derivative_and_its_push_forward_use_plain_operations_only(free):
    for program in programs(free):
        text = str(program)
        assert "mul" in text
        assert not [name for name in FORBIDDEN if name in text]


def test_the_list_would_catch_a_solve():
    text = str(jax.make_jaxpr(jnp.linalg.solve)(jnp.eye(3), jnp.ones(3)))
    assert [name for name in FORBIDDEN if name in text]
