"""Damping factors by author, for any spring."""

import doctest

import jax
import pytest
from numpy.testing import assert_allclose

from jaxbuffer import InputError
from jaxbuffer.contact.laws import DAMPING_FACTORS, LAWS, damping, damping_factor, pin_in_hole_law
from jaxbuffer.contact.laws.restitution import restitution_delivered

TOPIC = "Damping factors"


def pin(author, restitution):
    """A pin in a hole, whose spring is no power."""
    numbers = {"bush_radius": 10e-3, "clearance": 0.5e-3, "length": 40e-3, "modulus": 1e11}
    return pin_in_hole_law("johnson", **numbers, damping=author, restitution=restitution)


def test_damping_factors_are_those_of_the_laws():
    """Of the same names; every one of them the same for any spring."""
    assert set(DAMPING_FACTORS) - {"none"} == set(LAWS) - {"hertz", "kelvin-voigt", "adams"}
    for name in set(DAMPING_FACTORS) - {"none"}:
        ball = LAWS[name](1e9, 0.6)
        assert_allclose(ball.hysteresis, damping_factor(name, 0.6), rtol=0)
        assert_allclose(ball.hysteresis, pin(name, 0.6).hysteresis, rtol=0)
        slope = jax.jit(jax.grad(lambda e, name=name: pin(name, e).delivered_restitution()))(0.6)
        assert 0.3 < float(slope) < 1.2
    assert pin("none", 0.6).hysteresis == 0.0


@pytest.mark.parametrize("asked", [0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9])
def test_carvalho_and_martins_as_computed(asked, evidence):
    """The restitution that their own formula delivers, for e below 1/3 too; the law has Gonthier's there."""
    wanted = {0.05: 0.0929, 0.1: 0.1289, 0.2: 0.2116, 0.3: 0.3040, 0.5: 0.50017, 0.7: 0.69997, 0.9: 0.90000}[asked]
    theirs = 1.5 * (1 - asked) * (11 - asked) / (1 + 9 * asked)
    digit = 5.001e-6 if asked > 0.4 else 5.001e-5
    error = abs(float(restitution_delivered(theirs)) - wanted)
    evidence(
        TOPIC, f"restitution of Carvalho and Martins, asked {asked:g}", error, digit, "computed independently", "-"
    )
    found = float(damping_factor("carvalho-martins", asked))
    assert_allclose(found, theirs if asked > 1 / 3 else (1 - asked**2) / asked, rtol=1e-14)


def test_carvalho_and_martins_meet_gonthier():
    """Both are 8/3 at e = 1/3."""
    for e in (1 / 3 - 1e-12, 1 / 3 + 1e-12):
        assert_allclose(damping_factor("carvalho-martins", e), 8 / 3, rtol=1e-11)


def test_a_name_that_is_none_is_refused():
    with pytest.raises(InputError, match="did you mean flores"):
        damping_factor("flors", 0.5)


def test_the_example_in_the_docstring_runs():
    failed, tried = doctest.testmod(damping)
    assert tried and not failed
