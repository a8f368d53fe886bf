"""The commands that write a study for other programs, as their help shows them."""

from typing import Annotated

import typer

from . import completion
from .options import ScenarioNumber


def export_fmu(
    scenario_number: ScenarioNumber = None,
    axes: Annotated[
        str,
        typer.Option(
            metavar="AXES",
            help="Along which forces and moments act: inertial (default), or body.",
            show_default=False,
            autocompletion=completion.one_of("inertial", "body"),
        ),
    ] = "inertial",
) -> None:
    """Write a run as a Functional Mock-up Unit (FMI 3.0, co-simulation), to put guidance and control in its loop.

    Inputs: force and moment on each vehicle, held over a step. Outputs: pose and rates of each body, forces, largest
    values, touchdowns, and the outcome, -1 while the run goes on. The tool that runs the unit needs a Python with
    jaxbuffer; packing it needs pythonfmu3: pip install 'jaxbuffer[fmu]'. DIR is the file to write.

    \b
    Example: jaxbuffer export-fmu study.toml --output docking.fmu
    """


def export_mjcf(scenario_number: ScenarioNumber = None) -> None:
    """Write the bodies, joints and linear springs of a mechanism as MuJoCo's MJCF, to check it elsewhere.

    The start is the key frame "start". MuJoCo's contacts are of another law, so that contacts, and all else that it
    cannot have, stand in words in a comment. Tables of bodies and joints, as URDF has them, lie beside the file.
    DIR is the file to write.

    \b
    Files: docking.xml, docking.bodies.csv, docking.joints.csv
    Example: jaxbuffer export-mjcf study.toml --output docking.xml
    """
