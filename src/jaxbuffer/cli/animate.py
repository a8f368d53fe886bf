"""`jaxbuffer animate`: a run of the mechanism as an animation."""

import dataclasses
from typing import Annotated

import typer

from ..errors import InputError
from .exits import OK, fail
from .request import CommandLine, ScenarioNumber
from .simulate import simulated

Format = Annotated[
    str | None, typer.Option("--format", metavar="gif|mp4", help="gif (default), or mp4 where ffmpeg is.")
]


def animate(request: CommandLine, scenario_number: ScenarioNumber = None, kind: Format = None) -> int:
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
    study = request.one_scenario(scenario_number)
    if request.output is None:
        raise InputError("animate needs --output DIR, the folder for its file, or the file")
    from ..output.animation import FORMATS, animation, check_format, frames_of
    from .progress import sweeping

    ending = request.output.suffix.removeprefix(".").lower()
    if ending in FORMATS and not request.output.is_dir():
        if kind not in (None, ending):
            raise InputError(f"--format {kind} and --output {request.output} contradict; keep one")
        kind, name = ending, request.output.name
        request = dataclasses.replace(request, output=request.output.parent)
    else:
        kind = kind or FORMATS[0]
        name = f"motion.{kind}"
    check_format(kind)
    files = request.files(name)
    run, _ = simulated(study, history=True, again=False)
    if run.outcome.failed:
        return fail(run.outcome.reason)
    count = len(frames_of(run).times)
    film = sweeping(count, lambda report: animation(run, kind, report), "drawing", "frames")
    files.save_and_show(lambda: {name: lambda: film}, run)
    return OK
