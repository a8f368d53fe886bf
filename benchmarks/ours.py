"""The product's side: what a user calls, timed with everything that call does. Import this before any JAX computation.

The reference's names of inputs are translated here and nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial

import numpy as np

import jaxbuffer as jb

jb.configure()

import jax  # noqa: E402

from jaxbuffer.hybrid import DiagonallyImplicit, ExplicitRungeKutta, Solver  # noqa: E402
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE  # noqa: E402
from jaxbuffer.sensitivities.gradients import gradients  # noqa: E402
from jaxbuffer.sweeps.sweep import CHUNK as CHUNK  # noqa: E402 # captures of one compiled program

from .accuracy import RTOLS as RTOLS  # noqa: E402
from .accuracy import Numbers, Result, Setting, errors, measured  # noqa: E402

NAME = "jaxbuffer"
PARAMETERS = PROBE_CONE.defaults.parameters
SOLVERS: Mapping[str, Solver | None] = {
    "default": None,
    "implicit": DiagonallyImplicit(),
    "explicit": ExplicitRungeKutta(),
}


def result(capture: jb.Capture | jb.Sweep, place: int | tuple[()] = ()) -> Result:
    """The numbers of a capture, or of number ``place`` of a sweep."""
    return Result(
        outcome=jb.Outcome(int(np.asarray(capture.code)[place])).name,
        impacts=int(np.asarray(capture.impact_count)[place]),
        peak_force=float(np.asarray(capture.peak_force)[place]),
        end_time=float(np.asarray(capture.end_time)[place]),
    )


def simulated(solver: str, rtol: float, design: jb.Design, scenario: jb.Scenario | None = None) -> Result:
    """One capture, as a user calls it, from Python numbers to Python numbers."""
    return result(jb.simulate(design, scenario, rtol=rtol, solver=SOLVERS[solver]))


def curve(
    solver: str, design: jb.Design, exact: Numbers, repeats: int, rtols: Sequence[float] = RTOLS
) -> Iterator[Setting]:
    """Work-precision curve of ``solver`` for one design in Table 2's scenario; what compiles is not timed."""
    simulated(solver, rtols[-1], design)
    for rtol in rtols:
        run = partial(simulated, solver, rtol, design)
        yield measured(f"{NAME}, {solver}", f"rtol {rtol:.0e}", run, partial(errors, exact=exact), repeats)


def elasticities(rtol: float) -> dict[str, float]:
    """Table 2's d ln peak_force / d ln p [-] by the reference's names, with the capture they belong to."""
    design = jb.table2()
    values = np.array([float(jb.get(design, path)) for path in PARAMETERS])
    linear = jax.block_until_ready(gradients(PROBE_CONE, design, jb.Scenario(), PARAMETERS, values, 8.0, rtol=rtol))
    slopes = np.asarray(linear.gradients[0]) * values / float(linear.results[0])
    return {path.split(".")[-1]: float(slope) for path, slope in zip(PARAMETERS, slopes, strict=True)}


def sweep(scenarios: jb.Scenario, rtol: float) -> jb.Sweep:
    """Table 2 in many ``scenarios``, whose leaves are arrays (n,)."""
    return jb.sweep(jb.table2(), scenarios, rtol=rtol)
