"""A probe that bends: its modes (M108), its frequencies, and the design that has a given one."""

from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._types import Scalar
from ...elements import Element, EnergyShare, Panel, PanelCurve, Report
from ...elements.telling import BY_HOW_MUCH
from ...errors import InputError, check_single, check_type
from ...fields import NON_NEGATIVE, POSITIVE, replace
from ...multibody.flexible import Bar, FlexibleBar, cantilever_bar
from ...value_text import percent_text
from ..picture import reach
from .design import Design
from .parts import BENDING_MODES, Probe

CLOSER = 0.1  # of the natural scale: errors of a mode that rings add up over thousands of steps
ONE = "{} is one number"
BENT = 0.1  # of the probe's length: up to here the bending is linear
WAVES = 1.0  # of the highest mode, in the first impact


def bending_probe(probe: Probe) -> FlexibleBar | None:
    """Return the rod, clamped at its rear end, with the tip at its front end (M108); None for a probe that does not
    bend."""
    if not probe.has("bending_stiffness"):
        return None
    rod = Bar(
        probe.length,
        area=1.0,
        second_moment=probe.bending_stiffness,
        density=probe.rod_mass / probe.length,
        youngs_modulus=1.0,
    )  # of which only mass and bending stiffness matter
    # A tip that spins freely does not turn with the end of the rod.
    inertia = 0.0 if probe.free_tip else probe.tip_inertia
    bar = cantilever_bar(rod, probe.bending_modes - 2, tip_mass=probe.tip_mass, tip_inertia=inertia)
    modes = bar.modes.with_damping(probe.bending_damping * bar.modes.stiffness)
    return eqx.tree_at(lambda b: b.modes, bar, modes)


def modal_scales(bar: FlexibleBar, speed: Scalar) -> tuple[list[Scalar], list[Scalar]]:
    """Return magnitudes that matter of each modal coordinate [m] and of its rate [m/s], as large in energy as each
    other.

    **Arguments:** ``bar``; ``speed``: of the approach [m/s].
    """
    mass, stiffness = bar.modes.mass_matrix, bar.modes.stiffness
    slow = CLOSER * speed
    # At the scales ½ k q² is as large as ½ m q̇².
    return [slow * jnp.sqrt(mass[k, k] / stiffness[k, k]) for k in range(bar.modes.size)], [slow] * bar.modes.size


def bending_frequencies(design: Design) -> Float[Array, " modes"]:
    """Return the natural frequencies of the probe with its tip, clamped in its guide [Hz], shape (modes,), in ascending
    order (M108).

    **Arguments:** ``design``: one whose probe bends.

    **Raises:** `InputError` if it does not.

    **Example:**

    >>> import math
    >>> aluminium = jb.replace(jb.table2(), {"probe.bending_stiffness": 71.7e9 * math.pi * 0.009**4 / 4})  # N m²
    >>> [round(float(f), 1) for f in jb.bending_frequencies(aluminium)[:2]]
    [220.4, 1592.8]
    """
    check_type("design", design, Design, "jb.table2(), say")
    bar = bending_probe(design.probe)
    if bar is None:
        raise InputError("the probe does not bend: give probe.bending_stiffness [N m²]")
    return bar.modes.frequencies()


def with_bending(design: Design, frequency: float, damping_ratio: float = 0.02, modes: int = BENDING_MODES) -> Design:
    """Return the design with a probe that bends at a given first frequency (M108).

    **Arguments:** ``design``; ``frequency``: the first one, clamped in the guide, with the tip [Hz]; ``damping_ratio``:
    ζ of that mode [-], the k-th has ζ f_k/f_1; ``modes``: how many.

    **Raises:** `InputError` for values out of range.

    **Example:**

    >>> soft = jb.with_bending(jb.table2(), 50.0)
    >>> print(f"{float(soft.probe.bending_stiffness):.4g} N m², {float(jb.bending_frequencies(soft)[0]):.4g} Hz")
    19.01 N m², 50 Hz
    """
    check_single("frequency", frequency, "Hz", ONE.format("frequency"), **POSITIVE)
    check_single("damping_ratio", damping_ratio, "-", ONE.format("damping_ratio"), **NON_NEGATIVE)
    # All frequencies go with the root of the bending stiffness: those of 1 N m² tell the one that is wanted.
    unit = replace(design, {"probe.bending_stiffness": 1.0, "probe.bending_modes": modes})
    first = float(bending_frequencies(unit)[0])
    values = {
        "probe.bending_stiffness": (frequency / first) ** 2,
        # The damping ratio of a mode is β ω/2 (M108).
        "probe.bending_damping": damping_ratio / (np.pi * frequency),
    }
    return replace(unit, values)


class Bending(Element):
    """What is told of a probe that bends; the probe itself is a body of the mechanism."""

    name: str = eqx.field(static=True, default="bending")

    @property
    def report(self) -> "BendingReport":
        return BendingReport(self)


class BendingReport(Report[Bending]):
    """What is said and drawn of a probe that bends."""

    def summary(self, run: Any) -> list[tuple[str, str]]:
        probe, frequencies = run.design.probe, np.asarray(bending_frequencies(run.design))
        damped = percent_text(np.pi * frequencies[0] * float(probe.bending_damping), ".3g")
        modes = f"{probe.bending_modes} modes, {frequencies[0]:.4g} to {frequencies[-1]:.4g} Hz"
        return [
            (
                self.element.name,
                f"at most {1e3 * float(run.bending):.4g} mm at the tip; {modes}, the first damped to {damped}",
            )
        ]

    def panels(self, run: Any) -> list[Panel]:
        off = 1e3 * np.asarray(run.history.bending)
        title = f"Bending of the probe{reach(off, 1e3 * float(run.bending), 'mm')}"
        return [Panel(title, "tip off the axis [mm]", (PanelCurve("", 1e3 * run.history.bending),))]

    def warnings(self, run: Any) -> list[str]:
        probe, lines = run.design.probe, []
        length, bent = float(probe.length), float(run.bending)
        if bent > BENT * length:
            lines.append(
                f"outside the linear theory of bending: the tip bends {1e3 * bent:.3g} mm off the probe's axis, more"
                f" than a tenth of its length of {1e3 * length:.3g} mm"
            )
        if float(probe.bending_damping) == 0.0:
            # Each impact meets a ringing that all earlier ones have left, so that their errors add up (M108).
            lines.append(
                "errors may grow: the probe's bending is not damped (probe.bending_damping = 0 s) and rings on through"
                f" all impacts; its forces may be off by per cents at any tolerance; {BY_HOW_MUCH}"
            )
        highest, duration = float(bending_frequencies(run.design)[-1]), float(run.first_impact.duration)
        # A free start has no closed form: its NaN is not below the limit, and warns of nothing.
        if highest * duration < WAVES:
            lines.append(
                f"too few modes: the highest, {highest:.4g} Hz, is too slow to follow impacts of {1e3 * duration:.3g}"
                f" ms; peak forces will change with probe.bending_modes = {probe.bending_modes}"
            )
        return lines

    @property
    def shares(self) -> tuple[EnergyShare, ...]:
        bending = self.element
        return (EnergyShare(bending.name, f"lost in {bending.name}", (bending.name,)),)
