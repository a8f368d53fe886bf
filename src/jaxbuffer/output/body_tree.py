"""An assembled mechanism as a tree of bodies, each on its parent by hinges and slides, and the rest of it in words."""

import dataclasses
import inspect
import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import jax
import numpy as np

from ..basis import components
from ..contact import Shape
from ..elements import BallContact, Buffer, Element, SpringDamper
from ..errors import InputError
from ..fields import Part
from ..mechanisms.assembled import Assembled
from ..mechanisms.registry import mechanism_of
from ..multibody import (
    AxialSpringDamper,
    CrossSpringDamper,
    FlexibleBody,
    Kinematics,
    Prismatic,
    Revolute,
    TorsionalSpringDamper,
    Universal,
)
from ..run.request import check_pair

SPRINGS = (TorsionalSpringDamper, CrossSpringDamper, AxialSpringDamper)
Triple = tuple[float, float, float]


class HingeOrSlide(NamedTuple):
    """One degree of freedom between bodies: ``kind`` as MJCF has it, "hinge" or "slide"; ``point`` in the child's axes;
    ``axis`` in these too; ``at``, ``rate``: at t = 0; ``spring``: stiffness, damping and where it is slack."""

    kind: str
    point: Triple
    axis: Triple
    at: float
    rate: float
    spring: tuple[float, float, float] = (0.0, 0.0, 0.0)


class Link(NamedTuple):
    """A body on its ``parent``, at a ``place`` in the parent's axes where its joints are at zero."""

    parent: int
    place: Triple
    joints: tuple[HingeOrSlide, ...]


class BodyTree(NamedTuple):
    """A mechanism as a tree: the ``names`` of its bodies, how each hangs on another, and what is said in ``words``."""

    mechanism: Assembled
    kin: Kinematics
    names: tuple[str, ...]
    links: Mapping[int, Link]
    words: tuple[str, ...]

    @property
    def space(self) -> bool:
        """Return whether it is of space."""
        return self.mechanism.system.basis.dimensions == 3

    @property
    def roots(self) -> list[int]:
        """Return the bodies that hang on none."""
        return [k for k in range(len(self.names)) if k not in self.links]


def tree_of(design: Part, scenario: Part | None) -> BodyTree:
    """Return a design at its start as a tree. **Raises:** `InputError` for what is none here."""
    mechanism = mechanism_of(design)
    scenario = mechanism.scenario() if scenario is None else scenario
    check_pair(mechanism, design, scenario)
    if mechanism.stepper is not None:
        raise InputError(f"MJCF needs a mechanism assembled from bodies, which {mechanism.name} is not")
    assembled = mechanism.system(design, scenario, 0.0)
    assert isinstance(assembled, Assembled)
    kin, names = assembled.system.kinematics(assembled.q, assembled.v), mechanism.names(design).bodies
    if bent := [
        name for name, body in zip(names, assembled.system.bodies, strict=True) if isinstance(body, FlexibleBody)
    ]:
        raise InputError(f"MJCF has no bodies that bend, as the {bent[0]} of this design does")
    springs, words = _springs(assembled)
    links: dict[int, Link] = {}
    for joint in assembled.system.joints:
        if joint.second in links or joint.second < 0 or joint.first < 0:
            raise InputError("MJCF says a tree of bodies here; this mechanism's joints hold one twice, or the ground")
        links[joint.second] = _link(joint, kin, springs.pop((joint.first, joint.second), None))
    words += [f"a spring between {names[i]} and {names[j]}: {_fields(it)}" for (i, j), it in springs.items()]
    return BodyTree(assembled, kin, names, links, tuple(words))


def _springs(mechanism: Assembled) -> tuple[dict[tuple[int, int], Any], list[str]]:
    """Return the springs that a joint can have, by their two bodies, and all else that acts, in words."""
    springs, words = dict[tuple[int, int], Any](), list[str]()
    for element in mechanism.elements:
        force: Any = element.force if isinstance(element, SpringDamper | Buffer) else None
        linear = type(force) in SPRINGS and not getattr(force, "published_damping", False)
        if force is not None and linear and getattr(force, "guide", ()) is not None:
            springs[force.first, force.second] = force
        else:
            words.append(_said(element))
    return springs, words


def _link(joint: Any, kin: Kinematics, force: Any) -> Link:
    """Return how a joint's second body hangs on its first. ``force``: between these two."""
    first, second = kin.frame(joint.first), kin.frame(joint.second)
    point, other = triple(joint.first_point), triple(joint.second_point)
    stiffness, damping = (0.0, 0.0) if force is None else (float(force.stiffness), float(force.damping))
    spin = triple(components(first.in_axes(second.spin - first.spin) if kin.basis.dimensions == 3 else 0.0))
    place = triple(np.subtract(point, other))
    if isinstance(joint, Universal) and not isinstance(force, AxialSpringDamper):
        turn = np.asarray(components(kin.basis.relative_rotation(first, second)), float)
        if np.max(np.abs(turn)) > 1e-12:
            raise InputError("MJCF is written for a start at which the bodies of a universal joint are in line")
        axes = (triple(joint.first_axis), triple(joint.second_axis))
        spring = (stiffness, damping, 0.0)
        return Link(
            joint.first, place, tuple(HingeOrSlide("hinge", other, it, 0.0, _dot(it, spin), spring) for it in axes)
        )
    if isinstance(joint, Revolute) and kin.basis.dimensions == 2 and not isinstance(force, AxialSpringDamper):
        # The spring's angle is that of the first body against the second.
        spring = (stiffness, damping, 0.0 - float(getattr(force, "angle", 0.0)))
        at, rate = float(second.angle - first.angle), float(second.spin - first.spin)
        return Link(joint.first, place, (HingeOrSlide("hinge", other, (0.0, 0.0, 1.0), at, rate, spring),))
    if isinstance(joint, Prismatic) and joint.angle == 0.0 and (force is None or isinstance(force, AxialSpringDamper)):
        axis = _along(joint)
        apart = first.unturn(second.origin - first.origin)
        speed = first.unturn(second.velocity - first.velocity_at(second.origin - first.origin))
        slack = 0.0 if force is None else float(force.free_length - force.state(kin).length)
        spring = (stiffness, damping, slack)
        return Link(
            joint.first,
            triple(apart),
            (HingeOrSlide("slide", (0.0, 0.0, 0.0), axis, 0.0, _dot(axis, triple(speed)), spring),),
        )
    raise InputError(f"MJCF is not written for a {type(joint).__name__} joint with what acts along it here")


def _along(joint: Prismatic) -> Triple:
    """Return the direction of a line that is given by its normals."""
    normal = triple(joint.normal)
    return triple(np.cross(normal, (0.0, 0.0, 1.0) if len(joint.normal) == 2 else triple(joint.binormal)))


def _said(element: Element) -> str:
    """Return an element in words: what it is, and its numbers; of a contact its law."""
    if not isinstance(element, BallContact):
        return f"{element.name}: {_first_line(element)}{f' ({numbers})' if (numbers := _fields(element)) else ''}"
    pair, at = element.pair, number_text(triple(element.point))
    return (
        f"{element.name}: a ball of radius {float(pair.radius):.9g} m at {at} of body {element.body} against a"
        f" {type(pair.shape).__name__} on body {element.carrier} ({_fields(pair.shape)}); normal force by the law"
        f" {type(pair.law).__name__} of jaxbuffer.contact, {_first_line(pair.law)} ({_fields(pair.law)}), whose damping"
        " goes with the approach speed of the last touchdown, which MuJoCo's contacts, soft constraints, do not know;"
        f" friction coefficient · normal force · tanh(slip / slip_speed) ({_fields(pair.friction)})"
    )


def _first_line(module: Any) -> str:
    """Return the first line of a class's documentation."""
    return (inspect.getdoc(type(module)) or "").partition("\n")[0].rstrip(".")


def _fields(module: Any) -> str:
    """Return the numbers among the fields of a module, and of the modules within it, in words."""
    return ", ".join(f"{name} {value}" for name, value in _pairs(module))


def _pairs(module: Any) -> Iterator[tuple[str, str]]:
    for it in dataclasses.fields(module):
        value = getattr(module, it.name)
        if isinstance(value, float | jax.Array | np.ndarray) and np.ndim(value) < 2:
            yield it.name, " ".join(f"{number:.9g}" for number in np.atleast_1d(np.asarray(value)))
        elif isinstance(value, Shape):
            yield from _pairs(value)


def triple(values: Any) -> Triple:
    """Return two or three components as three numbers."""
    x, y, z = [float(it) for it in (*values, 0.0, 0.0)][:3]
    return x, y, z


def _dot(a: Triple, b: Triple) -> float:
    return math.fsum(x * y for x, y in zip(a, b, strict=True))


def number_text(values: Any) -> str:
    """Return numbers as they are read back to the bit, without ".0" at a whole one."""
    return " ".join(repr(float(it)).removesuffix(".0") for it in values)
