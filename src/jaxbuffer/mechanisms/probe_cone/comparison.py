"""Contact laws side by side: what restitution each delivers, and one impact under each."""

from typing import NamedTuple

import numpy as np

from ...contact.laws import LAWS, ContactLaw, FreeImpact, free_impact
from ...errors import check_number, check_type
from ...fields import POSITIVE, Part, replace
from ...programs.process import check_ready
from ...tables import table, text
from ..registry import mechanism_of
from .assembly import tip_on_flanks
from .closed_form import assembled, first_flank
from .design import DockingDesign, Meeting

ASKED = (0.1, 0.3, 0.5, 0.7, 0.9)  # restitutions, as in the published comparisons
CURVE = tuple(np.round(np.linspace(0.02, 1.0, 50), 2))


class ComparedLaw(NamedTuple):
    """One law: its ``delivered`` restitutions for those `ASKED` and along `CURVE` [-], and the ``impact`` under it.

    ``law`` is the one of the impact, as the design sets it.
    """

    name: str
    law: ContactLaw
    delivered: np.ndarray
    curve: np.ndarray
    impact: FreeImpact


class Comparison(NamedTuple):
    """All laws in one impact of an effective ``mass`` [kg] at ``speed`` [m/s]. Print it for a table."""

    mass: float
    speed: float
    restitution: float
    laws: tuple[ComparedLaw, ...]

    def __repr__(self) -> str:
        return laws_table(self)


def first_contact(design: Part, scenario: Part) -> tuple[float, float]:
    """Return effective mass [kg] and approach speed [m/s] of the first impact."""
    mechanism = assembled(design, scenario)
    mass, speed = first_flank(mechanism, mechanism.first_evaluation()[0])
    return float(mass), float(speed)


def compare_laws(
    design: Part, scenario: Part | None = None, *, mass: float | None = None, speed: float | None = None
) -> Comparison:
    """Compare all contact laws at the design's contact numbers.

    **Arguments:** ``mass`` [kg], ``speed`` [m/s]: of the impact; default: those of the design's first contact.
    """
    check_ready()
    check_type("design", design, DockingDesign, "a capture's design, such as jb.table2()")
    assert isinstance(design, DockingDesign)
    for name, value, unit in (("mass", mass, "kg"), ("speed", speed, "m/s")):
        if value is not None:
            check_number(name, value, unit, **POSITIVE)
    meeting = mechanism_of(design).scenario() if scenario is None else scenario
    assert isinstance(meeting, Meeting)
    first = first_contact(design, meeting)
    mass, speed = (given if given is not None else own for given, own in zip((mass, speed), first, strict=True))

    def law(name: str, restitution: float) -> ContactLaw:
        # Only Adams' law may have an exponent of its own; the others keep Hertz's.
        own = {} if name == "adams" else {"contact.exponent": 1.5}
        # A smooth memory would refuse the laws whose force jumps at touchdown.
        chosen = {"contact.law": name, "contact.restitution": restitution, "contact.memory": "event"} | own
        return tip_on_flanks(replace(design, chosen)).law

    def compared(name: str) -> ComparedLaw:
        def delivered(values: tuple[float, ...]) -> np.ndarray:
            # A law without a restitution delivers the same, whatever is asked.
            if not hasattr(law(name, 1.0), "restitution"):
                return np.full(len(values), float(law(name, 1.0).delivered_restitution(mass, speed)))
            return np.array([float(law(name, float(e)).delivered_restitution(mass, speed)) for e in values])

        here = law(name, float(design.contact.restitution))
        return ComparedLaw(name, here, delivered(ASKED), delivered(CURVE), free_impact(here, mass, speed))

    return Comparison(mass, speed, float(design.contact.restitution), tuple(compared(name) for name in LAWS))


def laws_table(comparison: Comparison) -> str:
    """Return tables of each law's source, delivered restitutions and impact."""
    nominal = comparison.restitution
    restitution = table("Restitution delivered to two free bodies, for the one asked for")
    impact = table(
        f"Impact of {comparison.mass:.5g} kg at {comparison.speed:.5g} m/s, restitution {nominal:g} asked for"
    )
    for filled, right, last in (
        (restitution, [f"{e:g}" for e in ASKED], "source"),
        (impact, ["restitution", "penetration [µm]", "peak force [N]", "duration [ms]"], "validity"),
    ):
        filled.add_column("law")
        for heading in right:
            filled.add_column(heading, justify="right")
        filled.add_column(last)
    for entry in comparison.laws:
        restitution.add_row(entry.name, *(f"{e:.4f}" for e in entry.delivered), entry.law.source)
        result = entry.impact
        figures = (result.restitution, 1e6 * result.max_penetration, result.peak_force, 1e3 * result.duration)
        impact.add_row(entry.name, *(f"{x:.5g}" for x in figures), entry.law.validity)
    return text(restitution, impact)
