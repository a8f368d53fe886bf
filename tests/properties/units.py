"""The same mechanism in other units of length, mass and time, from the units its fields declare."""

import re

import numpy as np

import jaxbuffer as jb
from jaxbuffer.fields import unit

# Exponents of length, mass and time.
BASE = {
    "m": (1, 0, 0),
    "kg": (0, 1, 0),
    "s": (0, 0, 1),
    "N": (1, 1, -2),
    "Pa": (-1, 1, -2),
    "rad": (0, 0, 0),
    "1": (0, 0, 0),
    "-": (0, 0, 0),
}
POWERS = {"²": 2.0, "³": 3.0}


def exponents(text):
    """Of length, mass and time in a unit such as "N m s/rad" or "N/m^1.5"."""
    above, _, below = text.partition("/")
    total = np.zeros(3)
    for sign, part in ((1.0, above), (-1.0, below)):
        for word in part.split():
            symbol, power = re.fullmatch(r"([A-Za-z1-]+)(.*)", word).groups()
            total += sign * np.array(BASE[symbol]) * (POWERS.get(power) or float(power.lstrip("^") or 1))
    return total


def in_units(module, scales):
    """A design or scenario with every number turned by its declared unit; ``scales``: of length, mass and time."""
    values = {}
    for path in jb.paths(module):
        value, declared = jb.get(module, path), unit(module, path)
        if declared and value is not None:
            values[path] = value * float(np.prod(np.array(scales) ** exponents(declared)))
    return jb.replace(module, values)
