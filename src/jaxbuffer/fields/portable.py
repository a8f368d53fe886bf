"""Modules that travel between processes."""

from typing import Any

import equinox as eqx
import jax
import numpy as np


class Portable(eqx.Module):
    """A module that another process gets with the same numbers.

    JAX's arrays become single precision where a process unpickles them that has not called `jb.configure()`; NumPy's do
    not. So a pickle holds NumPy's.
    """

    def __getstate__(self) -> dict[str, Any]:
        def portable(leaf: Any) -> Any:
            known = isinstance(leaf, jax.Array) and not isinstance(leaf, jax.core.Tracer)
            return np.asarray(leaf) if known else leaf

        return {name: jax.tree.map(portable, value) for name, value in vars(self).items()}
