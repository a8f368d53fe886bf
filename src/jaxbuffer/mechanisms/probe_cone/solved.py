"""What was solved, as a capture."""

from typing import TypeVar

import jax
import jax.numpy as jnp

from ..assembled import Assembled
from ..run import Solved
from .assembly import LOWER
from .capture import Capture
from .closed_form import predict
from .docking import crossing, docking
from .margins import stroke_margin, throat
from .outcome import Outcome

C = TypeVar("C", bound=Capture)


def capture(mechanism: Assembled, solved: Solved) -> Capture:
    """Return what was solved, as a capture."""
    return capture_of(Capture, mechanism, solved)


def capture_of(kind: type[C], mechanism: Assembled, solved: Solved) -> C:
    """Return what was solved, as a capture of a ``kind``: in the plane or in space."""
    largest, known, log = solved.common["maxima"], solved.known, solved.log
    start, end = solved.start.own, solved.end.own
    # Vehicles that latches hold, but that are not yet at rest when time is up, are latched.
    latched = end.since_crossing > 0.0
    code = jnp.where((solved.code == Outcome.timeout) & latched, int(Outcome.latched), solved.code)
    cross = crossing(mechanism, solved, code)
    throat_distance, beyond = throat(mechanism, log, end, cross, solved.duration)
    margin = stroke_margin(mechanism, end, solved.maxima.others["stroke"], code == Outcome.bottomed)
    # Before the crossing it is what keeps its square root differentiable.
    latch_force = jnp.where(latched, largest.get("latch_force", 0.0), 0.0) * known
    beyond_capture = docking(mechanism, (start, end), log, cross, code, latch_force, kind.docking_type)
    common = {**solved.common, "code": code, "impacts": kind.impacts_type(**vars(solved.common["impacts"]))}
    return kind(
        **common,
        peak_hinge_force=largest["hinge_force"],
        peak_buffer_force=largest["buffer_force"],
        peak_stop_force=largest.get("stop_force", 0.0 * known),
        stroke=largest["stroke"],
        extension=largest["extension"],
        stroke_margin=margin * known,
        hinge_angle=largest["hinge_angle"],
        bending=largest.get("bending", 0.0 * known),
        throat_distance=throat_distance * known,
        peak_latch_force=latch_force,
        passive_force=largest.get("passive_force", jnp.nan * known),
        capture_margin=jnp.minimum(beyond, margin) * known,
        capture_share=beyond / start.throat.before * known,
        docking=jax.tree.map(lambda value: value * known, beyond_capture),
        first_impact=predict(mechanism, start.flank_mass, mechanism.memory(solved.start.state)[LOWER]),
    )
