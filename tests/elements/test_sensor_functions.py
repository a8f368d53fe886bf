"""A sensor's or an integral's function is looked at when it is made, not when a run is compiled."""

import pytest

import jaxbuffer as jb
from jaxbuffer.elements import Integral, Sensor


def spin(kin, body):
    return kin.frame(body).spin


def spin_alone(kin):
    return kin.frame(0).spin


def rate(kin, acceleration, body):
    return acceleration[3 * body + 2]


def test_a_function_that_cannot_be_called_is_refused_with_how_it_is_called():
    with pytest.raises(jb.InputError, match=r"^speed: of = spin_alone\(kin\) is called as spin_alone\(kin, numbers\)$"):
        Sensor(spin_alone, name="speed")
    with pytest.raises(jb.InputError, match=r"spin\(kin, acceleration, numbers\)$"):
        Sensor(spin, 0, of_acceleration=True)
    with pytest.raises(
        jb.InputError, match=r"^turned: of = rate\(kin, acceleration, body\) is called as rate\(kin, num"
    ):
        Integral(rate, 0, name="turned")
    with pytest.raises(jb.InputError, match=r"^sensor: of = 3\.0 is no function; it is called as of\(kin, numbers\)$"):
        Sensor(3.0)
    with pytest.raises(jb.InputError, match=r"^jolt: a sensor of_acceleration cannot be watched=False"):
        Sensor(rate, 0, of_acceleration=True, watched=False, name="jolt")


@pytest.mark.parametrize(
    "make",
    [
        lambda: Sensor(spin, 0),
        lambda: Sensor(rate, 0, of_acceleration=True),
        lambda: Sensor(lambda *arguments: 0.0),
        lambda: Integral(spin, 0),
        lambda: Sensor(max),
    ],
)
def test_a_function_that_can_be_called_is_taken(make):
    make()
