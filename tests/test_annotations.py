"""Shapes in annotations are checked while tests run (`--jaxtyping-packages` in pyproject.toml)."""

import jax.numpy as jnp
import jaxtyping
import pytest

from jaxbuffer.integrate.stride import Stride
from jaxbuffer.mechanisms.assembly import N
from jaxbuffer.multibody import Kinematics, inverse


def test_a_wrong_shape_is_refused():
    """Of arguments, and of sizes that must agree."""
    with pytest.raises(jaxtyping.TypeCheckError, match="inverse"):
        inverse(jnp.ones((2, 3)))
    with pytest.raises(jaxtyping.TypeCheckError, match="after"):
        Stride.after(jnp.zeros(2), jnp.zeros(()))
    with pytest.raises(jaxtyping.TypeCheckError, match="Kinematics"):
        Kinematics(jnp.zeros(N), jnp.zeros(N + 1))
