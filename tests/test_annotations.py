"""Shapes in annotations are checked while tests run (`--jaxtyping-packages` in pyproject.toml)."""

import importlib.util

import jax.numpy as jnp
import jaxtyping
import pytest

from jaxbuffer.hybrid.rungekutta.time_transform import TimeTransform
from jaxbuffer.multibody import Kinematics
from jaxbuffer.plane import inverse


def test_a_wrong_shape_is_refused():
    """Of arguments, and of sizes that must agree."""
    with pytest.raises(jaxtyping.TypeCheckError, match="inverse"):
        inverse(jnp.ones((2, 3)))
    with pytest.raises(jaxtyping.TypeCheckError, match="after_touchdown"):
        TimeTransform.after_touchdown(jnp.zeros(2), jnp.zeros(()))
    with pytest.raises(jaxtyping.TypeCheckError, match="Kinematics"):
        Kinematics(jnp.zeros(12), jnp.zeros(13))


def test_every_module_on_the_list_is_there(pytestconfig):
    """One that is not would be passed over without a word."""
    *listed, checker = pytestconfig.getoption("jaxtyping_packages").split(",")
    assert checker == "beartype.beartype" and "jaxbuffer.plane" in listed
    assert [name for name in listed if importlib.util.find_spec(name) is None] == []
