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


def case(fine, changed=None):
    return jb.replace(jb.TankDrop(), CASE | {"mesh.refinement": fine} | (changed or {}))
