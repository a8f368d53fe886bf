"""Measured curves: points that rise in both numbers, and the monotone cubic through them and (0, 0).

Between points it is the cubic of Fritsch and Carlson (SIAM J. Numer. Anal. 17, 1980) with the slopes that SciPy's
`PchipInterpolator` takes; beyond the last point and before (0, 0) it goes on straight.
"""

import re
from collections.abc import Iterator, Mapping
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from .._types import Scalar, stacked
from ..errors import InputError, concrete, inside, shown
from .portable import Portable
from .shown import full_text
from .units import POSITIVE, as_unit, in_unit

Axis = tuple[str, str]  # name and unit
_POINT = re.compile(r"(\w+)\[(\d+)\]")


class Curve(Portable):
    """A measured curve through (0, 0).

    Each number is a leaf of its own, so that it has an address (``force[2]``), bounds and derivatives.

    - ``places``: where the points are.
    - ``values``: what was measured there.
    - ``axes``: name and unit of both.
    """

    places: tuple[Scalar, ...]
    values: tuple[Scalar, ...]
    axes: tuple[Axis, Axis] = eqx.field(static=True)

    @staticmethod
    def of(value: Any, axes: tuple[Axis, Axis]) -> Any:
        """Return the curve of a list of points; any other value as it is, for the check that names its field."""
        points = list(value) if isinstance(value, (list, tuple, np.ndarray)) else []
        if not points or not all(isinstance(it, (list, tuple, np.ndarray)) and len(it) == 2 for it in points):
            return value
        places, values = (tuple(as_unit(it[k], axes[k][1]) for it in points) for k in range(2))
        return Curve(places, values, axes)

    def check(self, path: str) -> None:
        """Raise `InputError` unless all numbers are positive and rise. ``path``: the curve's, as shown to the user."""
        for (name, unit), numbers in zip(self.axes, (self.places, self.values), strict=True):
            for k, number in enumerate(numbers):
                in_unit(f"{path}.{name}[{k}]", number, unit, **POSITIVE)
                if (array := concrete(number)) is None and isinstance(number, (str, bool, type(None))):
                    raise InputError(f"{path}.{name}[{k}]: {shown(number)} is not a number in {unit}")
                # (0, 0) is a point of every curve, and the first one given must be above it.
                before = np.zeros(()) if k == 0 else concrete(numbers[k - 1])
                if array is None or before is None:  # traced
                    continue
                if not np.all(inside(array, **POSITIVE) & (array > before)):
                    after = "0" if k == 0 else f"{name}[{k - 1}] = {float(before.flat[0]):g} {unit}"
                    raise InputError(
                        f"{path}.{name}[{k}] = {float(array.flat[0]):g} {unit} must be above {after}:"
                        " a curve's points rise in both numbers, and (0, 0) is understood"
                    )

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        """Yield whether each number is above the one before it, for numbers known only inside compiled code."""
        for numbers in (self.places, self.values):
            for k, number in enumerate(numbers):
                yield inside(number, low=0.0 if k == 0 else numbers[k - 1], low_open=True)

    def points(self) -> list[list[Any]]:
        """Return the points as a study writes them."""
        return [list(point) for point in zip(self.places, self.values, strict=True)]

    def __repr__(self) -> str:
        points = (", ".join(map(full_text, point)) for point in self.points())
        return "[" + ", ".join(f"[{point}]" for point in points) + "]"

    # --- addresses of its numbers -------------------------------------------------------------------------------------

    def addresses(self) -> list[str]:
        """Return the address of each number within the curve: "force[2]"."""
        return [f"{name}[{k}]" for name, _ in self.axes for k in range(len(self.places))]

    def value_addresses(self) -> list[str]:
        """Return the addresses of what was measured."""
        return self.addresses()[len(self.places) :]

    def following(self, address: str) -> str | None:
        """Return the address of the number that must be larger than the one at an address; None for the last."""
        axis, k = self._find(address)
        return f"{self.axes[axis][0]}[{k + 1}]" if k + 1 < len(self.places) else None

    def _find(self, address: str) -> tuple[int, int]:
        """Return the axis and index of an address."""
        match = _POINT.fullmatch(address)
        assert match is not None
        return [name for name, _ in self.axes].index(match[1]), int(match[2])

    def get(self, address: str) -> Any:
        """Return the number at an address."""
        axis, k = self._find(address)
        return (self.places, self.values)[axis][k]

    def replaced(self, values: Mapping[str, Any]) -> "Curve":
        """Return the curve with other numbers at some addresses."""
        columns = [list(self.places), list(self.values)]
        for address, value in values.items():
            axis, k = self._find(address)
            columns[axis][k] = as_unit(value, self.axes[axis][1])
        return Curve(tuple(columns[0]), tuple(columns[1]), self.axes)

    def cubic(self) -> "MonotoneCubic":
        """Return the cubic through (0, 0) and all points."""
        x, y = stacked([0.0, *self.places]), stacked([0.0, *self.values])
        h = x[1:] - x[:-1]
        secant = (y[1:] - y[:-1]) / h
        # Two points have a straight line between them.
        if len(self.places) == 1:
            return MonotoneCubic(x, y, jnp.concatenate([secant, secant]))
        # the weighted harmonic mean of the secants beside a point; at both ends a one-sided parabola's slope
        before, after = 2.0 * h[1:] + h[:-1], h[1:] + 2.0 * h[:-1]
        inner = (before + after) / (before / secant[:-1] + after / secant[1:])
        first, last = _end_slope(h[0], h[1], secant[0], secant[1]), _end_slope(h[-1], h[-2], secant[-1], secant[-2])
        return MonotoneCubic(x, y, jnp.concatenate([first[None], inner, last[None]]))


class MonotoneCubic(Portable):
    """A piecewise cubic by its ``places``, its ``values`` and its ``slopes`` there, straight beyond its ends."""

    places: Float[Array, " points"]
    values: Float[Array, " points"]
    slopes: Float[Array, " points"]

    def value(self, at: Scalar) -> Float[Array, ""]:
        """Return the value at a place."""
        return self._summed(at)[0]

    def integral(self, at: Scalar) -> Float[Array, ""]:
        """Return the integral from the first place to a place."""
        return self._summed(at)[1]

    def _summed(self, at: Scalar) -> tuple[Array, Array]:
        """Return value and integral as sums over all pieces of what each adds up to the place, so that no piece is
        looked up."""
        x, y, slope = self.places, self.values, self.slopes
        h, rise = x[1:] - x[:-1], y[1:] - y[:-1]
        # A point belongs to the piece after it: clipping would count half the slopes of both there, and with rounding
        # one and a half.
        t = jnp.where(at < x[:-1], 0.0, jnp.where(at >= x[1:], 1.0, (at - x[:-1]) / h))
        m0, m1 = h * slope[:-1], h * slope[1:]
        c2, c3 = 3.0 * rise - 2.0 * m0 - m1, m0 + m1 - 2.0 * rise
        before, beyond = jnp.where(at < x[0], at - x[0], 0.0), jnp.where(at >= x[-1], at - x[-1], 0.0)
        value = y[0] + jnp.sum(t * (m0 + t * (c2 + t * c3))) + slope[0] * before + slope[-1] * beyond
        # The value at the start of a piece counts as far as the piece is passed.
        passed = h * t * (y[:-1] + t * (m0 / 2.0 + t * (c2 / 3.0 + t * c3 / 4.0)))
        straight = before * (y[0] + 0.5 * slope[0] * before) + beyond * (y[-1] + 0.5 * slope[-1] * beyond)
        return value, jnp.sum(passed) + straight


def number_metadata(axes: tuple[Axis, Axis], address: str) -> Mapping[str, Any]:
    """Return what a declared field has, unit, range and meaning, for the number at an address of any curve."""
    match = _POINT.fullmatch(address)
    assert match is not None
    name, unit = next(axis for axis in axes if axis[0] == match[1])
    return {"unit": unit, "limits": POSITIVE, "doc": f"{name} of point {int(match[2]) + 1} of the curve"}


def _end_slope(own: Array, other: Array, secant: Array, next_secant: Array) -> Float[Array, ""]:
    """Return the slope at an end, from the two pieces nearest to it; it is never negative, as all secants rise."""
    return jnp.maximum(((2.0 * own + other) * secant - own * next_secant) / (own + other), 0.0)


def curve(place: Axis, value: Axis, *, instead_of: tuple[str, ...] = (), doc: str = "") -> Any:
    """Declare a field that takes a measured curve, as a list of points; None if there is none.

    **Arguments:** ``place``, ``value``: name and unit of both numbers of a point; ``instead_of``: the fields beside it
    that it stands for; ``doc``: as of `number`.
    """
    axes = (place, value)

    def check(path: str, given: Any) -> None:
        if given is None:
            return
        if not isinstance(given, Curve):
            (x, unit), (y, other) = axes
            raise InputError(
                f"{path} = {shown(given)} is not a curve; write a list of points [{x} [{unit}], {y} [{other}]],"
                " rising in both: [[0.01, 2.0], [0.02, 6.0]] say"
            )
        given.check(path)

    metadata = {"curve": axes, "check": check, "instead_of": instead_of, "doc": doc}
    return eqx.field(default=None, converter=lambda given: Curve.of(given, axes), metadata=metadata)
