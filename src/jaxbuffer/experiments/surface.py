"""A response surface: a quantity as a smooth function of the sampled numbers, with its cross-validated error."""

import dataclasses
from collections import Counter
from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np
from jaxtyping import Float

from ..errors import InputError, check_choice, check_whole, shown, suggest
from ..fields import as_typed, in_unit
from ..tables import text
from ..value_text import percent_text, with_unit
from .ranges import Range
from .sample import Sample

KINDS = ("automatic", "quadratic", "gaussian_process")
FOLDS = 5
ENOUGH = 0.9  # of the variance of runs not seen: below that a surface is not to be trusted
EDGE = 1e-12  # of a range, for rounding
MANY = 0.05  # of the runs: more left out than these are warned of


class Error(NamedTuple):
    """What a surface misses at runs it was not fitted to: ``rms`` (root mean square) and ``largest`` in the quantity's
    unit; ``relative`` [-]: root mean square of the misses over the values; ``explained`` [-]: 1 - their mean square
    over the variance, at most 1."""

    rms: float
    largest: float
    relative: float
    explained: float


class Regressor(Protocol):
    """What scikit-learn calls a regressor."""

    def fit(self, x: np.ndarray, y: np.ndarray) -> Any: ...
    def predict(self, x: np.ndarray) -> np.ndarray: ...


@dataclasses.dataclass(frozen=True)
class Surface:
    """A fitted quantity. Print it for what it is worth.

    - ``quantity`` and its ``unit``; ``shown``: the unit in figures and how many of those a unit is.
    - ``axes``: the d ranges inside which it holds; ``run_name``: what a run is called.
    - ``kind``: "quadratic" or "gaussian_process"; ``errors``: the cross-validated `Error` of each kind tried.
    - ``logarithmic``: whether the logarithm is fitted, as is done where all values are positive.
    - ``computed``, ``predicted`` (m,): the values of the m runs it knows, and what the surface says of each when it is
      fitted without that run's fold.
    - ``left_out``: how many runs of each end are not in it, by reason.
    - ``model``: scikit-learn's, of the shares of the ranges.

    **Example:**

    >>> ranges = {"impact.stiffness": (1e10, 1e12), "scenario.height": (0.1, 0.2)}  # N/m^e, m
    >>> surface = jb.response_surface(jb.sample(jb.BarDrop(), jb.BarDropScenario(), ranges, count=32), "penetration")
    >>> surface.unit, len(surface.computed)
    ('m', 32)
    """

    quantity: str
    unit: str
    shown: tuple[str, float]
    run_name: str
    axes: tuple[Range, ...]
    kind: str
    errors: dict[str, Error]
    logarithmic: bool
    computed: Float[np.ndarray, " m"]
    predicted: Float[np.ndarray, " m"]
    left_out: dict[str, int]
    model: Regressor = dataclasses.field(repr=False)

    @property
    def error(self) -> Error:
        """Return the cross-validated error of the kind that was chosen."""
        return self.errors[self.kind]

    @property
    def trusted(self) -> bool:
        """Return whether it explains more than 90 % of the variance of runs it has not seen."""
        return self.error.explained > ENOUGH

    def predict(self, values: Mapping[str, Any]) -> Float[np.ndarray, " n"]:
        """Predict the quantity [``unit``] at some values.

        **Arguments:** ``values``: a number or an array (n,) for each path that was sampled, in its unit.

        **Raises:** `InputError` for paths that are missing or unknown, and values outside the ranges: a surface knows
        nothing beyond its sample.
        """
        paths = [axis.path for axis in self.axes]
        for path in values:
            if path not in paths:
                raise InputError(f"response surface: {path} was not sampled{suggest(path, paths)}")
        shares = [self._shares(axis, values) for axis in self.axes]
        try:
            places = np.stack(np.broadcast_arrays(*shares), axis=-1)
        except ValueError:
            raise InputError("response surface: the arrays of values must all have one length") from None
        predicted = self.model.predict(places)
        return np.exp(predicted) if self.logarithmic else predicted

    def _shares(self, axis: Range, values: Mapping[str, Any]) -> np.ndarray:
        if axis.path not in values:
            raise InputError(f"response surface: {axis.path} is missing; it was sampled and needs a value")
        read = in_unit(f"response surface: {axis.path}", values[axis.path], axis.unit)
        given = np.atleast_1d(np.asarray(read))
        if given.dtype.kind not in "iuf" or given.ndim != 1:
            raise InputError(
                f"response surface: {axis.path} = {shown(values[axis.path])} is not a number or an array (n,)"
            )
        edge = EDGE * (axis.high - axis.low)
        outside = ~((given >= axis.low - edge) & (given <= axis.high + edge))
        if outside.any():
            value = with_unit(*as_typed(float(given[outside][0]), axis.unit, axis.typed))
            raise InputError(
                f"response surface: {axis.path} = {value} is outside of what was sampled, {axis}; a surface knows"
                " nothing there, sample a wider range"
            )
        # Rounding may leave a value just beyond its end: it counts as at the end, since a surface knows nothing beyond.
        return np.clip(axis.shares(np.clip(given.astype(float), axis.low, axis.high)), 0.0, 1.0)

    @property
    def worth(self) -> str:
        """Say what the surface misses, and whether it is to be trusted."""
        share = percent_text(self.error.relative, ".3g")
        words = f"the surface misses {share} of a value it has not seen (cross-validated)"
        return words if self.trusted else f"{words} and is not to be trusted"

    def __repr__(self) -> str:
        words = self.kind.replace("_", " ")
        of_log = ", of the logarithm" if self.logarithmic else ""
        lines = [f"Response surface of {self.quantity}: {words}{of_log}, fitted to {len(self.computed)} runs"]
        for kind, error in sorted(self.errors.items(), key=lambda item: item[1].rms):
            mark = "" if len(self.errors) == 1 else (" (chosen)" if kind == self.kind else " (not taken)")
            lines.append(
                f"  cross-validated error of the {kind.replace('_', ' ')}{mark}: {error.rms:.4g} {self.unit} rms,"
                f" {percent_text(error.relative, '.3g')} of the value, {error.largest:.4g} {self.unit} at most;"
                f" {percent_text(error.explained, '.2f')} of the variance explained"
            )
        lines += [f"  holds inside {axis.path} {axis}" for axis in self.axes]
        total = sum(self.left_out.values())
        lines += [f"  left out: {count} {self.run_name}s, {reason}" for reason, count in self.left_out.items()]
        if total > MANY * (total + len(self.computed)):
            lines.append("  do not trust it near those: it is fitted as if they did not exist")
        if not self.trusted:
            lines.append("  do not trust it at all: it explains less than 90 % of the variance of runs it has not seen")
        return text(*lines)


def response_surface(
    sample: Sample, quantity: str | None = None, kind: str = "automatic", *, folds: int = FOLDS, seed: int = 0
) -> Surface:
    """Fit a quantity of a sample, and measure what the fit misses at runs it has not seen.

    **Arguments:**

    - ``sample``: runs that failed, or ended otherwise than they should, are left out and counted.
    - ``quantity``: one that samples have (default: the mechanism's main one); its logarithm is fitted where
      all its values are positive.
    - ``kind``: "quadratic" (a polynomial of order 2 in the ranges' shares), "gaussian_process" (Matérn covariance of
      order 5/2, a length a range, and noise), or "automatic": the one that misses less.
    - ``folds``: parts of the runs, each predicted by a fit to the others; shuffled with ``seed``.

    **Returns:** a `Surface`, fitted to all runs that are not left out.

    **Raises:** `InputError` for a quantity that is unknown, and where too few runs are left.

    **Source:** Rasmussen and Williams, *Gaussian Processes for Machine Learning*, chapters 2, 4 and 5; scikit-learn.

    **Example:** stiffness and drop height make the peak force, which is a product of their powers.

    >>> ranges = {"impact.stiffness": (1e10, 1e12), "scenario.height": (0.1, 0.2)}  # N/m^e, m
    >>> sample = jb.sample(jb.BarDrop(), jb.BarDropScenario(), ranges, count=32)
    >>> surface = jb.response_surface(sample, "penetration", "quadratic")
    >>> bool(surface.error.relative < 0.05), surface.predict({"impact.stiffness": 1e11, "scenario.height": 0.15}).shape
    (True, (1,))
    """
    from .regression import cross_validated, fitted  # scikit-learn takes more than a second to import

    check_choice("kind", kind, KINDS)
    check_whole("folds", folds, 2)
    quantity = sample.main_quantity if quantity is None else quantity
    values, good = sample.quantity(quantity), sample.succeeded
    good = good & np.isfinite(values)
    places, known, count = sample.grid.shares[good], values[good], len(sample.grid.axes)
    mechanism, needed = sample.mechanism, max(folds, (count + 1) * (count + 2))  # twice the terms of a quadratic
    if known.size < needed:
        left = f"{known.size} {mechanism.view.run_name}s are left to fit, and a surface of {count} numbers needs"
        raise InputError(f"response surface of {quantity}: {left} {needed}; take a larger sample")
    sample.check_varies(quantity, "response surface")
    # A product of powers, as an impact's force is, is linear in logarithms; and the surface is never negative.
    logarithmic = bool(np.all(known > 0.0))
    smooth = np.log(known) if logarithmic else known
    back = np.exp if logarithmic else np.asarray
    tried = KINDS[1:] if kind == "automatic" else (kind,)
    # Errors are those of the quantity itself, whether or not its logarithm is fitted.
    predictions = {name: back(cross_validated(name, places, smooth, folds, seed)) for name in tried}
    errors = {name: _error(known, predicted) for name, predicted in predictions.items()}
    chosen = min(errors, key=lambda name: errors[name].rms)
    return Surface(
        quantity=quantity,
        unit=mechanism.quantities[quantity].unit,
        shown=mechanism.quantities[quantity].in_figures,
        run_name=mechanism.view.run_name,
        axes=sample.grid.axes,
        kind=chosen,
        errors=errors,
        logarithmic=logarithmic,
        computed=known,
        predicted=predictions[chosen],
        left_out=_left_out(sample, good),
        model=fitted(chosen, places, smooth),
    )


def _left_out(sample: Sample, good: np.ndarray) -> dict[str, int]:
    """Count the runs that are not in the fit by the reason."""
    outcomes = sample.outcomes
    reasons = Counter(
        outcomes[k].reason if not (sample.succeeded[k]) else "the quantity is not a number"
        for k in np.flatnonzero(sample.done & ~good).tolist()
    )
    if waiting := int(np.sum(~sample.done)):
        reasons["not computed"] = waiting
    return dict(reasons)


def _error(known: np.ndarray, predicted: np.ndarray) -> Error:
    miss = predicted - known
    square = float(np.mean(miss**2))
    variance = float(np.var(known))
    # A value of zero has no relative error.
    nonzero = known != 0.0
    relative = float(np.sqrt(np.mean((miss[nonzero] / known[nonzero]) ** 2))) if nonzero.any() else float("nan")
    explained = 1.0 - square / variance if variance > 0.0 else float("nan")
    return Error(float(np.sqrt(square)), float(np.max(np.abs(miss))), relative, explained)
