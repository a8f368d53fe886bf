"""The catalogue of a capture's quantities."""

import math
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from ..quantity import CONTACT_TIME, DISSIPATED, END_TIME, PEAK_FORCE, PEAK_TIME, PENETRATION, Quantity
from .latch_energy import closing_energy, closing_share, reference_share
from .law_validity import pressure
from .shock import SLOTS, VEHICLES
from .vehicle_forces import peak_vehicle_force


def _loss(name: str) -> Callable[[Any], Any]:
    """Return how the energy lost in a place is read off, which not every design has."""
    # Times a loss that every capture has, so that the zero has the shape of many runs and is NaN where one failed.
    return lambda capture: capture.energy.lost.get(name, 0.0 * capture.energy.friction)


def _time_of(maximum: str, what: str) -> Quantity:
    """Return the time of one of the run's maxima as a quantity, which a finished run alone has."""
    return Quantity(
        "s",
        lambda capture: jnp.asarray(capture.maximum_times.get(maximum, math.nan)),
        f"when {what} is largest, of a finished run",
        differentiable=False,
    )


def _shock(vehicle: str, slot: int) -> Quantity:
    """Return the shock at one of the frequencies that a design names, as a quantity."""
    name, field = f"{vehicle}_shock_{slot}", f"shock.{vehicle}_{slot}"
    return Quantity(
        "m/s²",
        # Put on the device where there is none: any operation would be a program of its own.
        lambda capture: capture.maxima.get(name, jax.device_put(np.full(np.shape(capture.end_time), np.nan))),
        f"largest absolute acceleration, in any direction, of an oscillator of {field} on the {vehicle} vehicle",
        f"shock on the {vehicle} vehicle at {field}",
        swept=True,
        tuned=True,
        part=field,
    )


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
    "bending": Quantity(
        "m",
        lambda c: c.bending,
        "largest displacement of the tip off the axis of a probe that bends",
        "bending of the probe",
        swept=True,
        tuned=True,
        part="probe.bending_stiffness",
    ),
    "end_time": END_TIME._replace(description="end of the run: of a captured one, the capture time"),
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
    ),
    "peak_latch_force": Quantity(
        "N",
        lambda c: c.peak_latch_force,
        "largest force of the latches",
        "peak latch force",
        swept=True,
        tuned=True,
        part="latch.stiffness",
    ),
    "latch_share": Quantity(
        "-",
        lambda c: c.docking.latch_share,
        "largest force of the latches over their strength; of torn ones above 1",
        "share of the latches' strength",
        tuned=True,
        part="latch.strength",
    ),
    "latch_time": Quantity(
        "s",
        lambda c: c.docking.latch_time,
        "when the tip crosses the capture plane and the latches begin to close",
        "latch time",
        swept=True,
        part="latch.stiffness",
    ),
    "settling_time": Quantity(
        "s",
        lambda c: c.docking.settling_time,
        "from the latching until the vehicles are held; NaN where they are not yet",
        "settling time",
        swept=True,
        tuned=True,
        part="latch.stiffness",
        awaits="held",
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
    "latch_energy": Quantity(
        "J",
        closing_energy,
        "energy that the closing of the latches put in",
        "energy put in by the latches",
        tuned=True,
        part="latch.stiffness",
    ),
    "latch_energy_share": Quantity(
        "-",
        closing_share,
        "that over the energy of relative motion at the start",
        "share of energy put in by the latches",
        tuned=True,
        shown=("%", 100.0),
        part="latch.stiffness",
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
    "peak_passive_acceleration": Quantity(
        "m/s²",
        lambda c: c.passive_force / c.design.passive.mass,
        "largest acceleration of the passive vehicle's centre of mass, with latches or from a free start",
        "peak acceleration of the passive vehicle",
        tuned=True,
        part="latch.stiffness",
    ),
    **{f"{vehicle}_shock_{k + 1}": _shock(vehicle, k + 1) for vehicle in VEHICLES for k in range(SLOTS)},
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
    "stroke_time": _time_of("stroke", "the buffer's stroke"),
    "extension_time": _time_of("extension", "the buffer's extension"),
    "hinge_angle_time": _time_of("hinge_angle", "the hinge angle"),
    "peak_hinge_force_time": _time_of("hinge_force", "the reaction in the hinge"),
    "peak_buffer_force_time": _time_of("buffer_force", "the force of the axial spring-damper"),
    "peak_latch_force_time": _time_of("latch_force", "the force of the latches"),
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
    "bending_loss": Quantity("J", lambda c: c.energy.bending, "energy lost in the probe's bending"),
    "play_loss": Quantity("J", lambda c: c.energy.hinge_play, "energy lost in the play of the hinge"),
    "stop_loss": Quantity("J", lambda c: c.energy.stop_damper, "energy lost in the buffer's end stop"),
    "buffer_friction_loss": Quantity("J", _loss("buffer_friction"), "energy lost in the buffer's friction"),
    "rebound_loss": Quantity("J", _loss("rebound_damper"), "energy lost in the buffer's rebound stop"),
    "latch_loss": Quantity("J", _loss("latch_damper"), "energy lost in the latches"),
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
