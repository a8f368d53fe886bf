"""The designs whose impacts tests compare with: what each has other than `SliderCrank`'s defaults."""

from __future__ import annotations

from collections.abc import Mapping

from .parameters import RPM, SliderCrank

DESIGNS: Mapping[str, Mapping[str, float]] = {
    "reference": {},
    "slow": {"speed": 200.0 * RPM},
    "slow with gravity": {"speed": 200.0 * RPM, "gravity": 9.81, "clearance": 2e-4, "slider_mass": 0.3},
    "rubbing": {"friction": 0.03},
    "rubbing under gravity": {
        "speed": 1000.0 * RPM,
        "gravity": 9.81,
        "friction": 0.1,
        "slip_speed": 0.1,
        "clearance": 1e-4,
        "restitution": 0.7,
    },
    "lossy": {"restitution": 0.46},
    "tight, rod heavy": {"speed": 3000.0 * RPM, "clearance": 2e-4, "rod_mass": 0.35, "rod_inertia": 5e-4},
    "crank pin": {"crank_pin": 1.0, "piston_pin": 0.0},
    "crank pin rubbing": {
        "crank_pin": 1.0,
        "piston_pin": 0.0,
        "speed": 2000.0 * RPM,
        "gravity": 9.81,
        "friction": 0.05,
        "slip_speed": 0.1,
        "restitution": 0.8,
        "clearance": 3e-4,
    },
    "both pins": {"crank_pin": 1.0, "clearance": 3e-4},
    "torque driven": {
        "torque_driven": 1.0,
        "speed": 1000.0 * RPM,
        "crank_inertia": 1e-4,
        "stall_torque": 20.0,
        "no_load_speed": 4000.0 * RPM,
    },
}


def crank_of(name: str) -> SliderCrank:
    """The design of that name."""
    return SliderCrank()._replace(**DESIGNS[name])
