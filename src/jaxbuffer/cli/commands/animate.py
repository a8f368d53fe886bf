"""`jaxbuffer animate`: one run, drawn moving."""

import dataclasses

from ...errors import InputError, check_choice
from ...output.animation import FORMATS, animation, check_format, frames_of
from ..exits import OK, fail
from .progress import sweeping
from .request import CommandLine
from .simulate import simulated

# endings that name a film, a picture or a page, which is not made here
OTHER_FILMS = frozenset(
    "apng avi flv htm html jpeg jpg m4v mkv mov mpeg mpg ogv pdf png svg webm webp wmv".split()  # noqa: SIM905
)


def animate(request: CommandLine, scenario_number: str | None, kind: str | None) -> int:
    """Simulate a run and draw it moving."""
    study = request.one_scenario(scenario_number)
    if request.output is None:
        raise InputError("animate needs --output DIR, the folder for its file, or the file")
    ending = request.output.suffix.removeprefix(".").lower()
    # A folder may be called like a film, and is then the folder for it.
    if ending in OTHER_FILMS and not request.output.is_dir():
        check_choice("format", ending, FORMATS)
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
