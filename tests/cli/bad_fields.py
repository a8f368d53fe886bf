"""Every field of design and scenario, given badly."""

import math

from bad_inputs import call, line, toml

from jaxbuffer import Scenario, get, replace, table2

ABOVE, FROM = "(0, inf)", "[0, inf)"
FIELDS = {  # of design and scenario: a number that is out of range, the range, the unit
    "active.mass": (-1, ABOVE, "kg"),
    "active.inertia": (0, ABOVE, "kg m²"),
    "active.hinge_offset": (-0.1, FROM, "m"),
    "passive.mass": (0, ABOVE, "kg"),
    "passive.inertia": (-2, ABOVE, "kg m²"),
    "buffer.k_A": (-500, ABOVE, "N/m"),
    "buffer.c_A": (-5, FROM, "N s/m"),
    "buffer.k_T": (0, ABOVE, "N m/rad"),
    "buffer.c_T": (-1e-9, FROM, "N m s/rad"),
    "buffer.free_length": (0, ABOVE, "m"),
    "buffer.cylinder_mass": (-1, ABOVE, "kg"),
    "buffer.cylinder_length": (0, ABOVE, "m"),
    "buffer.max_stroke": (0, ABOVE, "m"),
    "buffer.stop_stiffness": (-1, ABOVE, "N/m"),
    "buffer.stop_damping": (-20, FROM, "N s/m"),
    "buffer.stop_thickness": (0, ABOVE, "m"),
    "buffer.preload": (-1, FROM, "N"),
    "buffer.preload_length": (0, ABOVE, "m"),
    "buffer.c_A2": (-10, FROM, "N s²/m²"),
    "buffer.rebound_factor": (0, ABOVE, ""),
    "buffer.friction": (-2, FROM, "N"),
    "buffer.friction_speed": (0, ABOVE, "m/s"),
    "buffer.rebound_stiffness": (0, ABOVE, "N/m"),
    "buffer.rebound_damping": (-5, FROM, "N s/m"),
    "buffer.rebound_gap": (0, ABOVE, "m"),
    "probe.length": (-0.2, ABOVE, "m"),
    "probe.rod_mass": (0, ABOVE, "kg"),
    "probe.tip_radius": (-0.015, ABOVE, "m"),
    "probe.tip_mass": (0, ABOVE, "kg"),
    "probe.bending_stiffness": (0, ABOVE, "N m²"),
    "probe.bending_damping": (-1e-5, FROM, "s"),
    "hinge.play": (0, ABOVE, "m"),
    "hinge.bush_radius": (-0.005, ABOVE, "m"),
    "hinge.damping": (-1, FROM, "s/m"),
    "hinge.young_modulus": (0, ABOVE, "Pa"),
    "hinge.poisson_ratio": (0.6, "(-1, 0.5]", ""),
    "cone.half_angle": (2, "(0, 1.5708)", "rad"),
    "cone.offset": (-0.1, FROM, "m"),
    "cone.throat_radius": (0, ABOVE, "m"),
    "cone.length": (-1, ABOVE, "m"),
    "cone.young_modulus": (0, ABOVE, "Pa"),
    "cone.poisson_ratio": (0.6, "(-1, 0.5]", ""),
    "contact.stiffness": (0, ABOVE, "N/m^1.5"),
    "contact.restitution": (1.1, "(0, 1]", ""),
    "contact.friction": (-0.3, FROM, ""),
    "contact.slip_speed": (0, ABOVE, "m/s"),
    "contact.young_modulus": (-1, ABOVE, "Pa"),
    "contact.poisson_ratio": (0.6, "(-1, 0.5]", ""),
    "contact.yield_stress": (0, ABOVE, "Pa"),
    "contact.linear_stiffness": (0, ABOVE, "N/m"),
    "contact.damping": (-80, FROM, "N s/m"),
    "contact.exponent": (0.9, "[1, inf)", ""),
    "contact.ramp_depth": (0, ABOVE, "m"),
    "contact.onset_length": (-1e-8, ABOVE, "m"),
    "contact.memory_time": (0, ABOVE, "s"),
    "latch.stiffness": (0, ABOVE, "N/m"),
    "latch.damping": (-500, FROM, "N s/m"),
    "latch.preload": (-1, FROM, "N"),
    "latch.preload_length": (0, ABOVE, "m"),
    "latch.turn_stiffness": (-1, FROM, "N m/rad"),
    "latch.turn_damping": (-1, FROM, "N m s/rad"),
    "latch.closing_time": (-0.02, FROM, "s"),
    "latch.depth": (math.inf, "(-inf, inf)", "m"),
    "latch.strength": (0, ABOVE, "N"),
    "latch.quiet": (1, "(0, 1)", ""),
    "lockout.stiffness": (0, ABOVE, "N/m"),
    "lockout.damping": (-1, FROM, "N s/m"),
    "control.stiffness": (0, ABOVE, "N m/rad"),
    "control.damping": (-1, FROM, "N m s/rad"),
    "control.limit": (0, ABOVE, "N m"),
    **{f"shock.{vehicle}_{k}": (-20, ABOVE, "Hz") for vehicle in ("active", "passive") for k in (1, 2, 3)},
    "shock.damping": (1, "[0, 1)", ""),
    "scenario.approach_speed": (-0.1, ABOVE, "m/s"),
    "scenario.contact_distance": (0, ABOVE, "m"),
    "scenario.misalignment": (-1.6, "(-1.5708, 1.5708)", "rad"),
    "scenario.passive_rate": (math.inf, "(-inf, inf)", "rad/s"),
    "scenario.offset": (math.inf, "(-inf, inf)", "m"),
    "scenario.standoff": (-0.01, FROM, "m"),
    "scenario.active_angle": (1.6, "(-1.5708, 1.5708)", "rad"),
    "scenario.active_rate": (-math.inf, "(-inf, inf)", "rad/s"),
    "scenario.lateral_speed": (math.inf, "(-inf, inf)", "m/s"),
    "scenario.thrust": (math.inf, "(-inf, inf)", "N"),
    "scenario.thrust_time": (0, ABOVE, "s"),
}
CHOICES = {
    "buffer.damping": "physical, published",
    "buffer.spring_curve": "is not a curve; write a list of points [stroke [m], force [N]], rising in both",
    "buffer.damper_curve": "is not a curve; write a list of points [speed [m/s], force [N]], rising in both",
    "contact.law": "lankarani-nikravesh, hertz",
    "contact.memory": "event, smooth",
    "contact.arms": "moving, published",
    "scenario.start": "contact, free",
    "control.until": "contact, latch, end",
    "probe.free_tip": "true or false",
    "probe.bending_modes": "a whole number of at least 2",
}


def of_fields():
    """Each field out of range, as something else than a number, with a unit that there is not, with one of another
    dimension, and as NaN."""
    for k, (path, (bad, allowed, its_unit)) in enumerate(FIELDS.items()):
        section, name = path.split(".")
        symbol = f" {its_unit}" if its_unit else ""
        low = f"{path} = {bad:g}{symbol} is out of range; allowed: {allowed}{symbol}"
        word = f"{path}: 'stiff' is not a number; expected {allowed}{symbol}"
        nan = f"{path} = nan{symbol} is out of range; allowed: {allowed}{symbol}"
        yield toml(f"[{section}]\n{name} = {bad}", low)
        yield line(f"simulate --{path}=stiff", word)
        yield toml(f"[{section}]\n{name} = '7 fizz'", f"{path} = '7 fizz': the unit fizz is unknown; expected a")
        yield toml(f"[{section}]\n{name} = '7 kg h'", f"{path} = '7 kg h': kg h does not fit, expected a", allowed)
        if section == "scenario":
            yield call(lambda name=name: Scenario(**{name: math.nan}), nan)
        else:
            yield call(
                lambda path=path, k=k: replace(
                    table2(), {path: (math.nan, [get(table2(), path) or 0.25, math.nan])[k % 2]}
                ),
                nan,
            )
    for path, words in CHOICES.items():
        section, name = path.split(".")
        yield toml(f"[{section}]\n{name} = 'fizz'", f"{path} = 'fizz'", words)
