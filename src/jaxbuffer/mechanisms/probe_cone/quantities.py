"""The catalogue of a capture's quantities."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..quantity import CONTACT_TIME, DISSIPATED, END_TIME, PEAK_FORCE, PEAK_TIME, PENETRATION, Quantity
from .capture import Capture
from .law_validity import pressure
from .parts import PARTS
from .parts.part import loss, time_of
from .parts.vehicles import reduced_mass
from .vehicle_forces import peak_vehicle_force

REFERENCE_SPEED = 0.1  # m/s, of M182


def reference_share(capture: Capture) -> Float[Array, ""]:
    """Return the energy of relative motion at the end over that of the two vehicles at 0.1 m/s [-] (M182)."""
    return jnp.asarray(capture.docking.energy_left / (0.5 * reduced_mass(capture.design) * REFERENCE_SPEED**2))


QUANTITIES: dict[str, Quantity] = {
    "peak_force": PEAK_FORCE._replace(description="largest contact force of either flank"),
    "peak_time": PEAK_TIME,
    "peak_hinge_force": Quantity(
        "N", lambda c: c.peak_hinge_force, "largest reaction in the hinge", "peak hinge force", swept=True, tuned=True
    ),
    "peak_vehicle_force": Quantity(
        "N",
        peak_vehicle_force,
        "largest single force on a vehicle: the contact's, the latches' or the hinge's",
        "largest force on a vehicle",
        tuned=True,
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
    ),
    "extension": Quantity(
        "m",
        lambda c: c.extension,
        "how far the buffer's rod goes out beyond its free position; 0 where it never does",
        "buffer extension",
        swept=True,
        tuned=True,
    ),
    "hinge_angle": Quantity(
        "rad",
        lambda c: c.hinge_angle,
        "largest angle between cylinder and active vehicle",
        "hinge angle",
        swept=True,
        tuned=True,
    ),
    "end_time": END_TIME._replace(description="end of the run: of a captured one, the capture time"),
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
    ),
    "relative_energy": Quantity(
        "-",
        lambda c: c.docking.relative_energy,
        "energy of relative motion at the end over that at the start",
        "relative energy left",
        swept=True,
        tuned=True,
        shown=("%", 100.0),
    ),
    "energy_left": Quantity(
        "J",
        lambda c: c.docking.energy_left,
        "energy of relative motion at the end",
        "energy of relative motion left",
        swept=True,
        tuned=True,
    ),
    "reference_energy_left": Quantity(
        "-",
        reference_share,
        "energy of relative motion at the end over that of both vehicles at 0.1 m/s: alike for all approach speeds",
        "energy left over that of 0.1 m/s",
        tuned=True,
        shown=("%", 100.0),
    ),
    "arrest_stroke": Quantity(
        "m",
        lambda c: c.docking.arrest_stroke,
        "stroke at which the axial spring would store the energy of relative motion left at the end",
        "arrest stroke",
        swept=True,
        tuned=True,
    ),
    "peak_active_acceleration": Quantity(
        "m/s²",
        lambda c: c.peak_hinge_force / c.design.active.mass,
        "largest acceleration of the active vehicle's centre of mass",
        "peak acceleration of the active vehicle",
        tuned=True,
    ),
    "impulse": Quantity("N s", lambda c: c.docking.impulse, "impulse on the passive vehicle, to the end of the run"),
    "lateral_miss": Quantity(
        "m",
        lambda c: c.docking.lateral_miss,
        "of the tip from the cone's axis where it crosses the capture plane",
        "lateral miss",
        signed=True,
    ),
    "lateral_miss_rate": Quantity(
        "m/s", lambda c: c.docking.lateral_miss_rate, "how fast that changes there", signed=True, shown=("mm/s", 1e3)
    ),
    "attitude_miss": Quantity(
        "rad",
        lambda c: c.docking.attitude_miss,
        "angle of the probe against the cone's axis where the tip crosses the capture plane",
        "attitude miss",
        signed=True,
    ),
    "attitude_miss_rate": Quantity(
        "rad/s",
        lambda c: c.docking.attitude_miss_rate,
        "how fast that changes there",
        signed=True,
    ),
    "stroke_time": time_of("stroke", "the buffer's stroke"),
    "extension_time": time_of("extension", "the buffer's extension"),
    "hinge_angle_time": time_of("hinge_angle", "the hinge angle"),
    "peak_hinge_force_time": time_of("hinge_force", "the reaction in the hinge"),
    "peak_buffer_force_time": time_of("buffer_force", "the force of the axial spring-damper"),
    "penetration": PENETRATION._replace(description="depth that the tip's deepest penetration does not exceed"),
    "contact_time": CONTACT_TIME._replace(description="time during which a flank is touched"),
    "throat_distance": Quantity(
        "m",
        lambda c: c.throat_distance,
        "tip before the capture plane at the run's end; at any time, as duration",
        "distance to the capture plane",
        signed=True,
        swept=True,
    ),
    "capture_margin": Quantity(
        "m",
        lambda c: c.capture_margin,
        "tip beyond the capture plane at the duration, coasting on, or stroke_margin",
        "capture margin",
        signed=True,
        swept=True,
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
    "buffer_friction_loss": Quantity("J", loss("buffer_friction"), "energy lost in the buffer's friction"),
    "dissipated": DISSIPATED,
    "effective_mass": Quantity("kg", lambda c: c.first_impact.effective_mass, "mass the first impact meets"),
    "effective_energy": Quantity("J", lambda c: c.first_impact.effective_energy, "T_c just before the first impact"),
    "elastic_first_peak": Quantity(
        "N", lambda c: c.first_impact.elastic_peak, "closed form of the first peak: no friction, loss, buffer"
    ),
    "predicted_first_peak": Quantity(
        "N", lambda c: c.first_impact.predicted_peak, "closed form of the first peak with the contact's loss"
    ),
    **{name: quantity for part in PARTS for name, quantity in part.quantities.items()},
}
