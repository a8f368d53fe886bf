"""jaxbuffer: which spring, damper and tip mass behind a docking probe give the smallest impact force.

Public names are imported when they are first asked for (PEP 562): `import jaxbuffer` takes no time, and a command pays
for what it uses.

**Example:** what the examples of all public names begin with.

>>> import jaxbuffer as jb
>>> jb.configure()
"""

import importlib
from typing import TYPE_CHECKING, Any

from .mechanisms import FOLDERS

if TYPE_CHECKING:
    from .compiling.process import configure as configure
    from .contact import register_law as register_law
    from .errors import InputError as InputError
    from .experiments.indices import Indices as Indices
    from .experiments.indices import sobol_indices as sobol_indices
    from .experiments.rectangle import SafeRectangle as SafeRectangle
    from .experiments.rectangle import safe_rectangle as safe_rectangle
    from .experiments.sample import Sample as Sample
    from .experiments.sample import sample as sample
    from .experiments.surface import Surface as Surface
    from .experiments.surface import response_surface as response_surface
    from .fields import get as get
    from .fields import paths as paths
    from .fields import replace as replace
    from .hybrid.rungekutta.diffrax_solver import Diffrax as Diffrax
    from .mechanisms.probe_cone import (
        Capture as Capture,
    )
    from .mechanisms.probe_cone import (
        Design as Design,
    )
    from .mechanisms.probe_cone import (
        FirstImpact as FirstImpact,
    )
    from .mechanisms.probe_cone import (
        Outcome as Outcome,
    )
    from .mechanisms.probe_cone import (
        Scenario as Scenario,
    )
    from .mechanisms.probe_cone import (
        first_impact as first_impact,
    )
    from .mechanisms.probe_cone import (
        rigid_probe as rigid_probe,
    )
    from .mechanisms.probe_cone import (
        table2 as table2,
    )
    from .mechanisms.run import Run as Run
    from .output.animation import animate as animate
    from .output.folder import Results as Results
    from .output.folder import load as load
    from .output.motion import draw as draw
    from .run.instants import at_times as at_times
    from .run.simulate import simulate as simulate
    from .run.trust import Trust as Trust
    from .run.trust import trust as trust
    from .run.with_diffrax import as_diffrax as as_diffrax
    from .sensitivities.certificate import Certificate as Certificate
    from .sensitivities.certificate import Verdict as Verdict
    from .sensitivities.sensitivity import Sensitivity as Sensitivity
    from .sensitivities.sensitivity import sensitivity as sensitivity
    from .study.designs import load_design as load_design
    from .study.designs import save_design as save_design
    from .sweeps.result import Sweep as Sweep
    from .sweeps.stored import StoredSweep as StoredSweep
    from .sweeps.sweep import sweep as sweep
    from .tuning.cases import Case as Case
    from .tuning.derived import Derived as Derived
    from .tuning.objective import Limits as Limits
    from .tuning.objective import Objective as Objective
    from .tuning.objective import Then as Then
    from .tuning.pareto import Front as Front
    from .tuning.pareto import pareto as pareto
    from .tuning.problem import Problem as Problem
    from .tuning.problem import Variable as Variable
    from .tuning.tune import tune as tune
    from .tuning.tuned import Tuned as Tuned

    __version__: str

_HOME: dict[str, tuple[str, ...]] = {
    "compiling.process": ("configure",),
    "contact": ("register_law",),
    "errors": ("InputError",),
    "experiments.indices": ("Indices", "sobol_indices"),
    "experiments.rectangle": ("SafeRectangle", "safe_rectangle"),
    "experiments.sample": ("Sample", "sample"),
    "experiments.surface": ("Surface", "response_surface"),
    "fields": ("get", "paths", "replace"),
    "hybrid.rungekutta.diffrax_solver": ("Diffrax",),
    "mechanisms.run": ("Run",),
    "output.animation": ("animate",),
    "output.motion": ("draw",),
    "run.with_diffrax": ("as_diffrax",),
    "run.instants": ("at_times",),
    "run.simulate": ("simulate",),
    "run.trust": ("Trust", "trust"),
    "sensitivities.certificate": ("Certificate", "Verdict"),
    "sensitivities.horizon": ("horizon",),
    "sensitivities.sensitivity": ("Sensitivity", "sensitivity"),
    "output.folder": ("Results", "load"),
    "study.designs": ("load_design", "save_design"),
    "sweeps.result": ("Sweep",),
    "sweeps.stored": ("StoredSweep",),
    "sweeps.sweep": ("sweep",),
    "tuning.cases": ("Case",),
    "tuning.derived": ("Derived",),
    "tuning.objective": ("Limits", "Objective", "Then"),
    "tuning.pareto": ("Front", "pareto"),
    "tuning.problem": ("Problem", "Variable"),
    "tuning.tune": ("tune",),
    "tuning.tuned": ("Tuned",),
    **{f"mechanisms.{folder}": names for folder, names in FOLDERS.items()},
}
_MODULE = {name: module for module, names in _HOME.items() for name in names}

__all__ = sorted(_MODULE)  # noqa: PLE0605 # the mechanisms' own names are listed in their registry


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
