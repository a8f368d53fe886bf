"""The catalogue of a capture's quantities."""

import math

from ..quantity import CONTACT_TIME, DISSIPATED, PEAK_FORCE, PEAK_TIME, PENETRATION, Quantity
from .law_validity import pressure

MILLIMETRES = ("mm", 1e3)
DEGREES = ("deg", 180.0 / math.pi)

QUANTITIES: dict[str, Quantity] = {
    "peak_force": PEAK_FORCE._replace(description="largest contact force of either flank"),
    "peak_time": PEAK_TIME,
    "peak_hinge_force": Quantity(
        "N", lambda c: c.peak_hinge_force, "largest reaction in the hinge", "peak hinge force", swept=True, tuned=True
    ),
    "peak_buffer_force": Quantity(
        "N",
        lambda c: c.peak_buffer_force,
        "largest force of the axial spring-damper",
        "peak buffer force",
        swept=True,
        tuned=True,
    ),
    "stroke": Quantity(
        "m",
        lambda c: c.stroke,
        "largest shortening of the buffer",
        "buffer stroke",
        swept=True,
        tuned=True,
        shown=MILLIMETRES,
        rising="stroke_rising",
    ),
    "stroke_rising": Quantity(
        "m/s",
        lambda c: c.stroke_rising,
        "rate of the stroke at the run's end if it is largest there, else 0",
        "stroke's rate at the end",
        swept=True,
        shown=("mm/s", 1e3),
    ),
    "hinge_angle": Quantity(
        "rad",
        lambda c: c.hinge_angle,
        "largest angle between cylinder and active vehicle",
        "hinge angle",
        swept=True,
        tuned=True,
        shown=DEGREES,
        rising="hinge_angle_rising",
    ),
    "hinge_angle_rising": Quantity(
        "rad/s",
        lambda c: c.hinge_angle_rising,
        "rate of the hinge angle at the run's end if it is largest there, else 0",
        "hinge angle's rate at the end",
        swept=True,
        shown=("deg/s", 180.0 / math.pi),
    ),
    "bending": Quantity(
        "m",
        lambda c: c.bending,
        "largest displacement of the tip off the axis of a probe that bends",
        "bending of the probe",
        swept=True,
        tuned=True,
        shown=MILLIMETRES,
        part="probe.bending_stiffness",
    ),
    "end_time": Quantity(
        "s",
        lambda c: c.end_time,
        "end of the run: of a captured one, the capture time",
        "end time",
        swept=True,
        tuned=True,
    ),
    "peak_stop_force": Quantity(
        "N",
        lambda c: c.peak_stop_force,
        "largest force of the buffer's end stop",
        "peak force of the end stop",
        swept=True,
        tuned=True,
        part="buffer.stop_stiffness",
    ),
    "stroke_share": Quantity(
        "-",
        lambda c: 1.0 - c.stroke_margin / c.design.buffer.longest_stroke,
        "share of the buffer's stroke that is used; of a bottomed run above 1",
        "share of the stroke",
        tuned=True,
    ),
    "stroke_margin": Quantity(
        "m",
        lambda c: c.stroke_margin,
        "stroke left before the buffer's end; below zero where it bottoms, no measure of what is missing",
        "stroke margin",
        signed=True,
        swept=True,
        shown=MILLIMETRES,
    ),
    "penetration": PENETRATION._replace(description="depth that the tip's deepest penetration does not exceed"),
    "contact_time": CONTACT_TIME._replace(description="time during which a flank is touched"),
    "throat_distance": Quantity(
        "m",
        lambda c: c.throat_distance,
        "tip before the capture plane at the run's end; at any time, as duration",
        "distance to the capture plane",
        signed=True,
        swept=True,
        shown=MILLIMETRES,
    ),
    "capture_margin": Quantity(
        "m",
        lambda c: c.capture_margin,
        "tip beyond the capture plane at the duration, coasting on, or stroke_margin",
        "capture margin",
        signed=True,
        swept=True,
        shown=MILLIMETRES,
    ),
    "capture_share": Quantity(
        "-",
        lambda c: c.capture_share,
        "tip beyond the capture plane at the duration, coasting on, over its distance at the start",
        "capture share",
        signed=True,
    ),
    "contact_pressure": Quantity(
        "Pa",
        lambda c: pressure(c.design, c.peak_force),
        "Hertz's largest pressure at the peak contact force",
        "contact pressure",
    ),
    "axial_loss": Quantity("J", lambda c: c.energy.axial_damper, "energy lost in the axial damper by the run's end"),
    "torsional_loss": Quantity("J", lambda c: c.energy.torsional_damper, "energy lost in the torsional damper"),
    "contact_loss": Quantity("J", lambda c: c.energy.hysteresis, "energy lost in the contact's hysteresis"),
    "friction_loss": Quantity("J", lambda c: c.energy.friction, "energy lost in friction"),
    "bending_loss": Quantity("J", lambda c: c.energy.bending, "energy lost in the probe's bending"),
    "play_loss": Quantity("J", lambda c: c.energy.hinge_play, "energy lost in the play of the hinge"),
    "stop_loss": Quantity("J", lambda c: c.energy.stop_damper, "energy lost in the buffer's end stop"),
    "dissipated": DISSIPATED,
    "effective_mass": Quantity("kg", lambda c: c.first_impact.effective_mass, "mass the first impact meets"),
    "effective_energy": Quantity("J", lambda c: c.first_impact.effective_energy, "T_c just before the first impact"),
    "elastic_first_peak": Quantity(
        "N", lambda c: c.first_impact.elastic_peak, "closed form of the first peak: no friction, loss, buffer"
    ),
    "predicted_first_peak": Quantity(
        "N", lambda c: c.first_impact.predicted_peak, "closed form of the first peak with the contact's loss"
    ),
}
