"""The drop onto the empty, elastic tank: the case, and what jaxbuffer finds; felupe's answer: `felupe_drop`."""

from typing import NamedTuple

import jaxbuffer as jb
from jaxbuffer.mechanisms.tank_drop.design import ZONES

DURATION = 0.055  # s
CASE = {
    "contents.kind": "none",
    "material.yield_stress": 1e12,
    "slider.mass": 20.0,
    "cushion.stiffness": 2e5,
    "cushion.damping": 1.5e3,
    "support.stiffness": 1e8,
} | {f"wall.{zone}": 0.012 for zone in ZONES}
NOTICED = ("cushion.stiffness", "cushion.damping", "slider.mass", "material.density", "material.young_modulus")
SCENARIO = jb.TankDropScenario(height=0.2)


class Dropped(NamedTuple):
    """What a program finds, of the whole tank.

    - ``force``: largest on the slider [N]; ``travel``: largest, of the slider downwards [m].
    - ``deflection``: largest, of the middle of the top downwards [m].
    - ``impulse``: of the force until the end [N s]; ``speed``: of the slider at the end, upwards [m/s].
    """

    force: float
    travel: float
    deflection: float
    impulse: float
    speed: float


def dropped(fine, changed=None, rtol=1e-6):
    """What jaxbuffer finds, its mesh ``fine`` times as fine as the coarsest."""
    design = case(fine, changed)
    run = jb.simulate(design, SCENARIO, duration=DURATION, rtol=rtol)
    return Dropped(*map(float, (run.peak_force, run.travel, run.deflection, run.impulse, run.rebound_speed)))


def extrapolated(coarse, fine):
    """From two meshes, the second twice as fine as the first, where the error is of second order."""
    return Dropped(*((4.0 * new - old) / 3.0 for old, new in zip(coarse, fine, strict=True)))


def deviations(found, reference):
    """Of each figure from a ``reference`` [-]."""
    return Dropped(*(a / b - 1.0 for a, b in zip(found, reference, strict=True)))


def altered(name, share=0.02):
    """One number of the case, larger by a ``share`` of itself."""
    part, field = name.split(".")
    return {name: (1.0 + share) * float(getattr(getattr(case(1), part), field))}


def case(fine, changed=None):
    """The design, with numbers ``changed``."""
    return jb.replace(jb.TankDrop(), CASE | {"mesh.refinement": fine} | (changed or {}))
