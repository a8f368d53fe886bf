"""Models around a design, against functions that are known and scikit-learn's own prediction."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

from jaxbuffer.experiments.regression import fitted
from jaxbuffer.experiments.what_if_model import Model, endings, fit

RNG = np.random.default_rng(3)
PLACES, APART = RNG.random((60, 3)), RNG.random((30, 3))
EVERY = np.arange(60)


def kinked(u):
    """The larger of two forces, as of two impacts [N]."""
    return 100.0 * np.maximum(np.exp(0.6 * u[..., 0] - 0.3 * u[..., 1]), 1.1 + 0.4 * u[..., 2] * u[..., 1])


def jumping(u):
    return 100.0 + 40.0 * (u[..., 0] + 0.3 * u[..., 1] > 0.7)


def measured(model, function):
    """The largest relative miss at the places kept apart."""
    predicted = np.array([model.at(place, PLACES) for place in APART])
    return np.max(np.abs(predicted / function(APART) - 1.0))


def test_a_quadratic_is_found_exactly():
    def function(u):
        return -2.0 + 3.0 * u[..., 0] - u[..., 1] + 0.5 * u[..., 0] * u[..., 2] + 4.0 * u[..., 1] ** 2

    model = fit(PLACES, function(PLACES), APART, function(APART), EVERY, 60)
    assert model.weights is None and not model.logarithmic
    assert_allclose([model.at(it, PLACES) for it in APART], function(APART), atol=1e-12)
    assert model.error < 1e-9 and model.tested == 30


def test_a_product_of_powers_is_one_of_logarithms():
    def function(u):
        return 7.0 * np.exp(0.4 * u[..., 0] - 1.2 * u[..., 2])

    model = fit(PLACES, function(PLACES), APART, function(APART), EVERY, 60)
    assert model.logarithmic and model.weights is None and model.error < 1e-12


def test_a_kink_takes_a_gaussian_process_whose_error_is_that_of_runs_kept_apart():
    model = fit(PLACES, kinked(PLACES), APART, kinked(APART), EVERY, 60)
    assert model.weights is not None
    independent = np.exp(fitted("gaussian_process", PLACES, np.log(kinked(PLACES))).predict(APART))
    assert_allclose([model.at(it, PLACES) for it in APART], independent, rtol=1e-9)
    assert model.error == pytest.approx(measured(model, kinked), rel=1e-12)
    assert 1e-4 < model.error < 0.1


def test_a_jump_shows_in_the_error():
    model = fit(PLACES, jumping(PLACES), APART, jumping(APART), EVERY, 60)
    assert model.error > 0.1 and model.error == pytest.approx(measured(model, jumping), rel=1e-12)


def test_runs_that_failed_are_in_no_model():
    """Their places stay in the list, with no weight."""
    good = PLACES[:, 0] < 0.8
    model = fit(PLACES[good], kinked(PLACES[good]), APART, kinked(APART), EVERY[good], 60)
    assert model.weights.shape == (60,) and not np.any(model.weights[~good])
    independent = np.exp(fitted("gaussian_process", PLACES[good], np.log(kinked(PLACES[good]))).predict(APART))
    assert_allclose([model.at(it, PLACES) for it in APART], independent, rtol=1e-9)


def test_what_is_always_the_same_is_a_number():
    model = fit(PLACES, np.zeros(60), APART, np.zeros(30), EVERY, 60)
    assert model.at(APART[0], PLACES) == 0.0 and model.error == 0.0


def test_too_few_runs_make_none():
    assert fit(PLACES[:19], kinked(PLACES[:19]), APART, kinked(APART), EVERY[:19], 60) is None
    assert fit(PLACES, kinked(PLACES), APART[:0], kinked(APART[:0]), EVERY, 60) is None


@pytest.mark.parametrize("function", [kinked, lambda u: 1.0 + u[..., 0]])
def test_a_record_is_read_back(function):
    model = fit(PLACES, function(PLACES), APART, function(APART), EVERY, 60)
    again = Model.of(json.loads(json.dumps(model.record())))
    assert [again.at(it, PLACES) for it in APART] == [model.at(it, PLACES) for it in APART]
    assert again.error == model.error


def test_where_runs_are_said_to_end_well_they_do():
    """Of a margin that waves, at 2000 places that nobody has seen: the nearest run alone is wrong far more often."""

    def held(u):
        return 0.3 + np.sin(9.0 * u[:, 0]) * np.cos(7.0 * u[:, 1]) + 0.2 * u[:, 2] > 0.0

    rng = np.random.default_rng(3)
    shares, apart, places = rng.random((128, 3)), rng.random((64, 3)), rng.random((2000, 3))
    found = endings(shares, held(shares), apart, held(apart))
    said = np.array([found.well(place, shares, held(shares)) for place in places])
    alone = np.array([held(shares)[np.argmin(np.sum((shares - place) ** 2, axis=1))] for place in places])
    wrong, wrong_alone = (float(np.mean(~held(places)[of])) for of in (said, alone))
    assert wrong < 0.03 and wrong_alone > 0.06
    assert np.sum(said) > 200 and found.confirmed > 5
    # At a run's own place it is as that run was.
    assert [found.well(place, shares, held(shares)) for place in shares] == held(shares).tolist()


def test_runs_that_never_end_well_or_always_do():
    shares, apart = np.random.default_rng(1).random((32, 2)), np.random.default_rng(2).random((16, 2))
    for ends in (True, False):
        found = endings(shares, np.full(32, ends), apart, np.full(16, ends))
        assert found.confirmed == 16 * ends and found.well(apart[0], shares, np.full(32, ends)) is ends
    contradicted = endings(shares, np.full(32, True), apart, np.full(16, False))
    assert not contradicted.well(apart[0], shares, np.full(32, True))
