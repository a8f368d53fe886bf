"""The equations of motion of an assembled mechanism: what acts at one instant, and the rate of the state."""

from typing import Any, NamedTuple

from jaxtyping import Array

from .._types import Scalar
from ..multibody import Kinematics, Motion, System
from .energies import added
from .layout import Closed, EvaluatedState, Layout, State


class Forces(NamedTuple):
    """What acts at one instant: the ``elements`` with their forces, accelerations and multipliers of the bodies, and,
    where it is asked for, the mass that a force along each of some directions meets [kg]."""

    elements: tuple[Any, ...]
    motion: Motion
    masses: Array | None = None


def forces_of(
    system: System, layout: Layout, at: EvaluatedState, active: Closed, directions: Array | None = None
) -> Forces:
    """Return what acts in an evaluated state. ``active``: closed contacts and switches; ``directions``: of the masses,
    a column each."""
    closed = layout.of_elements(active)
    each = zip(layout.elements, at.elements, closed, strict=True)
    forces = tuple(element.with_forces(it, mine) for element, it, mine in each)
    acting = zip(layout.elements, forces, closed, strict=True)
    loads = [load for element, it, mine in acting for load in element.loads(it, mine)]
    if directions is None:
        return Forces(forces, system.motion(at.kin, tuple(loads)))
    return Forces(forces, *system.motion_and_masses(at.kin, tuple(loads), directions))


def rate_of_state(
    system: System,
    layout: Layout,
    kin: Kinematics,
    active: Closed,
    acting: Forces,
    losses: tuple[tuple[str, ...], str | None],
) -> State:
    """Return the rate of the state.

    **Arguments:** ``system``; ``layout``; ``kin``: the bodies' frames; ``active``: closed contacts and switches;
    ``acting``: what acts; ``losses``: the names of all energies lost, and that of the system's own, if it loses one.
    """
    names, own = losses
    lost: dict[str, Scalar] = {} if own is None else {own: system.dissipation(kin)}
    for element, it, closed in zip(layout.elements, acting.elements, layout.of_elements(active), strict=True):
        lost = added(lost, element.losses(it, closed))
    return layout.state(
        q=system.position_rate(kin.q).of(kin.v),
        v=acting.motion.acceleration,
        lost=[lost[name] for name in names],
        first_energy=0.0,
        own=_element_rates(system, layout, kin, active, acting),
        time=1.0,
    )


def _element_rates(
    system: System, layout: Layout, kin: Kinematics, active: Closed, acting: Forces
) -> list[list[Scalar]]:
    """Return the rates of each element's numbers."""
    rates: list[list[Scalar]] = []
    # The driving joints stand behind all others, and so do their multipliers.
    others = [joint for joint in system.joints if not joint.driven] if layout.driven else []
    first = sum(len(joint.rows(kin)) for joint in others)
    for element, it, closed in zip(layout.elements, acting.elements, layout.of_elements(active), strict=True):
        own = element.rates(it, closed)
        if element.driving_joint is not None:
            last = first + len(element.driving_joint.rows(kin))
            own = own + element.reaction_rates(it, acting.motion.multipliers[first:last])
            first = last
        rates.append(own)
    return rates
