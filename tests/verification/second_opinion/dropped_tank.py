"""Drops onto the tank, empty, with liquid, with plates and until the wall yields, and what jaxbuffer finds; felupe:
`felupe_drop`."""

from typing import NamedTuple

import numpy as np

import jaxbuffer as jb
from jaxbuffer.mechanisms.tank_drop.design import ZONES
from jaxbuffer.mechanisms.tank_drop.numbering import Numbering

NEVER = 1e12  # Pa: a wall with this yield stress is elastic
CASE = {
    "contents.kind": "none",
    "material.yield_stress": NEVER,
    "slider.mass": 20.0,
    "cushion.stiffness": 2e5,
    "cushion.damping": 1.5e3,
    "support.stiffness": 1e8,
} | {f"wall.{zone}": 0.012 for zone in ZONES}


class Case(NamedTuple):
    """What is dropped: changes of the elastic tank's design, height [m], duration [s] and gravity [m/s²]."""

    changes: dict
    height: float
    duration: float
    gravity: float = 9.81

    @property
    def scenario(self):
        return jb.TankDropScenario(height=self.height, gravity=self.gravity)


CASES = {
    "empty": Case(CASE, 0.2, 0.055),
    "liquid": Case(CASE | {"contents.kind": "liquid"}, 0.02, 0.03),  # the middle of the bottom stays on the baffle
    "plates": Case(CASE | {"plates.kind": "perforated", "plates.thickness": 0.006}, 0.2, 0.03),
    # As "empty", all lengths and stresses a thousandth: felupe's flow is for small strains.
    "yielding": Case(CASE | {"material.yield_stress": 1.5e3}, 2e-4, 0.055, 9.81e-3),
}
NOTICED = {  # fields of which 2 % more would be noticed
    "empty": ("cushion.stiffness", "cushion.damping", "slider.mass", "material.density", "material.young_modulus"),
    "liquid": ("contents.density",),
    "plates": ("plates.position",),
    "yielding": ("material.yield_stress",),
}


class Dropped(NamedTuple):
    """What a program finds, of the whole tank.

    - ``force``: largest on the slider [N]; ``travel``: largest, of the slider downwards [m].
    - ``deflection``: largest, of the middle of the top downwards [m].
    - ``impulse``: of the force until the end [N s]; ``speed``: of the slider at the end, upwards [m/s].
    - ``energy``: by which the liquid's has risen at most, with the work of its static pressure [J].
    - ``plastic_work``: of the wall [J].
    - ``time`` [s], ``pressed``: ∫p dt in the middle of the bottom, p beyond the static pressure [Pa s].
    """

    force: float
    travel: float
    deflection: float
    impulse: float
    speed: float
    energy: float
    plastic_work: float
    time: np.ndarray
    pressed: np.ndarray


DRY, WET = Dropped._fields[:5], Dropped._fields[:6]  # the figures of a tank without liquid, and with it
FLOWING = (*DRY, "plastic_work")  # and of a wall that yields
FIGURES = {"empty": DRY, "liquid": WET, "plates": DRY, "yielding": FLOWING}


def dropped(fine, name="empty", changed=None, rtol=1e-6):
    """What jaxbuffer finds, its mesh ``fine`` times as fine as the coarsest."""
    design, case = design_of(name, fine, changed), CASES[name]
    run = jb.simulate(design, case.scenario, duration=case.duration, rtol=rtol, history=True)
    numbers = run.peak_force, run.travel, run.deflection, run.impulse, run.rebound_speed
    time, pressure, energy = np.asarray(run.history.time), np.zeros(1), np.zeros(1)
    if design.contents.kind != "none":
        pressure = np.asarray(run.history.others["pressure"])[:, Numbering.of(design).liquid[0, 0]]
        energy = np.asarray(run.history.energy.stored["liquid"])
    others = energy.max() - energy[0], run.plastic_work
    return Dropped(*map(float, (*numbers, *others)), time, summed(time, pressure - pressure[0]))


def summed(time, pressure):
    """∫p dt over time [Pa s], by trapezia."""
    steps = 0.5 * (pressure[1:] + pressure[:-1]) * np.diff(time) if len(pressure) > 1 else pressure
    return np.concatenate([np.zeros(1), np.cumsum(steps)])


def extrapolated(coarse, fine):
    """Figures from two meshes, the second twice as fine as the first, where the error is of second order."""
    names = Dropped._fields[:7]
    return coarse._replace(**{name: (4.0 * getattr(fine, name) - getattr(coarse, name)) / 3.0 for name in names})


def deviations(found, reference, names=DRY):
    """Of each figure from a ``reference`` [-]."""
    return {name: getattr(found, name) / getattr(reference, name) - 1.0 for name in names}


def apart(found, reference):
    """Root mean square difference of two ∫p dt over time, over the largest of the reference's [-]."""
    other = np.interp(reference.time, found.time, found.pressed)
    return float(np.sqrt(np.mean((other - reference.pressed) ** 2)) / np.abs(reference.pressed).max())


def altered(name, field, share=0.02):
    """One number of a case's design, larger by a ``share`` of itself."""
    part, number = field.split(".")
    return {field: (1.0 + share) * float(getattr(getattr(design_of(name, 1), part), number))}


def design_of(name, fine, changed=None):
    """Of one of `CASES`, with numbers ``changed``."""
    return jb.replace(jb.TankDrop(), CASES[name].changes | {"mesh.refinement": fine} | (changed or {}))
