"""The units that there are, and pint's (https://pint.readthedocs.io) registry of them.

The short list below stands in place of pint's own: a plane angle is a dimension here, so that Hz is not taken for
rad/s, and no two units share a symbol. pint is imported when the first text with a unit is met.
"""

import functools
import re
from typing import Any

from ..errors import nearest, shown

WORD = re.compile(r"[^\W\d_]+|°|%")  # of a unit
DEFINITIONS = """\
giga- = 1e9 = G-
mega- = 1e6 = M-
kilo- = 1e3 = k-
centi- = 1e-2 = c-
milli- = 1e-3 = m-
micro- = 1e-6 = µ- = μ- = u-
nano- = 1e-9 = n-
meter = [length] = m = metre
second = [time] = s = sec
gram = [mass] = g
radian = [angle] = rad
percent = 0.01 = %
minute = 60 * second = min
hour = 60 * minute = h
tonne = 1000 * kilogram = t
newton = kilogram * meter / second ** 2 = N
pascal = newton / meter ** 2 = Pa
bar = 1e5 * pascal
joule = newton * meter = J
watt = joule / second = W
hertz = 1 / second = Hz
degree = 0.017453292519943295 * radian = deg = °
turn = 6.283185307179586 * radian = rev = revolution
rpm = turn / minute
inch = 0.0254 * meter = in
foot = 0.3048 * meter = ft
pound = 0.45359237 * kilogram = lb
pound_force = 4.4482216152605 * newton = lbf
"""
SYMBOLS = (
    *("m", "mm", "cm", "km", "µm", "s", "ms", "µs", "min", "h", "kg", "g", "t", "rad", "mrad", "deg", "turn", "rpm"),
    *("N", "kN", "MN", "mN", "Pa", "kPa", "MPa", "GPa", "bar", "J", "mJ", "kJ", "W", "Hz", "kHz"),
    *("in", "ft", "lb", "lbf"),
)
KINDS = {
    **{"m": "a length", "s": "a time", "kg": "a mass", "rad": "an angle", "m/s": "a speed", "N": "a force"},
    **{"rad/s": "a rate of turning", "N/m": "a stiffness", "N s/m": "a damping", "Pa": "a pressure"},
    **{"N m": "a torque or an energy", "1/s": "a frequency", "kg m²": "an inertia", "m²": "an area"},
    **{"N m/rad": "a stiffness about a hinge", "N m s/rad": "a damping about a hinge", "-": "a plain number"},
    **{"m/s²": "an acceleration", "kg/m³": "a density", "N s": "an impulse"},
}


@functools.cache
def registry() -> Any:
    """Return pint's registry of the units above."""
    # It is needed only where a text has a unit.
    import pint

    units: Any = pint.UnitRegistry(None)
    units.load_definitions(DEFINITIONS.splitlines())
    return units


@functools.cache
def parsed(symbol: str) -> Any:
    """Return a unit from its symbol; spaces multiply, and what follows a / up to the next one divides, as in tables."""
    plain = "" if symbol == "-" else re.sub(r"^1\s*/", "dimensionless/", symbol.replace("·", " "))
    return registry().parse_units(plain)


def unknown_unit(symbol: str) -> str:
    """Return which word of a unit is unknown, and the unit meant."""
    for word in WORD.findall(symbol):
        try:
            parsed(word)
        except Exception:
            near = next((s for s in SYMBOLS if s.lower() == word.lower()), None) or nearest(word, SYMBOLS)
            # A plural is meant before anything that only looks alike.
            if word[-1] == "s" and word[:-1] in SYMBOLS:
                near = word[:-1]
            # Two symbols may be written as one word: "Nm" for "N m".
            elif two := [(word[:k], word[k:]) for k in range(1, len(word)) if {word[:k], word[k:]} <= set(SYMBOLS)]:
                near = " ".join(two[0])
            return f"the unit {word} is unknown" + (f"; did you mean {near}?" if near else "")
    return f"{shown(symbol)} is not a unit"


def instead(symbol: str, unit: str) -> str:
    """Return what to write instead of a unit that does not fit, after a semicolon; "" where nothing is likely."""
    if unit == "rad/s" and parsed(symbol).dimensionality == parsed("Hz").dimensionality:
        return "; for turns a second write turn/s or rpm"
    if "/rad" in unit and parsed(symbol).dimensionality == parsed(unit.replace("/rad", "")).dimensionality:
        return f"; write {symbol}/rad or {symbol}/deg"
    return ""
