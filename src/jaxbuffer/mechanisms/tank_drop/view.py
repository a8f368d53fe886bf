"""What is told of a drop onto a tank and drawn of it."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...structures.contact import SOLID
from ...value_text import degrees_text, percent_text
from ..validity import ValidityLimit
from ..view import Names, Synonym, View
from .design import TankDrop, TankDropScenario
from .drawing import drawing
from .meshes import meshes
from .numbering import Numbering
from .outcome import FORMS
from .panels import panels
from .stepping import ATMOSPHERE
from .tank_run import TankRun


def label(scenario: TankDropScenario, among: Any = ()) -> str:
    """Return what people call a drop: "from 2.04 m, filled to 80 %"."""
    turned = f", at {degrees_text(math.degrees(float(scenario.angle)), sign=False)}" if float(scenario.angle) else ""
    return f"from {float(scenario.height):.4g} m, filled to {percent_text(float(scenario.fill), '.4g')}{turned}"


def warnings(run: TankRun) -> list[str]:
    """Return a line for each limit that a run exceeds."""
    design = run.design
    lines = []
    yields = design.material.kind == "plastic" and float(run.reserve) < 1.0
    if yields and design.mesh.refinement == 1:
        lines.append(
            "the wall yields: with one element across it a wall bent until it yields carries up to 16 % too much;"
            " compare with mesh.refinement = 2"
        )
    layered = design.material.kind == "composite"  # the ply with the least reserve is not told
    if design.plates.kind != "none" and (layered or Numbering.of(design).at_a_joint(int(run.stress_element))):
        lines.append(
            f"the largest stress {'may be' if layered else 'is'} where a plate meets the wall, in a corner without a"
            " fillet: it grows with a finer mesh, and the reserve falls; compare with mesh.refinement = 2"
        )
    compressed = percent_text(float(run.compression), ".3g")
    if float(run.compression) > 1.0:
        lines.append(
            f"the cushion is pressed together by {compressed} of its thickness: the slider is inside the wall, and no"
            " number is sure; take a stiffer or thicker cushion"
        )
    elif float(run.compression) > SOLID:
        lines.append(f"the cushion is solid: {compressed} of its thickness are used up")
    if design.contents.kind != "none" and float(run.lowest_pressure) < -ATMOSPHERE:
        lines.append(
            f"the liquid would be torn: its pressure falls to {1e-3 * float(run.lowest_pressure):.4g} kPa over the"
            " atmosphere's, and no cavities are computed"
        )
    if float(run.deflection) > 0.5 * float(design.tank.height):
        lines.append("the tank is crushed: its top comes down by more than half of its height, and walls do not touch")
    if len(order := _failures(run)) > 1:
        lines.append(f"in order of time: {', '.join(order)}")
    return lines


def in_order(run: TankRun) -> str:
    """Return the forms in which a tank fails, as they come, with their times; "" if there is none."""
    return ", ".join(_failures(run))


def _failures(run: TankRun) -> list[str]:
    times = {what: float(getattr(run, f"{form}_time")) for form, what in FORMS.items()}
    happened = sorted((at, what) for what, at in times.items() if math.isfinite(at))
    return [f"{what} ({1e3 * at:.3g} ms)" for at, what in happened]


def names(design: TankDrop) -> Names:
    """Return what the parts of a design are called."""
    others = {"deflection": "m", "support_force": "N", "peak_stress": "Pa", "peak_plastic_strain": "-"}
    if design.contents.kind != "none":
        others |= {"highest_pressure": "Pa", "lowest_pressure": "Pa"}
    return Names(bodies=("slider",), contacts=("cushion" if design.cushion.kind == "layer" else "wall",), others=others)


def validity(design: TankDrop, quantities: Mapping[str, Any]) -> list[ValidityLimit]:
    """Return how near cushions come to being solid."""
    if "penetration" not in quantities:
        return []
    used = np.asarray(quantities["penetration"]) / (SOLID * np.asarray(design.cushion.thickness))
    return [ValidityLimit("the cushion is solid: more than 80 % of its thickness are used up", used)]


VIEW = View(
    title="Drop onto a tank",
    synonyms={
        "liquid": Synonym("contents", "the liquid that the tank holds, if any"),
        "buffer": Synonym("cushion", "the layer under the slider: what is a buffer here"),
    },
    run_name="drop",
    contact="cushion",
    names=names,
    label=label,
    approach=label,
    limitations=(
        "The tank is infinitely long: its ends are left out (plane strain), and ribs are spread evenly along it.",
        "The liquid is a linear acoustic medium on the mesh it has at rest; it neither flows nor is torn, and"
        " neither baffle plates nor ribs hinder it.",
        "Walls do not touch each other; a wall with a hole does not leak.",
        "Nothing has been compared with a measurement: the paper prints no value of any result.",
    ),
    warnings=warnings,
    validity=validity,
    panels=panels,
    meshes=meshes,
    drawing=drawing,
)
