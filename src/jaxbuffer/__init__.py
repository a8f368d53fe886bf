"""jaxbuffer: which spring, damper and tip mass behind a docking probe give the smallest impact force.

Public names are imported when they are first asked for (PEP 562): `import jaxbuffer` takes no time, and a command pays
for what it uses.
"""

import importlib
import sys
import types
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .capture import Capture, simulate
    from .certificate import Certificate, Verdict
    from .contact import register_law
    from .errors import InputError
    from .first_impact import FirstImpact, first_impact
    from .mechanisms import Design, Scenario, get, paths, replace, rigid_probe, table2
    from .outcome import Outcome
    from .runtime import configure
    from .sensitivity import Sensitivity, sensitivity
    from .sweep import Sweep, sweep
    from .tuning import Case, Limits, Objective, Problem, Then, Tuned, Variable, tune

    __version__: str

__all__ = [
    "Capture",
    "Case",
    "Certificate",
    "Design",
    "FirstImpact",
    "InputError",
    "Limits",
    "Objective",
    "Outcome",
    "Problem",
    "Scenario",
    "Sensitivity",
    "Sweep",
    "Then",
    "Tuned",
    "Variable",
    "Verdict",
    "configure",
    "first_impact",
    "get",
    "paths",
    "register_law",
    "replace",
    "rigid_probe",
    "sensitivity",
    "simulate",
    "sweep",
    "table2",
    "tune",
]

_HOME = {
    "capture": ("Capture", "simulate"),
    "certificate": ("Certificate", "Verdict"),
    "contact": ("register_law",),
    "errors": ("InputError",),
    "first_impact": ("FirstImpact", "first_impact"),
    "mechanisms": ("Design", "Scenario", "get", "paths", "replace", "rigid_probe", "table2"),
    "outcome": ("Outcome",),
    "runtime": ("configure",),
    "sensitivity": ("Sensitivity", "sensitivity"),
    "sweep": ("Sweep", "sweep"),
    "tuning": ("Case", "Limits", "Objective", "Problem", "Then", "Tuned", "Variable", "tune"),
}
_MODULE = {name: module for module, names in _HOME.items() for name in names}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from .version import version

        value = version()
    elif name in _MODULE:
        value = getattr(importlib.import_module(f".{_MODULE[name]}", __name__), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__doc__", "__file__", "__name__", "__path__", "__version__"]


class _Package(types.ModuleType):
    """A package whose functions are not hidden by the modules of the same names: `sensitivity`, `sweep` and others."""

    def __setattr__(self, name: str, value: Any) -> None:
        # Python binds a submodule to its package once it is imported, by whomever
        if not (name in _MODULE and isinstance(value, types.ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
