"""Labelled arrays and data frames from named columns. xarray and pandas are imported when a result is converted."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from .._types import DataFrame, Dataset


class Labelled(NamedTuple):
    """An array with its axes' names.

    - ``dims``: a name an axis; none for a single number.
    - ``values``: of that many axes, numbers or words.
    - ``unit``: of the numbers, "-" for none, "" of words.
    - ``description``: what it is, in a line.
    """

    dims: tuple[str, ...]
    values: Any
    unit: str = ""
    description: str = ""


def dataset(
    variables: Mapping[str, Labelled], coordinates: Mapping[str, Labelled], attributes: Mapping[str, Any]
) -> Dataset:
    """Return a dataset; units and descriptions become the attributes ``units`` and ``long_name``, as in the CF
    conventions.

    **Arguments:** ``variables``, ``coordinates``: by name; ``attributes``: of the whole, words and numbers.

    **Example:**

    >>> from jaxbuffer.labelled.arrays import Labelled, dataset
    >>> speeds = Labelled(("speed",), [0.1, 0.2], "m/s")
    >>> found = dataset({"force": Labelled(("speed",), [253.0, 325.0], "N")}, {"speed": speeds}, {"title": "two runs"})
    >>> float(found.force.sel(speed=0.2)), found.force.units, found.speed.units
    (325.0, 'N', 'm/s')
    """
    import xarray as xr

    return xr.Dataset(
        {name: _variable(it) for name, it in variables.items()},
        {name: _variable(it) for name, it in coordinates.items()},
        dict(attributes),
    )


def _variable(it: Labelled) -> tuple[Any, ...]:
    attributes = {"units": it.unit, "long_name": it.description}
    return it.dims, np.asarray(it.values), {name: text for name, text in attributes.items() if text}


def frame(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> DataFrame:
    """Return a data frame with these rows; the header's names have their units, as in ``"stroke [m]"``."""
    import pandas as pd

    return pd.DataFrame(list(rows), columns=list(header))
