"""A docking as a Functional Mock-up Unit (FMI 3.0, co-simulation), which pythonfmu3 packs."""

import json
import tempfile
from importlib.util import find_spec
from pathlib import Path

from .._types import Scalar
from ..errors import InputError
from ..fields import Part
from ..files import user_path, write
from ..mechanisms.registry import mechanism_of
from ..run.plant import AXES, stepper
from ..run.request import DEFAULT_TOLERANCE
from ..study.designs import save_design
from .fmu_unit import DESIGN, SETTINGS

NEEDED = "pythonfmu3"
UNIT = '''"""A run of {kind} as a co-simulation unit, written by jaxbuffer; the tool's Python needs jaxbuffer."""

from pythonfmu3 import Fmi3Slave

from jaxbuffer.output.fmu_unit import PlantUnit


class {name}(PlantUnit, Fmi3Slave):
    """See PlantUnit."""
'''


def export_fmu(
    design: Part,
    scenario: Part | None,
    file: str | Path,
    *,
    axes: str = AXES[0],
    rtol: Scalar = DEFAULT_TOLERANCE,
    overwrite: bool = False,
) -> None:
    """Write a run as a Functional Mock-up Unit (FMI 3.0, co-simulation) of a `Plant`.

    Inputs are force and moment on each vehicle, held over a step; outputs pose and rates of every body, forces,
    largest values, touchdowns and outcome. The unit holds the design, not the program: the Python of the tool that
    runs it needs jaxbuffer.

    **Arguments:**

    - ``design``, ``scenario``: as of `stepper`.
    - ``file``: ends in .fmu; its name is the model's, letters, digits and underscores.
    - ``axes``, ``rtol``: as of `stepper`.
    - ``overwrite``: whether to replace a file that is there.

    **Raises:** `InputError` for a file of another name or one that is there, for what cannot be stepped, and where
    pythonfmu3 is missing.

    **Example:**

    >>> import tempfile, pathlib
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder) / "docking.fmu"
    ...     jb.export_fmu(jb.table2(), jb.Scenario(), file)
    ...     file.exists()
    True
    """
    target = user_path(file)
    if target.suffix != ".fmu" or not target.stem.isidentifier():
        raise InputError(f"{file}: give a name of letters, digits and underscores that ends in .fmu, docking.fmu say")
    if find_spec(NEEDED) is None:
        raise InputError(f"an FMU needs {NEEDED}, not installed here: pip install 'jaxbuffer[fmu]'")
    if target.exists() and not overwrite:
        raise InputError(f"{file} exists; overwrite=True replaces it")
    mechanism = mechanism_of(design)
    scenario = mechanism.scenario() if scenario is None else scenario
    stepper(design, scenario, axes=axes, rtol=rtol)  # says what is wrong before anything is written
    from pythonfmu3 import FmuBuilder  # an optional package

    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        script, settings = place / "unit" / f"{target.stem}.py", place / SETTINGS
        script.parent.mkdir()
        script.write_text(UNIT.format(kind=mechanism.name, name=target.stem))
        save_design(place / DESIGN, design, [scenario])
        settings.write_text(json.dumps({"axes": axes, "rtol": float(rtol)}))
        made = FmuBuilder.build_FMU(
            script, dest=place, project_files=[place / DESIGN, settings], canGetAndSetFMUState=True
        )
        write(target, made.read_bytes(), overwrite)
