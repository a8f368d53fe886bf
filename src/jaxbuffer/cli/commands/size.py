"""`jaxbuffer size`: parts that fit the study's scenarios."""

from typing import Any

from ...errors import InputError
from ...fields import declared
from ...mechanisms.mechanism import Mechanism
from ...output.size_files import size_files
from ...run.sized import size as compute
from ...study.config import Config
from ..exits import LIMITS_BROKEN, OK, fail
from .progress import fitting
from .request import CommandLine, given, say_cautions
from .study import number_or_text


def size(
    request: CommandLine,
    settling_time: str | None,
    latch_energy_share: str | None,
    peak_latch_force: str | None,
    stroke: str | None,
    overspeed: str | None,
) -> int:
    """Size the study's parts, simulate them, and save the study with them."""
    study = request.study()
    typed = given(
        settling_time=settling_time,
        latch_energy_share=latch_energy_share,
        peak_latch_force=peak_latch_force,
        stroke=stroke,
        overspeed=overspeed,
    )
    wishes = {**_of_limits(study), **{name: number_or_text(it) for name, it in typed.items()}}
    files = request.files("design.toml", "size.json", "size.txt", "size.png")
    if built := dict.fromkeys(path for case in study.cases for path, _ in case.values):
        raise InputError(f"[problem.grid] lists values of {', '.join(built)}: one design is sized; leave them out")
    scenarios = [case.scenario for case in study.cases]
    sized = fitting(
        lambda report: compute(
            study.design,
            scenarios,
            None if study.usual_duration else study.options.duration,
            solver=study.options.stepper(),
            rtol=study.options.rtol,
            report=report,
            **wishes,
        ),
        "sizing",
    )
    say_cautions([(sized.design, scenario) for scenario in scenarios])
    contents = size_files(sized, study, request.made(study))
    files.save_record(contents, sized, "size.json")
    return fail(f"not as wished: {'; '.join(sized.missed)}", LIMITS_BROKEN) if sized.missed else OK


def _of_limits(study: Config) -> dict[str, Any]:
    """Return the wishes that the study's limits say."""
    mechanism: Mechanism = study.mechanism
    if mechanism.sizer is None or study.table.constraints is None:
        return {}
    wishes = declared(mechanism.sizer.wishes)
    return {name: bound for name, bound in study.table.constraints.at_most.items() if name in wishes}
