"""Whether an answer lies within what the model is good for: small penetrations, materials that do not yield, and
what elements and parts know of themselves."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ...contact.laws import contact_modulus, hertz_pressure, yield_pressure
from ..validity import BEYOND_LAW, ValidityLimit
from .assembly import tip_on_flanks
from .capture import Capture
from .design import Design
from .parts import PARTS, parts_of

DEEP = 0.1  # of the tip's radius: up to here the contact counts as small against the ball


class Validity(NamedTuple):
    """How near one capture or many (shape ...) come to the limits: ``depth`` [-]: penetration over the largest that the
    law is good for; ``pressure`` [-]: Hertz's largest pressure over the one at which yield begins, 0 without a yield
    stress. An answer is valid up to 1 of both."""

    depth: Float[np.ndarray, "..."]
    pressure: Float[np.ndarray, "..."]

    @property
    def too_deep(self) -> np.ndarray:
        """Return which captures penetrate deeper than the law is good for."""
        return self.depth > 1.0

    @property
    def yields(self) -> np.ndarray:
        """Return in which captures the materials yield."""
        return self.pressure > 1.0


def validity(design: Design, penetration: np.ndarray, peak_force: np.ndarray) -> Validity:
    """Return how near captures come to the limits, from their ``penetration`` [m] and ``peak_force`` [N] (NaN: unknown,
    and not beyond them); the design's numbers may be arrays of the same shape."""
    depth = np.asarray(penetration) / (DEEP * np.asarray(design.probe.tip_radius))
    stress = design.contact.yield_stress
    if stress is None:
        return Validity(depth, np.zeros_like(depth))
    # Which of the two sides is the softer is not known: the smaller of both ratios yields at the lower pressure.
    _, tip, _, cone = design.materials
    limit = yield_pressure(stress, jnp.minimum(jnp.asarray(tip), cone))
    return Validity(depth, np.asarray(pressure(design, peak_force)) / np.asarray(limit))


def limits(design: Design, quantities: Mapping[str, Any]) -> list[ValidityLimit]:
    """Return all limits with what lies beyond them in words; a penetration that is not known follows from the peak
    force."""
    peak_force, penetration = quantities["peak_force"], quantities.get("penetration")
    if penetration is None:
        # As a run reports it: where the spring alone exerts the force (M72).
        penetration = tip_on_flanks(design).law.depth(peak_force)
    ratios = validity(design, np.asarray(penetration), np.asarray(peak_force))
    return [
        ValidityLimit(f"{BEYOND_LAW}the tip goes deeper into the cone than a tenth of its radius", ratios.depth),
        ValidityLimit(f"{BEYOND_LAW}the materials yield", ratios.pressure),
        *(limit for part in PARTS for limit in part.validity(quantities)),
    ]


def pressure(design: Design, peak_force: Any) -> Float[Array, "..."]:
    """Return Hertz's largest pressure [Pa] at a contact force [N], from the design's materials and tip radius."""
    return hertz_pressure(peak_force, design.probe.tip_radius, contact_modulus(*design.materials))


def warnings(capture: Capture) -> list[str]:
    """Return a line for each validity limit that a capture exceeds; none for a valid one."""
    design, depth, force = capture.design, float(capture.penetration), float(capture.peak_force)
    ratios, lines = validity(design, np.asarray(depth), np.asarray(force)), []
    if ratios.too_deep:
        radius = float(design.probe.tip_radius)
        lines.append(
            f"{BEYOND_LAW}the tip goes up to {1e3 * depth:.3g} mm deep into the cone, more than"
            f" a tenth of its radius of {1e3 * radius:.3g} mm"
        )
    if ratios.yields:
        stress, reached = float(np.asarray(design.contact.yield_stress)), float(pressure(design, np.asarray(force)))
        lines.append(
            f"{BEYOND_LAW}the materials yield, {1e-6 * reached:.4g} MPa of contact pressure at"
            f" the peak being {float(ratios.pressure):.3g} times where a yield stress of {1e-6 * stress:.4g} MPa allows"
        )
    of_elements = (line for element in capture.elements for line in element.report.warnings(capture))
    of_parts = (line for part in parts_of(design, capture.scenario) for line in part.warnings(capture))
    return [*lines, *of_elements, *of_parts]
