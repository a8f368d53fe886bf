"""Whether numbers known only inside compiled code are in range: what the checks of `design` say, as an array."""

import dataclasses
import functools
import operator
from collections.abc import Iterable, Iterator

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool

from ..errors import inside
from .design import HERTZ_EXPONENT, POSITIVE, Design, Part, Scenario, least_contact_distance


def valid(design: Design, scenario: Scenario) -> Bool[Array, ""]:
    """Whether every number of a design and a scenario is in its declared range, and they fit; NaN is in no range."""
    return all_of([*_declared(design), *_declared(scenario), *_of_design(design), *_fit(design, scenario)])


def all_of(conditions: Iterable[Bool[Array, ""]]) -> Bool[Array, ""]:
    """Whether all hold."""
    return functools.reduce(operator.and_, map(jnp.asarray, conditions))


def _declared(part: Part) -> Iterator[Bool[Array, ""]]:
    """Each number against its own range."""
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        if isinstance(value, Part):
            yield from _declared(value)
        elif "unit" in field.metadata and value is not None:
            yield inside(value, **field.metadata["limits"])


def _of_design(design: Design) -> Iterator[Bool[Array, ""]]:
    """What `Buffer`, `Contact` and `Design` check besides."""
    buffer, contact, cone = design.buffer, design.contact, design.cone
    if buffer.max_stroke is not None:
        yield inside(buffer.max_stroke, high=buffer.free_length, **POSITIVE)
    if buffer.stop_stiffness is None:
        yield inside(buffer.stop_damping, low=0.0, high=0.0)
    if contact.law != "adams" or contact.stiffness is None:
        yield inside(contact.exponent, low=HERTZ_EXPONENT, high=HERTZ_EXPONENT)
    mouth = cone.throat_radius + cone.length * jnp.sin(cone.half_angle)
    yield inside(design.probe.tip_radius, high=mouth, high_open=True, **POSITIVE)


def _fit(design: Design, scenario: Scenario) -> Iterator[Bool[Array, ""]]:
    """What `check_fit` checks."""
    cone, angle = design.cone, design.cone.half_angle
    least = least_contact_distance(design.probe.tip_radius, cone.throat_radius, angle, jnp)
    yield inside(scenario.contact_distance, low=least, high=cone.length, low_open=True)
    limit = jnp.minimum(angle, np.pi / 2 - angle)
    yield inside(scenario.misalignment, low=-limit, high=limit, low_open=True, high_open=True)
