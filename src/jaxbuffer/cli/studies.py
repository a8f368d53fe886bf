"""The commands of studies, folders of results and papers, as their help shows them."""

from pathlib import Path
from typing import Annotated

import typer

from . import completion
from .options import Figures, Force

Kind = Annotated[
    str,
    typer.Option(
        "--kind",
        metavar="NAME",
        help="The mechanism; 'jaxbuffer fields' lists them.",
        autocompletion=completion.kinds,
    ),
]
Folders = Annotated[list[Path], typer.Argument(metavar="DIR…", help="Folders that --output named.")]
Html = Annotated[
    Path | None, typer.Option("--html", metavar="FILE", help="Where the page goes; default: in the first DIR.")
]


def init(
    file: Annotated[
        Path | None, typer.Argument(metavar="[FILE]", help="What to write; default: study.toml, or NAME.py.")
    ] = None,
    kind: Kind = "",
    own: Annotated[
        str, typer.Option("--own", metavar="NAME", help="Write a mechanism of your own to begin with, a Python file.")
    ] = "",
    active_mass: Annotated[
        str, typer.Option("--active-mass", metavar="MASS", help='Of your vehicle with the probe: "1200 kg".')
    ] = "",
    passive_mass: Annotated[
        str, typer.Option("--passive-mass", metavar="MASS", help='Of the one with the cone: "3.5 t".')
    ] = "",
    speeds: Annotated[
        str, typer.Option("--speeds", metavar="SLOW:FAST", help="Approaches of your vehicles: 0.05:0.15 [m/s].")
    ] = "",
    miss: Annotated[
        str, typer.Option("--miss", metavar="LENGTH", help='Largest distance of the tip from the axis: "40 mm".')
    ] = "",
    attitude: Annotated[
        str, typer.Option("--attitude", metavar="ANGLE", help='Largest angle from the axis: "2 deg".')
    ] = "",
    force: Annotated[bool, typer.Option("--force", help="Overwrite FILE if it exists.")] = False,
) -> None:
    """Write an example study of a mechanism: every field with its unit, range, default and meaning.

    It loads as it is; take away the # before what you want to change. Without --kind it is of the capture mechanism.
    From masses, speeds, miss and attitude of your own vehicles it makes a study of their docking until held instead,
    in space with --kind docking3d, each number with the rule that made it: it simulates and tunes as it is.
    With --own it is a Python file: a mechanism with a buffer, an end stop and a thrust, to be changed into yours
    (docs/elements.md).

    \b
    Examples:
      jaxbuffer init --kind bar_drop drop.toml
      jaxbuffer init --active-mass "1200 kg" --passive-mass "3.5 t" --speeds 0.05:0.15 --miss "40 mm" --attitude "2 deg"
      jaxbuffer init --own gripper
    """


def check(file: Annotated[Path, typer.Argument(metavar="FILE", help="The study.")]) -> None:
    """Say whether a study can be used, what differs from the defaults, and what each command would do with it.

    What is wrong is one line, with the nearest name for one that is unknown, and exit code 2.

    \b
    Example: jaxbuffer check study.toml
    """


def schema(kind: Kind = "") -> None:
    """Print the JSON Schema of a mechanism's studies, with which editors complete and check them (docs/studies.md).

    \b
    Example: jaxbuffer schema --kind bar_drop > jaxbuffer.schema.json
    """


def fields(
    kind: Annotated[
        str,
        typer.Argument(
            metavar="KIND", help="A mechanism's name, as kind in CONFIG.toml.", autocompletion=completion.kinds
        ),
    ] = "",
) -> None:
    """List a mechanism's fields with units, defaults and ranges, and the quantities of its runs; without KIND, the
    mechanisms there are.

    \b
    Example: jaxbuffer fields
    """


def report(
    folders: Folders,
    html: Html = None,
    title: Annotated[str, typer.Option(metavar="TEXT", help="The page's title.")] = "",
    what_if: Annotated[
        bool, typer.Option("--what-if", help="Simulate around the tuned design, for sliders on the page.")
    ] = False,
    runs: Annotated[
        str | None, typer.Option(metavar="N", help="Of --what-if, for each scenario and range; default 128.")
    ] = None,
) -> None:
    """Make a page for a design review of the results in DIR, and print its abstract.

    The page, report.html, is one file that needs no network: the design, limits, scenarios, forces over time, why a
    run did not succeed, elasticities, the search, the envelope, samples, fronts, and where the numbers come from.
    Several folders make one page: of a tuning, of a run of the tuned design, of its sensitivities, of a sweep.

    With --what-if it makes up to 4.5 N runs of each scenario around the tuned design first, and keeps in what_if.json
    of its folder what the page's sliders show.

    \b
    Examples:
      jaxbuffer report results/table2
      jaxbuffer report results/table2 --what-if
      jaxbuffer report results/tuned results/run results/sensitivity results/sweep --title "Probe B, review 2"
    """


def compare(folders: Folders, html: Html = None) -> None:
    """Put the designs of several folders side by side: where they differ, what they reach, which limits they keep,
    their forces over time.

    \b
    Example: jaxbuffer compare results/before results/after
    """


def reproduce(
    output: Annotated[Path, typer.Option("--output", metavar="DIR", help="Folder for figures and tables.")],
    paper: Annotated[
        str,
        typer.Argument(
            metavar="[PAPER]",
            help="docking, impact, load or tank.",
            autocompletion=completion.one_of("docking", "impact", "load", "tank"),
        ),
    ] = "docking",
    published: Annotated[
        bool, typer.Option("--published", help="The paper's own equations and other readings as well (docking).")
    ] = False,
    force: Force = False,
    figures: Figures = None,
) -> None:
    """Run a paper's studies, and print claim by claim whether the model bears its text out.

    \b
    docking  the buffer: rigid against buffered probe, approach speed, angular velocity, misalignment, friction,
             welded against free tip; with --published all of it again with the damper of its equation 10 and the
             arms of its equation 21, and over a hundred other readings of what it leaves open
    impact   a bar dropped on a plate: damping, plate and bar that bend, coarse steps;
             a slider-crank with play in a pin: exponent, stiffness, a rod that bends
    load     the kinetic energy before an impact against its largest force, over random designs of three mechanisms
    tank     a slider falls on a full fuel tank: fill, height, penalty, multiplier and defence node

    \b
    Files in DIR:
      claims.md     every claim and every study's numbers
      studies.csv, studies.json  the same for machines
      readings.csv    with --published: one line a reading
      NAME.png  a figure a study

    \b
    Example: jaxbuffer reproduce impact --output results/impact
    """
