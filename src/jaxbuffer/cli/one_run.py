"""The commands of one run: simulate, sensitivity, animate and laws, as their help shows them."""

from typing import Annotated

import typer

from . import completion
from .options import Levers, ScenarioNumber, Scheduler, Trust


def simulate(scenario_number: ScenarioNumber = None, trust: Trust = "on", levers: Levers = "off") -> None:
    """Simulate one run (of the default mechanism: a capture) and print its peak forces, motion and energies.

    Of a capture that did not succeed it says what held it back: way and energy left, where the rest went, and the
    impact that turned it round. A second run at a tenth of the tolerance tells how far its numbers can be trusted, and
    where little decides what happens, a bounce more or less say (--trust off spares it). Which parameter to change
    first takes derivatives: jaxbuffer sensitivity does that.

    The limits of [problem.constraints] stand first, each with its value, bound and room; --levers on adds the three
    numbers of the design that move each of them most, variables or not.

    Another mechanism is chosen by kind = "NAME" in CONFIG.toml; `jaxbuffer fields` lists them with their fields.

    \b
    Files in DIR, of a capture:
      capture.json  every number with its unit, and every impact
      history.csv   forces, gaps, motion and energies at each step
      capture.png  contact force, gap, stroke, hinge angle, energies over time
      motion.png   the mechanism at a few telling times, contact forces as arrows
      motion.json, force.json  the same and the force over time, for the page of jaxbuffer report
      fields.png  stress, strain and pressure on the mesh, of a mechanism that has one; with meshio installed
                    fields.vtu, fields_end.vtu too
      capture.txt   the summary
      capture.nc    all of it as labelled arrays (netCDF), for xarray or jb.load
      capture.mat   the same for MATLAB

    \b
    Example: jaxbuffer simulate --buffer.k_A 800 --output results
    """


def sensitivity(
    wrt: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FIELD",
            help="Differentiate by FIELD; repeatable; default: the buffer's.",
            autocompletion=completion.numbers,
        ),
    ] = None,
    of: Annotated[
        list[str] | None,
        typer.Option(
            metavar="QUANTITY",
            help="Differentiate QUANTITY; repeatable; default: the first five below.",
            autocompletion=completion.quantities("differentiable"),
        ),
    ] = None,
    certify: Annotated[
        str,
        typer.Option(
            metavar="HOW",
            help="quick (default), thorough (a difference a parameter) or none.",
            autocompletion=completion.one_of("quick", "thorough", "none"),
        ),
    ] = "quick",
    scenario_number: ScenarioNumber = None,
    scheduler: Scheduler = None,
) -> None:
    """Differentiate one run: gradients and elasticities of peak forces, stroke, hinge angle and end time, or of any
    quantity below.

    They come with a certificate: estimated errors from a second tolerance and from differences of tight simulations,
    the active peak and its runner-up, and a verdict: trusted, check or refused. Of a capture that did not succeed,
    --of capture_share says by how much each parameter would have to change, to first order. --scheduler hands these
    simulations to a Dask cluster, which is worth it where one takes seconds.

    \b
    Files in DIR:
      sensitivity.json, sensitivity.csv  values, gradients, elasticities, units
      sensitivity.txt                    the tables
      sensitivity.png                    elasticities as bars with their errors

    \b
    Examples:
      jaxbuffer sensitivity study.toml --wrt buffer.k_A --wrt probe.tip_mass
      jaxbuffer sensitivity --of peak_force --of impact.1.peak_force --of capture_margin --certify thorough
    """


def animate(
    scenario_number: ScenarioNumber = None,
    kind: Annotated[
        str | None, typer.Option("--format", metavar="gif|mp4", help="gif (default), or mp4 where ffmpeg is.")
    ] = None,
) -> None:
    """Simulate one run and draw it moving, in scale, with its contact forces as arrows.

    Time runs evenly, and slower around the three largest impacts; a clock says the time and how much slower.

    \b
    Files in DIR:
      motion.gif or motion.mp4
    A DIR that ends in .gif or .mp4 is the file itself.

    \b
    Examples:
      jaxbuffer animate --scenario.misalignment 0.05 --output results
      jaxbuffer animate --output results/docking.gif
    """


def laws(
    mass: Annotated[
        str | None, typer.Option(metavar="KG", help="Effective mass [kg]; default: of the first contact.")
    ] = None,
    speed: Annotated[
        str | None, typer.Option(metavar="M/S", help="Speed [m/s]; default: of the first contact.")
    ] = None,
) -> None:
    """Compare the contact laws: the restitution each delivers, not what it is asked for, and one impact of two bodies.

    Choose a law for a capture with contact.law, here or in CONFIG.toml.

    \b
    Files in DIR:
      laws.csv  the table: sources, restitutions, penetration, force, duration
      laws.png  force over penetration and over time, delivered over asked restitution

    \b
    Example: jaxbuffer laws --contact.restitution 0.5 --output results/laws
    """
