"""A capture: the run of the probe-cone mechanism."""

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

from jaxtyping import Array, Float, Int

from ...fields import Portable, numbers_text
from ..impacts import Impacts
from ..run import Run


class FirstImpact(Portable):
    """What the start of a run says of its first impact; scalars, differentiable.

    - ``effective_mass``: m_c that the contact normal meets through the joints [kg] (M79).
    - ``effective_energy``: T_c⁻ [J] (M79).
    - ``elastic_peak``: without loss [N] (M80).
    - ``predicted_peak``: with the law's loss [N] (M81); NaN for laws that are not Hertz's with hysteresis.
    - ``duration``: of the impact without loss [s] (M80).

    **Example:**

    >>> first = jb.first_impact(jb.table2())
    >>> print(f"{float(first.effective_mass):.4f} kg, {1e3 * float(first.effective_energy):.4f} mJ")
    0.1956 kg, 0.4891 mJ
    """

    effective_mass: Float[Array, ""]
    effective_energy: Float[Array, ""]
    elastic_peak: Float[Array, ""]
    predicted_peak: Float[Array, ""]
    duration: Float[Array, ""]

    def __repr__(self) -> str:
        units = {"effective_energy": ("mJ", 1e3), "duration": ("ms", 1e3), "effective_mass": ("kg", 1.0)}
        numbers = {name: (value, *units.get(name, ("N", 1.0))) for name, value in vars(self).items()}
        return numbers_text("First impact in closed form", numbers)


_DEGREES = 180.0 / math.pi
# In which people are shown them, and how many of it their own unit is.
DOCKED_UNITS: Mapping[str, tuple[str, float]] = MappingProxyType(
    {
        **dict.fromkeys(("latch_time", "settling_time"), ("s", 1.0)),
        **dict.fromkeys(("latch_share", "relative_energy"), ("%", 100.0)),
        **dict.fromkeys(("arrest_stroke", "lateral_miss"), ("mm", 1e3)),
        "energy_left": ("J", 1.0),
        "lateral_miss_rate": ("mm/s", 1e3),
        "attitude_miss": ("deg", _DEGREES),
        "attitude_miss_rate": ("deg/s", _DEGREES),
        "impulse": ("N s", 1.0),
    }
)


class Docking(Portable):
    """Docking beyond the crossing of the capture plane; scalars, NaN where a run has no such thing.

    - ``latch_time``: when the latches began to close [s].
    - ``settling_time``: from then until the vehicles were held [s].
    - ``latch_share``: largest force of the latches over their strength [-], 0 where nothing tears them; of a torn run
      above 1, by an estimate.
    - ``relative_energy``: energy of relative motion at the end over that at the start [-]; ``energy_left``: the former
      [J] (M177).
    - ``arrest_stroke``: the stroke at which the axial spring alone would store all of it [m] (M179).
    - ``lateral_miss`` [m], ``lateral_miss_rate`` [m/s], ``attitude_miss`` [rad], ``attitude_miss_rate`` [rad/s]: of the
      tip from the cone's axis, and of the probe against it, where it crosses the capture plane.
    - ``impulse``: on the passive vehicle, to the end [N s].
    """

    latch_time: Float[Array, ""]
    settling_time: Float[Array, ""]
    latch_share: Float[Array, ""]
    relative_energy: Float[Array, ""]
    energy_left: Float[Array, ""]
    arrest_stroke: Float[Array, ""]
    lateral_miss: Float[Array, ""]
    lateral_miss_rate: Float[Array, ""]
    attitude_miss: Float[Array, ""]
    attitude_miss_rate: Float[Array, ""]
    impulse: Float[Array, ""]

    @property
    def units(self) -> Mapping[str, tuple[str, float]]:
        """Return in which unit people are shown each number, and how many of it its own unit is."""
        return DOCKED_UNITS

    def direction_text(self) -> str:
        """Return how the probe points as its tip crosses the capture plane."""
        return f"{_DEGREES * float(self.attitude_miss):.4g} deg against it"

    def drift_text(self) -> str:
        """Return how the tip moves sideways as it crosses the capture plane."""
        return f"moving across it at {1e3 * float(self.lateral_miss_rate):.3g} mm/s"

    def __repr__(self) -> str:
        numbers = {name: (value, *self.units[name]) for name, value in vars(self).items()}
        return numbers_text("Docking beyond the capture plane", numbers)


class FlankImpacts(Impacts):
    """Impacts on the flanks: ``contact`` is 0 for the lower one and 1 for the upper one, also as ``flank``."""

    @property
    def flank(self) -> Int[Array, " slots"]:
        """Return the flank of each impact: 0 lower, 1 upper, -1 in slots beyond ``count``."""
        return self.contact


class Capture(Run):
    """A simulated capture. Print it for a summary.

    Beside what every `Run` has (``peak_contact``: 0 lower, 1 upper flank, also as ``peak_flank``), each a 0-d array:

    - ``peak_hinge_force``: largest force in the hinge [N].
    - ``peak_buffer_force``: largest force of the axial spring and damper [N].
    - ``peak_stop_force``: largest force of the end stop [N], 0 without one.
    - ``stroke``: the buffer's largest [m]; ``extension``: how far its rod goes out beyond its free position [m].
    - ``stroke_margin``: stroke left before the buffer's end [m]; below zero for a bottomed run, which is no
      measure of what is missing.
    - ``hinge_angle``: the largest [rad].
    - ``bending``: the tip's largest displacement off the probe's axis [m], 0 of a probe that does not bend.
    - ``throat_distance``: of the tip from the capture plane at the end [m].
    - ``capture_margin``: how far beyond that plane the tip would be at ``duration``, coasting on from the end of the
      run, or ``stroke_margin`` if that is less; positive exactly for a captured run [m].
    - ``capture_share``: that distance beyond the plane over the distance to it at the start [-].
    - ``peak_latch_force``: largest force of the latches [N], 0 without any.
    - ``passive_force``: largest sum of the forces on the passive vehicle [N]; NaN where it was not followed, in a run
      from contact without latches.
    - ``docking``: what it says of docking beyond the capture plane.
    - ``first_impact``: its closed form; NaN for a free start.

    **Example:**

    >>> capture = jb.simulate(jb.table2(), jb.Scenario())
    >>> print(f"stroke {1e3 * float(capture.stroke):.3f} mm, hinge {float(capture.peak_hinge_force):.1f} N")
    stroke 7.497 mm, hinge 426.4 N
    """

    docking_type: ClassVar[type[Docking]] = Docking
    impacts_type: ClassVar[type[Impacts]] = FlankImpacts
    peak_hinge_force: Float[Array, ""]
    peak_buffer_force: Float[Array, ""]
    peak_stop_force: Float[Array, ""]
    stroke: Float[Array, ""]
    extension: Float[Array, ""]
    stroke_margin: Float[Array, ""]
    hinge_angle: Float[Array, ""]
    bending: Float[Array, ""]
    throat_distance: Float[Array, ""]
    capture_margin: Float[Array, ""]
    capture_share: Float[Array, ""]
    peak_latch_force: Float[Array, ""]
    passive_force: Float[Array, ""]
    docking: Docking
    first_impact: FirstImpact

    @property
    def peak_flank(self) -> Int[Array, ""]:
        """Return the flank with the largest contact force: 0 lower, 1 upper."""
        return self.peak_contact
