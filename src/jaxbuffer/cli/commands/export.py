"""`jaxbuffer export-fmu`: a study as a file for other programs."""

from ...errors import InputError
from ...output.fmu import export_fmu as write_fmu
from ..exits import OK
from ..streams import show
from .request import CommandLine


def export_fmu(request: CommandLine, scenario_number: str | None, axes: str) -> int:
    """Write a Functional Mock-up Unit."""
    if (output := request.output) is None:
        raise InputError("export-fmu needs --output FILE, docking.fmu say")
    study = request.one_scenario(scenario_number)
    if output.exists() and not request.force:
        raise InputError(f"{output} exists; --force overwrites, another FILE keeps it")
    write_fmu(study.design, study.scenario, output, axes=axes, rtol=study.options.rtol, overwrite=request.force)
    show(f"wrote {output}")
    return OK
