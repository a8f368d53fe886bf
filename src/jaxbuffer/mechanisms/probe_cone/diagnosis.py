"""What held back a capture that did not succeed: way left, where the energy went, the impact that turned it round."""

import functools
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Array, Float

from ...hybrid import Kind
from ...programs.cache import stored
from ...value_text import percent_text, with_unit
from ..assembled import Assembled
from ..energy import energy_text, energy_unit
from ..registry import mechanism_of
from .bodies import T
from .capture import Capture
from .panels import NOT_ELASTIC
from .parts import parts_of


class Course(NamedTuple):
    """How the tip and the vehicles were moving at each event of a run, an entry each.

    ``before``: the tip's distance from the capture plane [m] (M65); ``closing``: how fast that becomes less [m/s];
    ``approach``: speed along the cone's axis at which the centres of mass of the active side (vehicle, cylinder, probe)
    and of the passive vehicle approach each other [m/s]; ``along``: kinetic energy of that approach [J]; ``common``:
    that of both together, which nothing inside the mechanism changes [J]; ``relative``: energy of relative motion [J]
    (M177).
    """

    before: Float[Array, " slots"]
    closing: Float[Array, " slots"]
    approach: Float[Array, " slots"]
    along: Float[Array, " slots"]
    common: Float[Array, " slots"]
    relative: Float[Array, " slots"]


@functools.partial(stored, what="what held a run back")
def course(
    parameters: tuple[Any, Any, Array], states: Float[Array, "slots state"], closed: Float[Array, "slots contacts"]
) -> Course:
    """Return the course of a run of design, scenario and stabilisation through these states (König's theorem).

    ``closed``: contacts that are closed then.
    """
    design = parameters[0]
    mechanism = mechanism_of(design).system(*parameters)
    assert isinstance(mechanism, Assembled)
    passive = design.passive.mass
    active = design.active.mass + design.buffer.cylinder_mass + mechanism.parts.probe.mass

    def at(state: Float[Array, " state"], touching: Float[Array, " contacts"]) -> Course:
        here = mechanism.evaluate(state)
        tip = mechanism.evaluated(here, "throat")
        momentum = mechanism.momentum(state)[0]
        cone = here.kin.frame(T)
        # The active side has the momentum of the whole less that of the passive vehicle.
        common = here.kin.basis.vector(*momentum)
        speed = ((common - cone.velocity * passive) * (1.0 / active) - cone.velocity).dot(cone.x_axis)
        reduced = active * passive / (active + passive)
        together = 0.5 * common.dot(common) / (active + passive)
        relative = mechanism.relative_energy(here, touching)
        return Course(tip.before, -tip.receding, speed, 0.5 * reduced * speed**2, together, relative)

    return jax.vmap(at)(states, closed)


class Turn(NamedTuple):
    """The impact after which the vehicles parted for good.

    ``impact``: its number from 1; ``contact``: number of what is touched; ``time`` of its touchdown [s]; ``before``,
    ``after``: how fast the vehicles approach each other at that touchdown, and at the first event at which they part
    [m/s].
    """

    impact: int
    contact: int
    time: float
    before: float
    after: float


def turned_round(capture: Capture, motion: Course) -> Turn | None:
    """Return the last impact before the vehicles' approach changes sign for good; None where they approach at the
    end."""
    log = capture._located  # its values are those of `log`, which would compute derivatives
    count = min(int(log.count), int(log.room))
    kind, which, time = (np.asarray(x)[:count] for x in (log.kind, log.which, log.time))
    approach = np.asarray(motion.approach)[:count]
    contacts = len(capture.mechanism.view.names(capture.design).contacts)
    # Parts have touchdowns too, under numbers behind those of the flanks.
    touched = (kind == Kind.TOUCHDOWN) & (which < contacts)
    approaching = np.flatnonzero(approach > 0.0)
    # They never approach, or still do, or nothing touches before they part: no impact turned them round.
    if not approaching.size or approaching[-1] == count - 1 or not np.any(touched[: approaching[-1] + 1]):
        return None
    at, parted = int(np.flatnonzero(touched[: approaching[-1] + 1])[-1]), int(approaching[-1]) + 1
    number = int(np.sum(touched[: at + 1]))
    return Turn(number, int(which[at]), float(time[at]), float(approach[at]), float(approach[parted]))


def diagnosis(capture: Capture) -> dict[str, str]:
    """Return what held a run back that did not end captured, by heading; nothing of others."""
    log = capture._located
    if capture.mechanism.succeeded(int(capture.outcome)) or capture.outcome.failed or not int(log.count):
        return {}
    parameters = (capture.design, capture.scenario, capture.stabilisation)
    motion = jax.tree.map(np.asarray, course(parameters, log.rows[:, 0], log.active))
    last = int(log.count) - 1
    for part in parts_of(capture.design, capture.scenario):
        if (diagnosed := part.diagnosis(capture)) is not None:
            what, first = diagnosed
            energies = {"energy left": _energy(capture, motion, last), "where it went": _lost(capture, motion, last)}
            return {**what, **energies, "what to change first": first}
    left, begin, speed = (1e3 * float(x) for x in (motion.before[last], motion.before[0], motion.closing[last]))
    tip = f"the tip {'still closes in' if speed > 0.0 else 'recedes'} at {abs(speed):.3g} mm/s"
    return {
        "way left": f"{left:.4g} mm to the capture plane, {begin:.4g} mm at first; {tip}",
        "energy left": _energy(capture, motion, last),
        "where it went": _lost(capture, motion, last),
        "turned round": _turn(capture, motion),
        "what to change first": "'jaxbuffer sensitivity … --of capture_share' says it",
    }


def _energy(capture: Capture, motion: Course, last: int) -> str:
    """Return the energy along the approach, in the springs, and in other motion, of what there was without the common
    motion."""
    total = _to_take(capture, motion, last)
    along, direction = float(motion.along[last]), "closing" if float(motion.approach[last]) > 0.0 else "parting"
    stored = {name: float(np.asarray(value)) for name, value in capture.energy.stored.items()}
    springs = sum(value for name, value in stored.items() if name not in NOT_ELASTIC)
    other = float(motion.relative[last]) - springs - along
    # An approach beside the common centre of mass is turning about it too, which is common to both vehicles.
    common = max(-other, 0.0)
    besides = f", {energy_text(common)} more in the common turning" if common > 1e-3 * total else ""
    return (
        f"{_share(along - common, total)} along the approach ({direction}{besides}),"
        f" {_share(springs, total)} in springs,"
        f" {_share(other, total)} in turning and sideways motion, of {energy_text(total)} relative to the common motion"
    )


def _to_take(capture: Capture, motion: Course, last: int) -> float:
    """Return the energy of relative motion that there was [J]: what is left of it, and what was lost."""
    return float(motion.relative[last]) + float(capture.energy.dissipated)


def _lost(capture: Capture, motion: Course, last: int) -> str:
    total = _to_take(capture, motion, last)
    lost = {name.replace("_", " "): float(np.asarray(value)) for name, value in capture.energy.lost.items()}
    most = sorted(lost.items(), key=lambda item: -item[1])
    return ", ".join(f"{name} {_share(value, total)}" for name, value in most if value > 0.0) or "nothing was lost"


def _turn(capture: Capture, motion: Course) -> str:
    turn = turned_round(capture, motion)
    if turn is None:
        return "never: the vehicles still approach each other at the end"
    view = capture.mechanism.view
    contact = view.contact_in_words(view.names(capture.design).contact(turn.contact))
    return (
        f"impact {turn.impact} of {int(capture.impact_count)}, {contact}, at {turn.time:.4g} s: the"
        f" vehicles approach at {1e3 * turn.before:.3g} mm/s before it and part at {-1e3 * turn.after:.3g} mm/s after"
    )


def _share(energy: float, total: float) -> str:
    unit, many = energy_unit(total)
    if not energy > 1e-6 * total:
        return f"0 {unit}"
    return f"{with_unit(many * energy, unit, 3)} ({percent_text(energy / total, '.1f')})"
