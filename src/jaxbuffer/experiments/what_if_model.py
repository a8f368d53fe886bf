"""A model of one quantity in one load case, which a page evaluates: a quadratic, or a Gaussian process; and of how runs
end, by the runs around a place."""

import dataclasses
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

SMOOTH = 0.005  # the largest relative miss, each run left out in turn, up to which a quadratic is taken
SMALL = 1e-3  # of the largest value: below that a miss is relative to it
SQRT5 = 5.0**0.5


@dataclasses.dataclass(frozen=True)
class Model:
    """A model of a quantity by shares u (d,) of the ranges.

    Of a quadratic: ``constant`` + Σ ``linear``_i u_i + Σ ``square``_ij u_i u_j, j ≥ i. Of a Gaussian process:
    ``constant`` + Σ ``weights``_k m(|(u - u_k)/``lengths``|) over the n runs, m being Matérn's covariance of order 5/2,
    (1 + √5 r + 5 r²/3) exp(-√5 r). ``logarithmic``: that is the quantity's logarithm. ``error`` [-]: the largest
    relative miss of the runs kept apart; ``tested``: how many these are.
    """

    logarithmic: bool
    error: float
    tested: int
    constant: float
    linear: Float[np.ndarray, " d"] | None = None
    square: Float[np.ndarray, "d d"] | None = None
    lengths: Float[np.ndarray, " d"] | None = None
    weights: Float[np.ndarray, " n"] | None = None

    def at(self, share: Float[np.ndarray, " d"], shares: Float[np.ndarray, "n d"]) -> float:
        """Return the quantity at a place, by the places of the runs."""
        value = self.constant
        if self.linear is not None and self.square is not None:
            value += float(self.linear @ share + share @ self.square @ share)
        if self.lengths is not None and self.weights is not None:
            r = SQRT5 * np.sqrt(np.sum(((shares - share) / self.lengths) ** 2, axis=1))
            value += float(self.weights @ ((1.0 + r + r**2 / 3.0) * np.exp(-r)))
        return float(np.exp(value)) if self.logarithmic else value

    def record(self) -> dict[str, Any]:
        """Return the model as JSON has it."""
        arrays = {name: getattr(self, name) for name in ("linear", "square", "lengths", "weights")}
        numbers = {name: getattr(self, name) for name in ("logarithmic", "error", "tested", "constant")}
        return numbers | {name: array.tolist() for name, array in arrays.items() if array is not None}

    @classmethod
    def of(cls, record: Mapping[str, Any]) -> "Model":
        """Return the model of a record."""
        known: dict[str, Any] = {name: np.array(it) if isinstance(it, list) else it for name, it in record.items()}
        return cls(**known)


def fit(
    places: Float[np.ndarray, "m d"],
    values: Float[np.ndarray, " m"],
    apart: Float[np.ndarray, "t d"],
    truth: Float[np.ndarray, " t"],
    rows: Int[np.ndarray, " m"],
    runs: int,
) -> Model | None:
    """Fit a model to values at places, and measure what it misses at those kept ``apart``; None for too few.

    ``rows``: which of all ``runs`` the values are of.
    """
    count, d = places.shape
    if count < (d + 1) * (d + 2) or not len(truth):
        return None
    logarithmic = bool(np.all(values > 0.0))
    smooth = np.log(values) if logarithmic else values
    model = _quadratic(places, smooth, logarithmic)
    if model is None:
        model = _process(places, smooth, logarithmic, rows, runs)
    # The page has the places of all runs, of which those that are not fitted have a weight of zero.
    everywhere = np.zeros((runs, d))
    everywhere[rows] = places
    predicted = np.array([model.at(place, everywhere) for place in apart])
    largest = max(np.max(np.abs(values)), 1e-300)
    misses = np.abs(predicted - truth) / np.maximum(np.abs(truth), SMALL * largest)
    return dataclasses.replace(model, error=float(np.max(misses)), tested=len(truth))


def _quadratic(places: np.ndarray, smooth: np.ndarray, logarithmic: bool) -> Model | None:
    """Return the quadratic if it predicts each run well without it."""
    count, d = places.shape
    first, second = np.triu_indices(d)
    terms = np.column_stack([np.ones(count), places, places[:, first] * places[:, second]])
    # Orthonormal, so that the squared lengths of its rows say how much each run decides its own fitted value.
    basis, triangle = np.linalg.qr(terms)
    if np.min(np.abs(np.diag(triangle))) < 1e-10 * np.max(np.abs(triangle)):  # a range of no width
        return None
    coefficients = np.linalg.solve(triangle, basis.T @ smooth)
    # What each run's value is missed by where it alone is left out of the fit.
    misses = (smooth - terms @ coefficients) / np.maximum(1.0 - np.sum(basis**2, axis=1), 1e-6)
    # A difference of logarithms is a relative one already.
    scale = 1.0 if logarithmic else max(float(np.max(np.abs(smooth))), 1e-300)
    if np.max(np.abs(misses)) > SMOOTH * scale:
        return None
    square = np.zeros((d, d))
    square[first, second] = coefficients[d + 1 :]
    return Model(logarithmic, np.inf, 0, float(coefficients[0]), coefficients[1 : d + 1], square)


def _process(places: np.ndarray, smooth: np.ndarray, logarithmic: bool, rows: np.ndarray, runs: int) -> Model:
    from .regression import fitted  # scikit-learn takes more than a second to import

    process = fitted("gaussian_process", places, smooth)
    product = process.kernel_.k1
    mean, deviation = float(process._y_train_mean), float(process._y_train_std)
    weights = np.zeros(runs)
    weights[rows] = deviation * product.k1.constant_value * np.ravel(process.alpha_)
    lengths = np.broadcast_to(product.k2.length_scale, places.shape[1:]).astype(float)
    return Model(logarithmic, np.inf, 0, mean, lengths=lengths, weights=weights)


class Endings(NamedTuple):
    """How runs of one load case end: well where the nearest ``neighbours`` all ended well, for none of the runs kept
    apart contradicts that; ``confirmed``: how many of these lie at such places.

    Whether a run is held in time jumps with the last swing, so that one neighbour says little.
    """

    neighbours: int
    confirmed: int

    def well(
        self, at: Float[np.ndarray, " d"], shares: Float[np.ndarray, "n d"], succeeded: Bool[np.ndarray, " n"]
    ) -> bool:
        """Return whether a run at a place certainly ends well; at the place of a run, as that one did."""
        squares = np.sum((shares - at) ** 2, axis=1)
        nearest = int(np.argmin(squares))
        if squares[nearest] == 0.0:
            return bool(succeeded[nearest])
        return _successes(squares, succeeded) >= self.neighbours


def endings(
    shares: Float[np.ndarray, "n d"],
    succeeded: Bool[np.ndarray, " n"],
    apart: Float[np.ndarray, "m d"],
    ended_well: Bool[np.ndarray, " m"],
) -> Endings:
    """Return from how many neighbours on runs end well, by runs kept apart and whether these ended well."""
    squares = np.sum((apart[:, None, :] - shares[None, :, :]) ** 2, axis=2)
    successes = np.array([_successes(row, succeeded) for row in squares], int)
    # d + 1 runs can surround a place. Beyond that, more than around any run that ended otherwise.
    neighbours = max(shares.shape[1], *successes[~ended_well].tolist(), 0) + 1
    return Endings(neighbours, int(np.sum(successes >= neighbours)))


def _successes(squares: Float[np.ndarray, " n"], succeeded: Bool[np.ndarray, " n"]) -> int:
    """Return how many of the nearest runs ended well before the first one that did not."""
    ordered = succeeded[np.argsort(squares, kind="stable")]
    return len(ordered) if ordered.all() else int(np.argmin(ordered))
