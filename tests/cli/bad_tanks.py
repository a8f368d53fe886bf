"""Every field of a drop onto a tank, given badly, and what does not fit together."""

import math

import numpy as np
from bad_fields import ABOVE, FROM
from bad_inputs import call, line, toml

import jaxbuffer as jb

KIND = 'kind = "tank_drop"\n'
ZONES = ("bottom", "lower_corner", "lower_side", "upper_side", "upper_corner", "top")
MODULI = ("along", "across", "shear")
STRENGTHS = ("along_tension", "along_compression", "across_tension", "across_compression", "shear_strength")
FIELDS = {  # of design and scenario: a number that is out of range, the range, the unit
    **{f"wall.{zone}": (0.031, "(0, 0.03]", "m") for zone in ZONES},
    "ribs.height": (0.11, "(0, 0.1]", "m"),
    "ribs.share": (1.1, "(0, 1]", ""),
    "plates.thickness": (0.031, "(0, 0.03]", "m"),
    "plates.position": (0, ABOVE, "m"),
    "plates.aperture": (1.1, "(0, 1]", ""),
    "plates.hole_diameter": (0, ABOVE, "m"),
    "tank.width": (0, ABOVE, "m"),
    "tank.height": (-0.3, ABOVE, "m"),
    "tank.corner_radius": (0, ABOVE, "m"),
    "tank.length": (-1, ABOVE, "m"),
    "material.density": (0, ABOVE, "kg/m³"),
    "material.young_modulus": (-1e9, ABOVE, "Pa"),
    "material.poisson_ratio": (0.5, "(-1, 0.5)", ""),
    "material.yield_stress": (0, ABOVE, "Pa"),
    "material.hardening": (-1, FROM, "Pa"),
    "material.failure_strain": (0, ABOVE, ""),
    "composite.density": (0, ABOVE, "kg/m³"),
    "composite.poisson": (1, "[0, 1)", ""),
    **{f"composite.{name}": (-1, ABOVE, "Pa") for name in (*MODULI, *STRENGTHS)},
    "contents.density": (0, ABOVE, "kg/m³"),
    "contents.sound_speed": (0, ABOVE, "m/s"),
    "contents.air_pressure": (0, ABOVE, "Pa"),
    "cushion.thickness": (0, ABOVE, "m"),
    "cushion.stiffness": (-4e6, ABOVE, "Pa/m"),
    "cushion.damping": (-1, FROM, "Pa s/m"),
    "slider.mass": (-348, ABOVE, "kg"),
    "support.stiffness": (0, ABOVE, "Pa/m"),
    "scenario.height": (math.inf, ABOVE, "m"),
    "scenario.fill": (0.1, "[0.15, 1]", ""),
    "scenario.gravity": (0, ABOVE, "m/s²"),
    "scenario.angle": (0.6, "[-0.5, 0.5]", "rad"),
}
CHOICES = {
    "ribs.kind": "none, rings",
    "plates.kind": "none, perforated",
    "material.kind": "plastic, composite",
    "composite.criterion": "tsai-hill, hoffman, tsai-wu, maximum-stress",
    "contents.kind": "liquid, full, none",
    "contents.air": "open, trapped",
    "cushion.kind": "layer, none",
    "support.method": "defence node, multiplier, penalty",
    "mesh.refinement": "a whole number from 1 to 8",
    "mesh.extent": "half, whole",
}


def of_fields():
    """Each field out of range, as something else than a number, and as NaN in Python."""
    for path, (bad, allowed, its_unit) in FIELDS.items():
        section, name = path.split(".")
        symbol = f" {its_unit}" if its_unit else ""
        rest = f"is out of range; allowed: {allowed}{symbol}"
        yield toml(f"{KIND}[{section}]\n{name} = {bad}", f"{path} = {bad:g}{symbol} {rest}")
        yield line(
            f"simulate study.toml --{path}=thick",
            f"{path}: 'thick' is not a number; expected {allowed}{symbol}",
            study=KIND,
        )
        design, values = jb.TankDrop(), {path.removeprefix("scenario."): math.nan}
        part = jb.TankDropScenario() if section == "scenario" else design
        yield call(lambda part=part, values=values: jb.replace(part, values), f"{path} = nan{symbol} {rest}")
    for path, words in CHOICES.items():
        section, name = path.split(".")
        yield toml(f"{KIND}[{section}]\n{name} = 'fizz'", f"{path} = 'fizz'", words)


def _study(text, *parts):
    return toml(KIND + text, *parts)


THIN = "[tank]\ncorner_radius = 0.02\n"
BELOW = "m is out of range; allowed: (0, 0.02) m, less than tank.corner_radius"
INSIDE = "[plates]\nkind = 'perforated'\n"
BESIDE = "m is out of range; allowed: (0.0025, 0.2575) m, where the whole plate stands on the flat bottom"
TOGETHER = [
    _study(
        "[scenario]\nfill = '96 %'",
        "scenario.fill = 96 % is out of range; allowed: ",
        'or 1, with contents.kind = "full"',
    ),
    _study("[contents]\nkind = 'full'", 'scenario.fill = 0.8: contents.kind = "full" needs 1'),
    _study(f"{THIN}[wall]\ntop = 0.025", f"wall.top = 0.025 {BELOW}"),
    line("sweep study.toml", f"wall.top = 0.025 {BELOW}", study=f"{KIND}{THIN}[sweep]\nwall.top = [0.01, 0.025]"),
    line(
        "simulate study.toml --wall.lower_side 20mm",
        "wall.lower_side = 20 mm is out of range; allowed: (0, 20) mm, less than tank.corner_radius",
        study=KIND + THIN,
    ),
    line("tune study.toml --wall.top 0.021", f"wall.top = 0.021 {BELOW}", study=KIND + THIN),
    line("sweep study.toml --over wall.bottom=5mm:30mm:2", f"wall.bottom = 0.03 {BELOW}", study=KIND + THIN),
    call(
        lambda: jb.simulate(jb.replace(jb.TankDrop(), {"tank.corner_radius": 0.005}), jb.TankDropScenario()),
        "wall.bottom = 0.005 m is out of range; allowed: (0, 0.005) m, less than tank.corner_radius",
    ),
    _study(
        "[tank]\ncorner_radius = 0.15",
        "tank.corner_radius = 0.15 m is out of range; allowed: (0, 0.15) m, less than half of tank.height = 0.3 m",
    ),
    call(
        lambda: jb.replace(jb.TankDrop(), {"tank.width": np.array([0.6, 0.07])}),
        "tank.corner_radius = 0.04 m is out of range; allowed: (0, 0.035) m",
        "and of tank.width = 0.07 m",
    ),
    _study(f"{INSIDE}position = 0.258", f"plates.position = 0.258 {BESIDE}"),
    _study("[scenario]\nangle = '5°'", 'an angle other than 0 needs mesh.extent = "whole"'),
    line("sweep study.toml --over plates.position=0.1:0.27:2", f"plates.position = 0.27 {BESIDE}", study=KIND + INSIDE),
]
WORDS = [
    _study("[wall]\ntop = 12", 'wall.top = 12 m is out of range; allowed: (0, 0.03] m; "12 mm" if that is meant'),
    _study("[scenario]\nfill = 60", 'allowed: [0.15, 1]; "60 %" if that is meant'),
    _study("[scenario]\nfill = '101 %'", "scenario.fill = 101 % is out of range; allowed: [15, 100] %"),
    _study("[scenario]\nfill = nan", "scenario.fill = nan is out of range; allowed: [0.15, 1]"),
    _study("[cushion]\nstiffness = '4 N/m'", "'4 N/m': N/m is a stiffness, expected a number in Pa/m"),
    _study("[mesh]\nrefinement = 0", "mesh.refinement = 0 must be a whole number from 1 to 8"),
    _study("[mesh]\nrefinement = 9", "mesh.refinement = 9 must be a whole number from 1 to 8"),
    _study("[mesh]\nrefinement = 1.5", "mesh.refinement = 1.5 must be a whole number from 1 to 8"),
    _study("[support]\nmethod = 'penality'", "did you mean penalty?"),
    _study("[contents]\nkind = 'water'", "contents.kind = 'water' is unknown; choose one of liquid, full, none"),
    _study("[wall]\nlower_corer = 0.01", "wall.lower_corer is unknown; did you mean wall.lower_corner?"),
    _study("[wall]\nthickness = 0.01", "wall.thickness is unknown; known: wall.bottom, wall.lower_corner"),
    _study("wall = 0.012", "wall = 0.012 is not a table; write [wall] and its fields below it"),
    _study("[cushon]\nstiffness = 1", "[cushon] is unknown; did you mean cushion?"),
    _study("[buffer]\nk_A = 1", "[buffer] is unknown; did you mean [cushion]"),
    _study("[liquid]\ndensity = 1000", "[liquid] is unknown; did you mean [contents]"),
    _study("[scenario]\napproach_speed = 2", "approach_speed is unknown; known: scenario.height, scenario.fill"),
    _study("[options]\nduration = inf", "duration = inf s is out of range; allowed: (0, inf) s"),
    _study(
        "[problem.variables]\nwall.top = ['4 mm', '50 mm']", "wall.top = 50 mm is out of range; allowed: (0, 30] mm"
    ),
    _study(
        "[problem.constraints]\nstroke = 0.1",
        "constraints.stroke is unknown; known: require_success, impacts, peak_force",
    ),
    _study("[problem.grid]\napproach_speed = [1]", "grid.approach_speed is unknown; known: height, fill, gravity"),
    toml('kind = "tankdrop"', "kind = 'tankdrop' is unknown", "did you mean tank_drop?"),
    line("sensitivity study.toml --wrt wall.tip", "wall.tip is unknown; did you mean wall.top?", study=KIND),
    line("sensitivity study.toml --wrt mesh.refinement", "1 is not a number that can be differentiated", study=KIND),
    line("sensitivity study.toml --of peak_stres", "peak_stres is unknown; did you mean peak_stress?", study=KIND),
    line("sweep study.toml --over scenario.fill=0:1:5", "fill = 0 is out of range; allowed: [0.15, 1]", study=KIND),
    line("simulate study.toml --height 0.3", "No such option: --height; did you mean --scenario.height?", study=KIND),
]
TANKS = [*of_fields(), *TOGETHER, *WORDS]
