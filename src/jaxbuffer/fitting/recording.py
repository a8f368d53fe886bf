"""A measured test: what was recorded when, by which sensors, in which scenario."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float

from ..errors import InputError, as_number, check_number, check_type, shown
from ..fields import NON_NEGATIVE, POSITIVE, Part, check_units_agree, in_unit
from ..tuning.problem.variable import Variable

Bounds = Any  # a number, a text with a unit, or two of them for an unknown between them


@dataclasses.dataclass(frozen=True)
class Channel:
    """A sensor, and the quantity that it records.

    **Arguments:**

    - ``quantity``: a history's name, such as "stroke" or "active_acceleration_x" (`jb.recorded_quantities` has them).
    - ``noise``: standard deviation of the sensor's noise, in the quantity's unit or with one; None: estimated.
    - ``gain``: by which the sensor multiplies [-]: a number, or two bounds of an unknown one.
    - ``offset``: which the sensor adds besides, likewise, in the quantity's unit or with one.
    - ``filter``: time constant of the sensor's first-order low-pass [s], likewise.
    - ``delay``: by which the sensor is late besides [s], likewise; None: 0, but unknown within half an interval between
      rows where the filter is unknown: digital filters are late or early by up to half an interval of their own.

    **Example:**

    >>> jb.Channel("stroke", noise="0.02 mm").quantity
    'stroke'
    """

    quantity: str
    noise: Any = None
    gain: Bounds = 1.0
    offset: Bounds = 0.0
    filter: Bounds = 0.0
    delay: Bounds | None = None


@dataclasses.dataclass(frozen=True)
class Recording:
    """A measured test. `jb.read_recording` reads one from a file.

    **Arguments:**

    - ``name``: of the test, in tables and messages.
    - ``times``: rising [s].
    - ``values``: an array (rows,) for each channel, by the column's name, in SI units.
    - ``channels``: the sensor of each column, by its name.
    - ``scenario``: this test's own; None: that of the fit.
    - ``lines``: of the rows in their file; () where there is none.
    - ``time_shift``: by how much the record's time is ahead of the simulated one [s]: a number, or two bounds.

    **Raises:** `InputError` for arrays that do not fit each other and numbers out of range.

    **Example:**

    >>> import numpy as np
    >>> times = np.linspace(0.0, 0.1, 50)
    >>> test = jb.Recording("drop", times, {"gap": 0.2 - 4.9 * times**2}, {"gap": jb.Channel("gap_plate")})
    >>> len(test.times)
    50
    """

    name: str
    times: Float[np.ndarray, " rows"]
    values: Mapping[str, Float[np.ndarray, " rows"]]
    channels: Mapping[str, Channel]
    scenario: Part | None = None
    time_shift: Bounds = 0.0
    lines: tuple[int, ...] = dataclasses.field(default=(), repr=False)

    def __post_init__(self) -> None:
        times = np.asarray(in_unit(f"{self.name}: times", self.times, "s"), float)
        object.__setattr__(self, "times", times)
        if times.ndim != 1 or len(times) < 2 or not np.all(np.isfinite(times)) or np.any(np.diff(times) <= 0.0):
            raise InputError(f"{self.name}: times must be two or more finite numbers that rise")
        if not self.channels:
            raise InputError(f"{self.name}: no channel is given; name the columns to fit, each with a quantity")
        for column, channel in self.channels.items():
            check_type(f"{self.name}: {column}", channel, Channel, 'jb.Channel("stroke")')
            if column not in self.values:
                raise InputError(f"{self.name}: there are no values of {column}")
            values = np.asarray(self.values[column], float)
            if values.shape != times.shape or not np.all(np.isfinite(values)):
                raise InputError(f"{self.name}: {column} must be {len(times)} finite numbers, one for each time")

    def row(self, number: int) -> str:
        """Return a row as a message names it: by its line in the file, if it is from one."""
        return f"{self.name}, line {self.lines[number]}" if self.lines else f"{self.name}, row {number}"


def bounds(where: str, given: Bounds, unit: str, **limits: Any) -> float | Variable:
    """Return a number, or a variable between two bounds that are given. **Raises:** `InputError` for anything else."""
    if isinstance(given, (list, tuple)):
        check_units_agree(where, given)
        ends = [as_number(in_unit(where, end, unit, **limits)) for end in given]
        if len(ends) != 2 or not all(type(end) is float for end in ends):
            raise InputError(f"{where} = {shown(given)} must be a number or [low, high] in {unit}")
        for end in ends:
            check_number(where, end, unit, **limits)
        if not ends[0] < ends[1]:
            raise InputError(f"{where} = {shown(given)}: the low bound must be below the high one")
        # Linear, because a shift or a delay may be negative, and a time constant zero.
        return Variable(where, ends[0], ends[1], "linear")
    number = as_number(in_unit(where, given, unit, **limits))
    check_number(where, number, unit, **limits)
    return float(number)


def noise_of(where: str, channel: Channel, unit: str) -> float | None:
    """Return the standard deviation of a channel's noise in the quantity's unit, None where it is not known."""
    if channel.noise is None:
        return None
    number = as_number(in_unit(where, channel.noise, unit, **POSITIVE))
    check_number(where, number, unit, **POSITIVE)
    return float(number)


GAIN, FILTER = POSITIVE, NON_NEGATIVE
