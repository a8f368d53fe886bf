"""The bodies of the mechanism (M4): active vehicle S, cylinder B, probe P with its tip, passive vehicle T."""

from typing import Any, NamedTuple

from ..._types import Scalar
from ...multibody import Body, FlexibleBody, Point, Prismatic, Revolute, System
from ...multibody.flexible import FlexibleBar, Marker
from .design import Design, DockingDesign
from .parts.bending import BendingFields, bending_probe
from .parts.part import B as B
from .parts.part import P as P
from .parts.part import S as S
from .parts.part import T as T

TIP = "tip"  # name of the contact of the tip with both flanks


class Masses(NamedTuple):
    """The probe with its tip (M6).

    - ``mass``: m_P [kg].
    - ``inertia``: I_P about the centre of mass [kg m²].
    - ``rear``, ``front``: l_r and l_t, from the centre of mass to the rear end and to the tip's centre [m].
    - ``tip_inertia``: I_t of the tip about its centre [kg m²]; a welded tip's is part of ``inertia`` too.
    - ``bending``: of a probe that bends, the modes of its rod with the tip, clamped at the rear end.
    """

    mass: Scalar
    inertia: Scalar
    rear: Scalar
    front: Scalar
    tip_inertia: Scalar
    bending: FlexibleBar | None

    @property
    def tip_centre(self) -> Point:
        """Return the tip's centre, on the probe."""
        return (self.front, 0.0) if self.bending is None else self.bending.end

    def guided(self, x: Scalar) -> Point:
        """Return a point of the probe's axis that does not bend, ``x`` [m] before its centre of mass."""
        return (x, 0.0) if self.bending is None else Marker.on_frame(x, 0.0, self.bending.modes.size)


def probe_masses(design: DockingDesign[Any]) -> Masses:
    """Return rod and tip as one body; a free tip's spin inertia is left out of it (M6)."""
    probe = design.probe
    mass = probe.rod_mass + probe.tip_mass
    shift = probe.tip_mass * (probe.length / 2) / mass
    rear, front = probe.length / 2 + shift, probe.length / 2 - shift
    tip = probe.tip_inertia
    inertia = probe.rod_mass * (probe.length**2 / 12 + shift**2) + probe.tip_mass * front**2
    bending = bending_probe(probe) if isinstance(probe, BendingFields) else None
    return Masses(mass, inertia if probe.free_tip else inertia + tip, rear, front, tip, bending)


def assemble_system(design: Design, probe: Masses, stabilisation: Scalar) -> System:
    """Return bodies and joints of the mechanism (M15).

    **Arguments:** ``design``; ``probe``: masses and lengths of the probe; ``stabilisation``: Baumgarte's gain [1/s].
    """
    half = design.buffer.cylinder_length / 2
    cylinder = Body(design.buffer.cylinder_mass, design.buffer.cylinder_mass * design.buffer.cylinder_length**2 / 12)
    hinge = Revolute(S, B, first_point=(design.active.hinge_offset, 0.0), second_point=(half, 0.0))
    guide = Prismatic(B, P, second_point=probe.guided(0.0))
    return System(
        bodies=(
            Body(design.active.mass, design.active.inertia),
            cylinder,
            Body(probe.mass, probe.inertia) if probe.bending is None else FlexibleBody(probe.bending.modes),
            Body(design.passive.mass, design.passive.inertia),
        ),
        # With play the contact of the pin holds the hinge, in place of the joint (M109).
        joints=(guide,) if design.hinge.has("play") else (hinge, guide),
        stabilisation=stabilisation,
    )
