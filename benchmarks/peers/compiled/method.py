"""What the loop needs of a method and of a mechanism; all functions are compiled."""

from __future__ import annotations

from typing import Any, NamedTuple


class Method(NamedTuple):
    """A method of steps, for one mechanism.

    ``workspace()``; ``step(y, slope, h, rtol, atol, anew, context, new, new_slope, work)``: error over that allowed;
    ``interpolant(y, h, new, context, terms, work)``; ``at(x, y, new, terms, out)``.
    """

    order: int
    stages: int
    terms: int  # rows that an interpolant has
    workspace: Any
    step: Any
    interpolant: Any
    at: Any


class Mechanism(NamedTuple):
    """A mechanism's state and what is watched of it.

    First the gap of each contact, minus that of one that presses, then the distances from the capture plane and from
    the escape plane, then the rate of each contact's force: each falls through zero when its event happens. ``context``
    has from the place ``active`` on which contacts press, and behind that the approach speeds that they remember.

    ``slope_into(y, out, context)``; ``watch_along(y, flow, values, context)``; ``forces(y, context)``: a tuple;
    ``approach(contact, y, context)``: the speed with which a contact closes [m/s].
    """

    states: int
    contacts: int
    active: int
    slope_into: Any
    watch_along: Any
    forces: Any
    approach: Any
