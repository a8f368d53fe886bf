"""When a quantity is largest: not known of one that is rounding."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from jaxbuffer.hybrid import Kind
from jaxbuffer.mechanisms.quantity import Quantity
from jaxbuffer.mechanisms.run import Run


@pytest.mark.quick
def test_an_extension_of_an_atom_s_width_is_reached_at_no_time():
    of = lambda name: Quantity("m", lambda run: run.maxima[name], name)  # noqa: E731
    run = SimpleNamespace(
        _many=False,
        maxima={"stroke": 0.012, "extension": 6e-16, "force": 2e-12},
        mechanism=SimpleNamespace(quantities={"stroke": of("stroke"), "extension": of("extension")}),
        _observed=("stroke", "extension", "force"),
        _located=SimpleNamespace(
            count=3,
            time=np.array([0.0, 1.5, 4.0]),
            values=np.array([[0.0, 0.0, 0.0], [0.001, 6e-16, 2e-12], [0.012, 0.0, 0.0]]),
            kind=np.full(3, int(Kind.PEAK)),
        ),
    )
    times = Run.maximum_times.fget(run)
    # Of the force no quantity says what is rounding.
    assert times["stroke"] == 4.0 and math.isnan(times["extension"]) and times["force"] == 1.5
