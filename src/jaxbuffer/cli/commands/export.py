"""`jaxbuffer export-fmu` and `export-mjcf`: a study as a file for other programs."""

from pathlib import Path

from ...errors import InputError
from ...output.fmu import export_fmu as write_fmu
from ...output.mjcf import export_mjcf as write_mjcf
from ..exits import OK
from ..streams import show
from .request import CommandLine


def export_fmu(request: CommandLine, scenario_number: str | None, axes: str) -> int:
    """Write a Functional Mock-up Unit."""
    output, study = _target(request, "export-fmu", "docking.fmu"), request.one_scenario(scenario_number)
    write_fmu(study.design, study.scenario, output, axes=axes, rtol=study.options.rtol, overwrite=request.force)
    show(f"wrote {output}")
    return OK


def export_mjcf(request: CommandLine, scenario_number: str | None) -> int:
    """Write MJCF, and tables of bodies and joints."""
    output, study = _target(request, "export-mjcf", "docking.xml"), request.one_scenario(scenario_number)
    write_mjcf(study.design, study.scenario, output, overwrite=request.force)
    show(f"wrote {output}")
    return OK


def _target(request: CommandLine, command: str, example: str) -> Path:
    """Return the file to write. **Raises:** `InputError` where none is named, or it is there."""
    if (output := request.output) is None:
        raise InputError(f"{command} needs --output FILE, {example} say")
    if output.exists() and not request.force:
        raise InputError(f"{output} exists; --force overwrites, another FILE keeps it")
    return output
