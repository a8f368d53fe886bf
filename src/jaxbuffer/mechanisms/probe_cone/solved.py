"""What was solved, as a capture."""

import jax
import jax.numpy as jnp

from ..assembled import Assembled
from ..run import Solved
from .capture import Capture, FlankImpacts
from .closed_form import predict
from .docking import crossing, docking, end_of, latched
from .margins import stroke_margin, throat
from .outcome import Outcome


def capture(mechanism: Assembled, solved: Solved) -> Capture:
    """Return what was solved, as a capture."""
    largest, known, log = solved.common["maxima"], solved.known, solved.log
    stroke = solved.maxima.others["stroke"]
    end = end_of(mechanism, log)
    # Vehicles that latches hold, but that are not yet at rest when time is up, are latched.
    code = jnp.where((solved.code == Outcome.timeout) & latched(mechanism, end), int(Outcome.latched), solved.code)
    cross = crossing(mechanism, log, end, code)
    throat_distance, beyond = throat(mechanism, log, end, cross, solved.duration)
    before = mechanism.evaluated(solved.start, "throat").before
    margin = stroke_margin(mechanism, log, end, stroke, code == Outcome.bottomed)
    # Before the crossing it is what keeps its square root differentiable.
    latch_force = jnp.where(latched(mechanism, end), largest.get("latch_force", 0.0), 0.0) * known
    beyond_capture = docking(mechanism, (solved.start, end), log, cross, code, latch_force)
    common = {**solved.common, "code": code, "impacts": FlankImpacts(**vars(solved.common["impacts"]))}
    return Capture(
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
        capture_share=beyond / before * known,
        docking=jax.tree.map(lambda value: value * known, beyond_capture),
        first_impact=predict(mechanism, solved.start),
    )
