"""Types shared by every room."""

import enum
from collections.abc import Sequence
from typing import TYPE_CHECKING, NewType

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

if TYPE_CHECKING:  # an int is a float there, and NumPy's arrays are not told apart from JAX's
    Scalar = Float[Array, ""] | float
else:
    Scalar = Float[Array | np.ndarray, ""] | float | int
"""A real number: Python's or NumPy's at construction, a 0-d array (or tracer) inside compiled code."""


class Code(enum.IntEnum):
    """An integer that prints itself by name: for codes that compiled code compares, and people read."""

    def __str__(self) -> str:
        return self.name

    def __format__(self, spec: str) -> str:
        return format(int(self), spec) if spec[-1:] in tuple("bcdoxXneEfFgG%") else format(self.name, spec)


Values = Float[Array, "*batch"]
"""One number, or an array of them treated together (a cone's flanks)."""


def stacked(values: Sequence[Scalar]) -> Float[Array, " n"]:
    """Scalars, Python's or traced, as one array."""
    return jnp.stack([jnp.asarray(value, float) for value in values])


if TYPE_CHECKING:
    from diffrax import AbstractERK, AbstractSolver
    from matplotlib.axes import Axes
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure
    from matplotlib.text import Text
    from pandas import DataFrame
    from xarray import Dataset
else:  # these packages take long to import, and most calls need none of them

    def _named(module, name):
        """Return a type that has another one's name and stands for any object."""
        kind = NewType(name, object)
        kind.__module__ = module
        return kind

    AbstractERK, AbstractSolver = _named("diffrax", "AbstractERK"), _named("diffrax", "AbstractSolver")
    Axes, PolyCollection = _named("matplotlib.axes", "Axes"), _named("matplotlib.collections", "PolyCollection")
    Figure, Text = _named("matplotlib.figure", "Figure"), _named("matplotlib.text", "Text")
    DataFrame, Dataset = _named("pandas", "DataFrame"), _named("xarray", "Dataset")
