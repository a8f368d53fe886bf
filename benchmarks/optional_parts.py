"""Every optional part of every mechanism, for random structures: which parts a design has is drawn too.

A campaign that draws numbers alone verifies one structure, and says nothing of the parts that it lacks. `structures`
draws some of a mechanism's parts at random and puts them together to a `Structure`, whose designs share one program.
A part that is new is added here, and with that to the campaigns of largest values, wide designs and elasticities, and
to the tests that use them.
"""

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np

import jaxbuffer as jb
from jaxbuffer.contact.laws import DAMPING_FACTORS, LAWS, PIN_IN_HOLE_LAWS
from jaxbuffer.fields import Part
from jaxbuffer.mechanisms.registry import mechanism_of

Ranges = dict[str, tuple[float, float]]
SHARE = 0.3  # of the structures have a part


@dataclasses.dataclass(frozen=True)
class OptionalPart:
    """What a part adds to a design and its scenario.

    ``changes``: values that make the structure; ``logarithmic``, ``even``: ranges of its numbers; ``instead_of``:
    numbers that it stands for, which are not drawn; ``not_with``: parts that it can't be combined with.
    """

    changes: dict[str, Any] = dataclasses.field(default_factory=dict)
    logarithmic: Ranges = dataclasses.field(default_factory=dict)
    even: Ranges = dataclasses.field(default_factory=dict)
    instead_of: tuple[str, ...] = ()
    not_with: tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True)
class Structure:
    """A structure of a mechanism with ranges: drawn evenly in the logarithm, or evenly; ``duration`` [s].

    ``parts``: the names of the optional parts that it has.
    """

    design: Part
    scenario: Part
    duration: float
    logarithmic: Ranges
    even: Ranges
    parts: tuple[str, ...] = ()

    def drawn(self, count: int, seed: int) -> Iterator[tuple[Any, Any]]:
        """So many designs and scenarios, always the same for a seed; those out of range are left out."""
        rng = np.random.default_rng(seed)
        for _ in range(count):
            values = {path: float(np.exp(rng.uniform(*np.log(ends)))) for path, ends in self.logarithmic.items()}
            values |= {path: float(rng.uniform(*ends)) for path, ends in self.even.items()}
            try:
                design, scenario = (jb.replace(*pair) for pair in _split(self.design, self.scenario, values))
                mechanism_of(design).check_fit(design, scenario)
            except jb.InputError:
                continue
            yield design, scenario

    def with_parts(self, parts: dict[str, OptionalPart]) -> "Structure":
        """The structure with some parts. **Raises:** `InputError` where they contradict each other."""
        changes: dict[str, Any] = {}
        logarithmic, even = dict(self.logarithmic), dict(self.even)
        for part in parts.values():
            changes |= part.changes
            logarithmic |= part.logarithmic
            even |= part.even
        for path in (path for part in parts.values() for path in part.instead_of):
            logarithmic.pop(path, None)
            even.pop(path, None)
        # Parts and start are changed together: some numbers need others.
        first = {path: float(np.sqrt(low * high)) for path, (low, high) in logarithmic.items() if _new(self, path)}
        first |= {path: 0.5 * (low + high) for path, (low, high) in even.items() if _new(self, path)}
        design, scenario = (jb.replace(*pair) for pair in _split(self.design, self.scenario, changes | first))
        latched = any(path.startswith("latch.") for path in logarithmic)
        duration = 20.0 if latched else self.duration
        return Structure(design, scenario, duration, logarithmic, even, tuple(parts))


def _new(structure: Structure, path: str) -> bool:
    """Whether a number belongs to a part that the structure itself lacks."""
    return path not in structure.logarithmic and path not in structure.even and "[" not in path


def _split(design: Part, scenario: Part, values: dict[str, Any]) -> list[tuple[Part, dict[str, Any]]]:
    """The design with its values, the scenario with its own."""
    met = {path.removeprefix("scenario."): x for path, x in values.items() if path.startswith("scenario.")}
    return [(design, {path: x for path, x in values.items() if not path.startswith("scenario.")}), (scenario, met)]


def structures(base: Structure, parts: dict[str, OptionalPart], count: int, seed: int) -> Iterator[Structure]:
    """So many random structures of a mechanism, always the same for a seed.

    Each part stands in the first structures once, alone; after those they are combined at random.
    """
    rng = np.random.default_rng([seed, 52])
    names = list(parts)
    for k in range(count):
        chosen: dict[str, OptionalPart] = {}
        for name in names[k : k + 1] if k < len(names) else rng.permutation(names):
            taken = k < len(names) or rng.uniform() < SHARE
            if taken and not any(name in parts[other].not_with or other in parts[name].not_with for other in chosen):
                chosen[str(name)] = parts[name]
        yield base.with_parts(chosen)


def _laws(names: tuple[str, ...] | list[str], path: str) -> dict[str, OptionalPart]:
    """A part for each law, of which a design has one."""
    titles = tuple(f"law {name}" for name in names)
    return {f"law {name}": OptionalPart({path: name}, not_with=titles) for name in names}


STROKES, SPEEDS = (0.005, 0.015, 0.03, 0.06), (0.02, 0.1, 0.3)  # m and m/s, of the measured curves

DOCKING_PARTS: dict[str, OptionalPart] = {
    "spring curve": OptionalPart(
        {"buffer.spring_curve": [(x, 400.0 * x) for x in STROKES]},
        even={
            "buffer.spring_curve.force[0]": (1.0, 4.0),  # N
            "buffer.spring_curve.force[1]": (5.0, 12.0),
            "buffer.spring_curve.force[2]": (14.0, 50.0),
            "buffer.spring_curve.force[3]": (60.0, 300.0),
        },
        instead_of=("buffer.k_A",),
    ),
    "damper curve": OptionalPart(
        {"buffer.damper_curve": [(v, 10.0 * v) for v in SPEEDS]},
        even={
            "buffer.damper_curve.force[0]": (0.1, 0.6),  # N
            "buffer.damper_curve.force[1]": (0.8, 4.0),
            "buffer.damper_curve.force[2]": (5.0, 40.0),
        },
        instead_of=("buffer.c_A", "buffer.c_A2"),
        not_with=("orifice",),
    ),
    "orifice": OptionalPart(logarithmic={"buffer.c_A2": (5.0, 2000.0)}),  # N s²/m²
    "preload": OptionalPart(logarithmic={"buffer.preload": (0.1, 20.0)}),  # N
    "buffer friction": OptionalPart(logarithmic={"buffer.friction": (0.05, 5.0)}),  # N
    "rebound factor": OptionalPart(logarithmic={"buffer.rebound_factor": (0.2, 5.0)}),
    "rebound stop": OptionalPart(
        logarithmic={"buffer.rebound_stiffness": (2e3, 1e5), "buffer.rebound_damping": (1.0, 100.0)}
    ),
    "end stop": OptionalPart(
        logarithmic={
            "buffer.max_stroke": (0.004, 0.08),  # m
            "buffer.stop_stiffness": (5e3, 2e5),
            "buffer.stop_damping": (1.0, 100.0),
        },
        not_with=("rubber stop",),
    ),
    "rubber stop": OptionalPart(
        logarithmic={
            "buffer.max_stroke": (0.004, 0.08),
            "buffer.stop_stiffness": (2e3, 5e4),
            "buffer.stop_damping": (0.5, 20.0),
            "buffer.stop_thickness": (0.005, 0.03),  # m
        }
    ),
    "play": OptionalPart(logarithmic={"hinge.play": (1e-5, 3e-4)}),  # m
    "bending": OptionalPart(
        logarithmic={"probe.bending_stiffness": (5.0, 500.0), "probe.bending_damping": (1e-5, 1e-3)}
    ),
    "latch": OptionalPart(
        logarithmic={
            "latch.stiffness": (200.0, 1e4),  # N/m
            "latch.damping": (5.0, 200.0),
            "latch.turn_stiffness": (1.0, 300.0),  # N m/rad
            "latch.turn_damping": (0.1, 20.0),
            "latch.closing_time": (0.005, 0.1),  # s
        }
    ),
    "lockout": OptionalPart(
        logarithmic={
            "latch.stiffness": (200.0, 1e4),  # without a latch the run ends where it would engage
            "latch.damping": (5.0, 200.0),
            "lockout.stiffness": (1e3, 1e6),  # N/m
            "lockout.damping": (10.0, 1e3),
        }
    ),
    "thrust": OptionalPart(logarithmic={"scenario.thrust": (0.1, 3.0), "scenario.thrust_time": (0.1, 3.0)}),  # N, s
    "attitude control": OptionalPart(
        logarithmic={
            "control.stiffness": (0.1, 20.0),  # N m/rad
            "control.damping": (0.1, 10.0),  # N m s/rad
            "control.limit": (0.02, 2.0),  # N m
        }
    ),
    "shock": OptionalPart(logarithmic={"shock.active_1": (5.0, 300.0), "shock.passive_1": (5.0, 300.0)}),  # Hz
    "free tip": OptionalPart({"probe.free_tip": True}),
    "free start": OptionalPart(
        {"scenario.start": "free"},
        logarithmic={"scenario.standoff": (1e-4, 0.02)},  # m
        even={
            "scenario.offset": (-0.04, 0.04),
            "scenario.active_angle": (-0.05, 0.05),  # rad
            "scenario.active_rate": (-0.01, 0.01),  # rad/s
            "scenario.lateral_speed": (-0.01, 0.01),  # m/s
        },
        instead_of=("scenario.contact_distance",),
    ),
    "smooth memory": OptionalPart({"contact.memory": "smooth"}, not_with=("law kelvin-voigt",)),
    **_laws([name for name in LAWS if name != "lankarani-nikravesh"], "contact.law"),
}

OF_THE_PLANE = ("play", "bending", "lockout")  # parts that a docking in space does not have
SPACE_PARTS: dict[str, OptionalPart] = {
    **{name: part for name, part in DOCKING_PARTS.items() if name not in OF_THE_PLANE},
    "free start": OptionalPart(
        {"scenario.start": "free"},
        logarithmic={"scenario.standoff": (1e-4, 0.02)},  # m
        even={
            **{f"scenario.offset_{axis}": (-0.03, 0.03) for axis in "yz"},
            **{f"scenario.active_{angle}": (-0.05, 0.05) for angle in ("yaw", "pitch")},  # rad
            **{f"scenario.active_rate_{axis}": (-0.01, 0.01) for axis in "yz"},  # rad/s
            **{f"scenario.lateral_speed_{axis}": (-0.01, 0.01) for axis in "yz"},  # m/s
        },
        instead_of=("scenario.contact_distance", "scenario.azimuth"),
    ),
}

CRANK_PARTS: dict[str, OptionalPart] = {
    "play in the crank pin": OptionalPart(
        {"crank_pin.joint": "clearance", "crank_pin.law": "pereira"},
        logarithmic={"crank_pin.clearance": (2e-5, 1e-3), "crank_pin.friction": (1e-3, 0.5)},
        even={"crank_pin.restitution": (0.3, 0.95)},
    ),
    "components": OptionalPart({"piston_pin.contact": "components"}),
    "torque": OptionalPart(
        {"drive.kind": "torque"}, logarithmic={"drive.torque": (0.5, 20.0), "drive.no_load_speed": (200.0, 800.0)}
    ),
    "bending rod": OptionalPart(
        {"rod.modes": 2, "rod.depth": 0.02},
        logarithmic={"rod.depth": (0.008, 0.03), "rod.damping_ratio": (0.01, 0.1)},
        instead_of=("rod.mass",),
    ),
    "gravity": OptionalPart(even={"scenario.gravity": (1.0, 20.0)}),  # m/s²
    **_laws([name for name in PIN_IN_HOLE_LAWS if name != "pereira"], "piston_pin.law"),
    **{
        f"damping {name}": OptionalPart(
            {"piston_pin.damping": name}, not_with=tuple(f"damping {other}" for other in DAMPING_FACTORS)
        )
        for name in DAMPING_FACTORS
    },
}

DROP_PARTS: dict[str, OptionalPart] = {
    "bending bar": OptionalPart({"bar.modes": 3}),
    "bending plate": OptionalPart({"plate.modes": 5}, logarithmic={"plate.thickness": (0.003, 0.02)}),
    **_laws([name for name in LAWS if name not in ("lankarani-nikravesh", "adams")], "impact.law"),
}
