"""Sensors of a slider-crank: the slider's acceleration, where its pins are, and how far rod and slider bend."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array

from ..._types import Scalar
from ...elements import BallContact, Element, Sensor, deepest
from ...multibody import Coordinates, Kinematics
from ...multibody.flexible import FlexibleBar, Marker, deflection, stress
from .design import SliderCrank
from .pins import PinInBush
from .shapes import PlanarBody

CRANK, ROD, SLIDER = range(3)
BODIES = Coordinates(3)  # the modal coordinates come behind those of the bodies


class Seat(NamedTuple):
    """A slider that bends: the middle of its ``guide``, its ``pin``, and how far apart they are [m]."""

    guide: Marker
    pin: Marker
    apart: Scalar


def sensors(design: SliderCrank, contacts: tuple[BallContact, ...]) -> list[Element]:
    """Return the sensors of a design with these contacts."""
    watching: list[Element] = [Sensor(slider_acceleration, of_acceleration=True, name="slider_acceleration")]
    if design.piston_pin.by_components:
        # Where the damper makes the peak force, that says little of how deep the pin went.
        watching.append(Sensor(deepest, contacts, least=0.0, name="penetration"))
    if design.rod.modes:
        rod = design.rod.bent
        watching += [
            Sensor(rod_deflection, rod, name="rod_deflection"),
            Sensor(rod_stress, rod, name="rod_stress"),
        ]
    if design.slider.modes:
        form = design.slider.form
        seat = Seat(form.first, form.second, form.second.x - form.first.x)
        watching.append(Sensor(slider_deflection, seat, name="slider_deflection"))
    return watching


def eccentricity(pin: PinInBush, contact: BallContact) -> list[Element]:
    """Return, of a pin with play, the centre relative to the bush's, along the slider's line and across it [m], for
    histories alone."""
    # By components the rod's end is the ball, and the pin's body carries the shape.
    numbers = (-1.0 if pin.by_components else 1.0, contact)
    axes = {"x": off_centre_along, "y": off_centre_across}
    return [Sensor(of, numbers, watched=False, name=f"{pin.section}_{axis}") for axis, of in axes.items()]


def slider_acceleration(kin: Kinematics, acceleration: Array, numbers: None) -> Scalar:
    """Return the size of the slider's acceleration [m/s²]."""
    # The guide lets the slider move along its line alone.
    return jnp.abs(Coordinates.translation(acceleration, SLIDER).x)


def off_centre_along(kin: Kinematics, pin: tuple[float, BallContact]) -> Scalar:
    """Return a pin's eccentricity along the slider's line [m]. ``pin``: -1 where the ball stands for the bush, and its
    contact."""
    ball = pin[1].evaluate(kin)
    return pin[0] * (ball.centre.place.x - ball.origin.place.x)


def off_centre_across(kin: Kinematics, pin: tuple[float, BallContact]) -> Scalar:
    """Return a pin's eccentricity across the slider's line [m]. ``pin``: as of `off_centre_along`."""
    ball = pin[1].evaluate(kin)
    return pin[0] * (ball.centre.place.y - ball.origin.place.y)


def rod_deflection(kin: Kinematics, rod: FlexibleBar | PlanarBody) -> Scalar:
    """Return how far the rod's middle is off the line through its ends [m]."""
    bent = kin.modal(ROD)[0]
    if isinstance(rod, PlanarBody):
        return jnp.abs(jnp.sum(rod.deflection * bent))
    ends_and_middle = deflection(rod, bent, (0.0, 0.5, 1.0))[:, 1]
    return jnp.abs(ends_and_middle[1] - 0.5 * (ends_and_middle[0] + ends_and_middle[2]))


def rod_stress(kin: Kinematics, rod: FlexibleBar | PlanarBody) -> Scalar:
    """Return the size of the stress along the rod on the surface of its middle [Pa]: that of bending, of a shape the
    whole."""
    bent = kin.modal(ROD)[0]
    if isinstance(rod, PlanarBody):
        upper, lower = (jnp.abs(jnp.sum(row * bent)) for row in rod.stress)
        return jnp.maximum(upper, lower)
    edge = jnp.sqrt(3.0 * rod.bar.second_moment / rod.bar.area)  # half the depth of a rectangle
    return jnp.abs(stress(rod, bent, (0.5,), edge)[0])


def slider_deflection(kin: Kinematics, seat: Seat) -> Scalar:
    """Return how far the piston pin is pushed along the slider's line, against the slider's guide [m]."""
    guide, pin = (kin.point(SLIDER, marker).place for marker in (seat.guide, seat.pin))
    return jnp.abs(pin.x - guide.x - seat.apart)
