"""The public names, each once: Python imports one when it is first asked for, a type checker reads them here."""

from .programs.memory import clear_caches as clear_caches
from .programs.process import configure as configure
from .choosing.buildable import buildable as buildable
from .choosing.choice import Choice as Choice
from .choosing.choose import choose as choose
from .contact import register_law as register_law
from .errors import InputError as InputError
from .experiments.indices import (
    Indices as Indices,
    sobol_indices as sobol_indices,
)
from .experiments.rectangle import (
    SafeRectangle as SafeRectangle,
    safe_rectangle as safe_rectangle,
)
from .experiments.sample import (
    Sample as Sample,
    sample as sample,
)
from .experiments.surface import (
    Surface as Surface,
    response_surface as response_surface,
)
from .experiments.what_if import (
    WhatIf as WhatIf,
    what_if as what_if,
)
from .fields import (
    get as get,
    paths as paths,
    replace as replace,
)
from .fitting.fit import fit as fit
from .fitting.fitted import Fitted as Fitted
from .fitting.quantities import recorded_quantities as recorded_quantities
from .fitting.reading import read_recording as read_recording
from .fitting.recording import (
    Channel as Channel,
    Recording as Recording,
)
from .hybrid.rungekutta.diffrax_solver import Diffrax as Diffrax
from .mechanisms.bar_drop import (
    BarDrop as BarDrop,
    BarDropScenario as BarDropScenario,
)
from .mechanisms.docking3d import (
    Capture3D as Capture3D,
    Design3D as Design3D,
    Scenario3D as Scenario3D,
    docking3d as docking3d,
)
from .mechanisms.probe_cone import (
    Capture as Capture,
    Design as Design,
    FirstImpact as FirstImpact,
    Outcome as Outcome,
    Scenario as Scenario,
    bending_frequencies as bending_frequencies,
    first_impact as first_impact,
    rigid_probe as rigid_probe,
    size_buffer as size_buffer,
    size_latch as size_latch,
    table2 as table2,
    with_bending as with_bending,
)
from .mechanisms.run import Run as Run
from .mechanisms.sizing import SizedParts as SizedParts
from .mechanisms.slider_crank import (
    SliderCrank as SliderCrank,
    SliderCrankScenario as SliderCrankScenario,
    journal_path as journal_path,
    published_slider_crank as published_slider_crank,
    turn_statistics as turn_statistics,
)
from .mechanisms.tank_drop import (
    TankDrop as TankDrop,
    TankDropScenario as TankDropScenario,
)
from .output.animation import animate as animate
from .output.fmu import export_fmu as export_fmu
from .output.folder import (
    Results as Results,
    load as load,
)
from .output.mjcf import (
    export_mjcf as export_mjcf,
    mjcf as mjcf,
)
from .output.motion import draw as draw
from .output.results import save as save
from .pages.review import report as report
from .run.instants import at_times as at_times
from .run.plant import (
    Loads as Loads,
    Observed as Observed,
    Plant as Plant,
    stepper as stepper,
)
from .run.simulate import simulate as simulate
from .run.sized import (
    Sized as Sized,
    size as size,
)
from .run.trust import (
    Trust as Trust,
    trust as trust,
)
from .run.with_diffrax import as_diffrax as as_diffrax
from .sensitivities.certificate import (
    Certificate as Certificate,
    Verdict as Verdict,
)
from .sensitivities.horizon import horizon as horizon
from .sensitivities.result import Sensitivity as Sensitivity
from .sensitivities.sensitivity import sensitivity as sensitivity
from .study.designs import (
    load_design as load_design,
    save_design as save_design,
)
from .sweeps.result import Sweep as Sweep
from .sweeps.sweep import sweep as sweep
from .tuning.problem.cases import Case as Case
from .tuning.problem.custom_quantity import CustomQuantity as CustomQuantity
from .tuning.report.front import Front as Front
from .tuning.problem.objective import (
    Limits as Limits,
    Objective as Objective,
    SecondObjective as SecondObjective,
)
from .tuning.pareto import pareto as pareto
from .tuning.problem.problem import Problem as Problem
from .tuning.problem.tolerances import Tolerance as Tolerance
from .tuning.tune import tune as tune
from .tuning.report.tuned import Tuned as Tuned
from .tuning.problem.variable import Variable as Variable

__version__: str
