"""A probe that bends: its modes (M108), and what is said of its bending."""

from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ...._types import Scalar
from ....elements import Element, EnergyShare, Panel, PanelCurve, Report
from ....elements.element import ROUNDED_LENGTH
from ....elements.telling import BY_HOW_MUCH
from ....fields import NON_NEGATIVE, POSITIVE, Number, number, on, whole
from ....multibody.flexible import Bar, FlexibleBar, cantilever_bar
from ....value_text import percent_text
from ...assembled import Assembled, Observable
from ...layout import EvaluatedState
from ...picture import reach
from ...quantity import Quantity
from .part import Joined, P, ProbePart
from .rod import RodFields

BENDING_MODES = 3
CLOSER = 0.1  # of the natural scale: errors of a mode that rings add up over thousands of steps
BENT = 0.1  # of the probe's length: up to here the bending is linear
WAVES = 1.0  # of the highest mode, in the first impact


class BendingFields(RodFields):
    """A rod that bends (M108). `with_bending` finds the stiffness for a frequency.

    The first two modes let the tip move and turn; a mode of ω has the damping ratio β ω/2.
    """

    bending_stiffness: Number = number(
        None,
        "N m²",
        **POSITIVE,
        doc="E I of the rod, which is clamped in the cylinder's guide; not set: it does not bend",
    )
    bending_modes: int = whole(BENDING_MODES, 2, needs=on("bending_stiffness"), doc="how many modes bend the rod")
    bending_damping: Number = number(
        0.0, "s", **NON_NEGATIVE, needs=on("bending_stiffness"), doc="damping β of the bending over its stiffness"
    )


def bending_probe(probe: "BendingFields") -> FlexibleBar | None:
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


def _frequencies(probe: BendingFields) -> np.ndarray:
    """Return the natural frequencies of a probe that bends [Hz]."""
    bar = bending_probe(probe)
    assert bar is not None
    return np.asarray(bar.modes.frequencies())


def _off_the_axis(mechanism: Assembled, at: EvaluatedState, rate: Array) -> Scalar:
    """Return how far the tip is bent off the probe's axis [m], 0 if it does not bend."""
    bending = mechanism.parts.probe.bending
    return jnp.zeros(()) if bending is None else bending.end.displacement(at.kin.modal(P)[0]).y


class Bending(Element):
    """What is told of a probe that bends; the probe itself is a body of the mechanism."""

    name: str = eqx.field(static=True, default="bending")

    @property
    def report(self) -> "BendingReport":
        return BendingReport(self)


class BendingReport(Report[Bending]):
    """What is said and drawn of a probe that bends."""

    def summary(self, run: Any) -> list[tuple[str, str]]:
        probe, frequencies = run.design.probe, _frequencies(run.design.probe)
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
        highest, duration = float(_frequencies(run.design.probe)[-1]), float(run.first_impact.duration)
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


class ProbeBending(ProbePart):
    """The bending of the probe."""

    def elements(self, joined: Joined) -> tuple[Element, ...]:
        return (Bending(),)

    def observables(self, design: Any) -> tuple[Observable, ...]:
        return (
            Observable(
                "bending",
                lambda *at: jnp.abs(_off_the_axis(*at)),
                roundoff=lambda mechanism: ROUNDED_LENGTH,
            ),
        )

    def history(self, design: Any) -> tuple[Observable, ...]:
        # A history has it in any case, with its sign.
        return (Observable("bending", _off_the_axis),)


BENDING = ProbeBending(
    name="bending",
    path="probe.bending_stiffness",
    quantities={
        "bending": Quantity(
            "m",
            lambda c: c.bending,
            "largest displacement of the tip off the axis of a probe that bends",
            "bending of the probe",
            swept=True,
            tuned=True,
            part="probe.bending_stiffness",
        ),
        "bending_loss": Quantity("J", lambda c: c.energy.bending, "energy lost in the probe's bending"),
    },
    recorded={"bending": "m"},
)
