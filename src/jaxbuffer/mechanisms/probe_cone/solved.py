"""What was solved, as a capture."""

import jax.numpy as jnp

from ..run import Solved
from .capture import Capture, FlankImpacts
from .closed_form import predict
from .margins import rising, stroke_margin, throat
from .outcome import Outcome
from .system import CaptureMechanism


def capture(mechanism: CaptureMechanism, solved: Solved) -> Capture:
    """What was solved, as a capture."""
    largest, known, log = solved.common["maxima"], solved.known, solved.log
    stroke = solved.maxima.others["stroke"]
    throat_distance, beyond = throat(mechanism, log, solved.duration)
    before = mechanism.throat(solved.start.kin, solved.start.tip)[0]
    margin = stroke_margin(mechanism, log, stroke, solved.code == Outcome.bottomed)
    stroke_rising, angle_rising = rising(mechanism, log, stroke, solved.maxima.others["hinge_angle"])
    common = {**solved.common, "impacts": FlankImpacts(**vars(solved.common["impacts"]))}
    return Capture(
        **common,
        peak_hinge_force=largest["hinge_force"],
        peak_buffer_force=largest["buffer_force"],
        peak_stop_force=largest.get("stop_force", 0.0 * known),
        stroke=largest["stroke"],
        stroke_margin=margin * known,
        stroke_rising=stroke_rising * known,
        hinge_angle=largest["hinge_angle"],
        hinge_angle_rising=angle_rising * known,
        bending=largest.get("bending", 0.0 * known),
        throat_distance=throat_distance * known,
        capture_margin=jnp.minimum(beyond, margin) * known,
        capture_share=beyond / before * known,
        first_impact=predict(mechanism, solved.start),
    )
