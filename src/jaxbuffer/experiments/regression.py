"""Fits of response surfaces by scikit-learn: a module of its own, because that takes more than a second to import."""

import warnings

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Kernel, Matern, WhiteKernel
from sklearn.linear_model import LinearRegression
from sklearn.pipeline import Pipeline, make_pipeline
from sklearn.preprocessing import PolynomialFeatures

TUNED_ON = 512  # runs at most by which a Gaussian process' lengths are found; all runs are fitted with them


def cross_validated(kind: str, places: np.ndarray, values: np.ndarray, folds: int, seed: int) -> np.ndarray:
    """Return what each run's value is by a fit to the other folds."""
    # Shuffled, since a sample's runs may be in an order: those of Saltelli's scheme are.
    order = np.random.default_rng(seed).permutation(len(values))
    predicted = np.empty(len(values))
    for part in np.array_split(order, folds):
        others = np.setdiff1d(order, part)
        predicted[part] = fitted(kind, places[others], values[others]).predict(places[part])
    return predicted


def fitted(kind: str, places: np.ndarray, values: np.ndarray) -> Pipeline | GaussianProcessRegressor:
    """Fit a quadratic or a Gaussian process to values (n,) at places (n, ranges)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # a length at its bound: a number that has no influence
        if kind == "quadratic":
            terms = PolynomialFeatures(2, include_bias=False)
            return make_pipeline(terms, LinearRegression()).fit(places, values)
        ranges = places.shape[1]
        # Each try of some lengths costs the cube of the number of runs.
        some = _process(ranges).fit(places[:TUNED_ON], values[:TUNED_ON])
        return some if len(values) <= TUNED_ON else _process(ranges, some.kernel_).fit(places, values)


def _process(ranges: int, kernel: Kernel | None = None) -> GaussianProcessRegressor:
    """Make a Gaussian process; with a ``kernel`` its lengths are not looked for."""
    if kernel is not None:
        return GaussianProcessRegressor(kernel, optimizer=None, normalize_y=True)
    lengths = Matern(np.ones(ranges), (0.05, 100.0), nu=2.5)
    noise = WhiteKernel(1e-4, (1e-10, 1.0))
    return GaussianProcessRegressor(ConstantKernel(1.0, (1e-3, 1e5)) * lengths + noise, normalize_y=True)
