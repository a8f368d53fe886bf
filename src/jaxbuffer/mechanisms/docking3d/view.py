"""What is told of a docking in space and drawn of it."""

import dataclasses
from types import MappingProxyType
from typing import Any

import numpy as np

from ..picture import Panel, PanelCurve
from ..probe_cone.panels import panels as docking_panels
from ..probe_cone.view import VIEW as PLANAR
from ..view import Names
from .assembly import CONTACTS
from .capture import Capture3D
from .design import Design3D
from .drawing import TIP_FORCE, drawing
from .label import scenario_label


def names(design: Design3D) -> Names:
    """Return what the parts of a design are called."""
    return Names(
        bodies=("active", "cylinder", "probe", "passive"),
        contacts=CONTACTS,
        # Multipliers are named by their places, in the order of the joints' rows.
        multipliers={
            **{f"hinge {axis}": "N" for axis in "xyz"},
            "hinge roll": "N m",
            **{f"prismatic moment {k}": "N m" for k in (1, 2, 3)},
            **{f"prismatic force {k}": "N" for k in (1, 2)},
        },
        others={
            "tip_spin": "rad/s",
            **dict.fromkeys(TIP_FORCE, "N"),
            "hinge_force": "N",
            "buffer_force": "N",
            "stop_force": "N",
            "stroke": "m",
            "hinge_angle": "rad",
            "hinge_alpha": "rad",
            "hinge_beta": "rad",
            "tip_y": "m",
            "tip_z": "m",
            "throat_distance": "m",
            "relative_energy": "J",
            "latch_force": "N",
            "latch_closed": "-",
            "passive_force": "N",
            "control_moment": "N m",
            **dict.fromkeys(design.shock.frequencies, "m/s²"),
        },
        shares={"relative_energy": "energy_left"},
    )


ANGLES = MappingProxyType({"√(α² + β²)": "hinge_angle", "α, about y": "hinge_alpha", "β, about z": "hinge_beta"})


def panels(capture: Capture3D) -> list[Panel]:
    """Return the panels of every docking with a history, and how the hinge's angles go in their plane."""
    others: Any = capture.history.others  # type: ignore[union-attr]
    alpha, beta = (np.degrees(np.asarray(others[name])) for name in ("hinge_alpha", "hinge_beta"))
    way = PanelCurve("", beta, along=alpha)
    plane = Panel("Hinge angles in their plane", "β, about z [°]", (way,), path="α, about y [°]")
    return [*docking_panels(capture, ANGLES), plane]


VIEW = dataclasses.replace(
    PLANAR,
    title="Capture in space",
    contact="cone",
    names=names,
    label=scenario_label,
    approach=lambda scenario: f"approach at {scenario_label(scenario)}",
    panels=panels,
    drawing=drawing,
    limitations=(
        "Vehicles are axisymmetric, the cone is one of revolution, the rod does not bend, and the hinge has no play.",
        "The forces have not been compared with a test of hardware: docs/verification.md.",
    ),
)
