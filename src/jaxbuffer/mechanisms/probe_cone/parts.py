"""The parts of the probe-cone mechanism but its buffer and its contact: every number, checked when a part is made.

Each number is a scalar, or an array where many designs are handled together; its unit stands in its declaration. The
table "symbols and fields" of docs/model.md has them all, with symbols and where the defaults come from.
"""

import math
from collections.abc import Iterator
from typing import ClassVar

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from ..._types import Scalar
from ...errors import InputError, check_entries, concrete, inside
from ...fields import NON_NEGATIVE, POSITIVE, Number, Part, number, on, whole

ALUMINIUM_DENSITY = 2740.0  # kg/m³, the paper's section 7
ROD_RADIUS = 0.009  # m, r_p of Table 2
TIP_RADIUS = 0.015  # m, R_tip of Table 2
PROBE_LENGTH = 0.2  # m, L_P of Table 2
BENDING_MODES = 3


class Active(Part):
    """The active vehicle S, which carries the probe.

    - ``mass``: m_S [kg].
    - ``inertia``: I_S about its centre of mass [kg m²].
    - ``hinge_offset``: a, from its centre of mass forward to the hinge [m].
    """

    section: ClassVar[str] = "active"
    mass: Number = number(21.9706, "kg", **POSITIVE, doc="mass m_S of the active vehicle")
    inertia: Number = number(0.445, "kg m²", **POSITIVE, doc="inertia I_S about its centre of mass")
    hinge_offset: Number = number(0.1365, "m", **NON_NEGATIVE, doc="a, from its centre of mass forward to the hinge")


class Passive(Part):
    """The passive vehicle T, which carries the cone.

    - ``mass``: m_T [kg].
    - ``inertia``: I_T about its centre of mass [kg m²].
    """

    section: ClassVar[str] = "passive"
    mass: Number = number(23.5731, "kg", **POSITIVE, doc="mass m_T of the passive vehicle")
    inertia: Number = number(0.5206, "kg m²", **POSITIVE, doc="inertia I_T about its centre of mass")


class RodWithTip(Part):
    """The rod and its ball tip, welded to the rod or spinning freely about its centre (M6).

    - ``length``: L_P, from the rod's rear end to the tip's centre [m].
    - ``rod_mass``: m_r [kg] (default: M7).
    - ``tip_radius``: R [m].
    - ``tip_mass``: m_t [kg] (default: M7).
    - ``free_tip``: whether the tip spins freely (M8).
    """

    section: ClassVar[str] = "probe"
    length: Number = number(PROBE_LENGTH, "m", **POSITIVE, doc="L_P, from the rod's rear end to the tip's centre")
    rod_mass: Number = number(
        ALUMINIUM_DENSITY * math.pi * ROD_RADIUS**2 * PROBE_LENGTH, "kg", **POSITIVE, doc="mass m_r of the rod"
    )
    tip_radius: Number = number(TIP_RADIUS, "m", **POSITIVE, doc="radius R of the ball tip")
    tip_mass: Number = number(
        ALUMINIUM_DENSITY * 4.0 / 3.0 * math.pi * TIP_RADIUS**3, "kg", **POSITIVE, doc="mass m_t of the ball tip"
    )
    free_tip: bool = eqx.field(
        default=False, static=True, metadata={"doc": "whether the tip spins freely about its centre", "flag": True}
    )

    @property
    def tip_inertia(self) -> Scalar:
        """Return I_t of the tip about its centre [kg m²] (M6)."""
        return 0.4 * self.tip_mass * self.tip_radius**2


class Probe(RodWithTip):
    """The rod and its tip, of which the rod may bend.

    - ``bending_stiffness``: E I of the rod, which is clamped in the cylinder's guide [N m²] (M108); None: it does not
      bend. `with_bending` finds it for a frequency.
    - ``bending_modes``: how many modes bend it; the first two let the tip move and turn.
    - ``bending_damping``: β, the damping of the bending over its stiffness [s]: the mode of ω has the ratio β ω/2.
    """

    bending_stiffness: Number = number(
        None,
        "N m²",
        **POSITIVE,
        doc="E I of the rod, which is clamped in the cylinder's guide; not set: it does not bend",
    )
    bending_modes: int = whole(BENDING_MODES, 2, needs=on("bending_stiffness"), doc="how many modes bend the rod")
    bending_damping: Number = number(
        0.0, "s", **NON_NEGATIVE, needs=on("bending_stiffness"), doc="damping of the bending over its stiffness"
    )


class Hinge(Part):
    """Play in the hinge between active vehicle and cylinder: a pin on the vehicle in a bush on the cylinder.

    Force of the contact: K δ^{3/2} (1 + a δ̇), Hunt and Crossley's, without friction (M109).

    - ``play``: radial clearance, the bush's radius less the pin's [m]; None: none, the hinge holds.
    - ``bush_radius``: [m].
    - ``damping``: a [s/m]; two free bodies part with the restitution 1 - ⅔ a v, while that is near 1.
    - ``young_modulus`` [Pa], ``poisson_ratio`` [-]: of pin and bush.
    """

    section: ClassVar[str] = "hinge"
    play: Number = number(
        None, "m", **POSITIVE, doc="radial clearance, the bush's radius less the pin's; not set: none"
    )
    bush_radius: Number = number(0.005, "m", **POSITIVE, needs=on("play"), doc="radius of the bush")
    damping: Number = number(
        5.0,
        "s/m",
        **NON_NEGATIVE,
        needs=on("play"),
        doc="factor a of the contact's damping; impacts part with about 1 - 2/3 a v",
    )
    young_modulus: Number = number(71.7e9, "Pa", **POSITIVE, needs=on("play"), doc="Young's modulus of pin and bush")
    poisson_ratio: Number = number(
        0.3, "-", low=-1.0, high=0.5, low_open=True, needs=on("play"), doc="Poisson's ratio of pin and bush"
    )

    def check_together(self) -> None:
        if self.has("play"):
            check_entries("hinge.play", self.play, "m", 0.0, self.bush_radius, too_high="; below hinge.bush_radius")

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        if self.has("play"):
            yield inside(self.play, high=self.bush_radius, high_open=True, **POSITIVE)

    @property
    def pin_radius(self) -> Scalar:
        """Return the pin's radius [m], the bush's less the play."""
        return self.bush_radius - (self.play if self.has("play") else 0.0)


class Latches(Part):
    """Latches that close where the tip crosses the capture plane, and hold the vehicles together (M175 to M177).

    Without them a run ends there.

    - ``stiffness`` k_l [N/m], ``damping`` c_l [N s/m]: hold the tip's centre in its seat. Stiffness None: no latch.
    - ``preload`` F_l [N], reached over ``preload_length`` r_l [m]: with which they pull it there.
    - ``turn_stiffness`` k_t [N m/rad], ``turn_damping`` c_t [N m s/rad]: hold the probe along the cone's axis.
    - ``closing_time``: in which they close [s].
    - ``depth``: of the seat behind the capture plane [m].
    - ``strength``: force that tears them [N]; None: none does.
    - ``quiet``: share of the energy of relative motion at the start below which the vehicles count as held [-].
    """

    section: ClassVar[str] = "latch"
    stiffness: Number = number(
        None, "N/m", **POSITIVE, doc="stiffness k_l with which the tip is held in its seat; not set: no latch"
    )
    damping: Number = number(
        0.0, "N s/m", **NON_NEGATIVE, needs=on("stiffness"), doc="damping c_l of the tip in its seat"
    )
    preload: Number = number(
        0.0, "N", **NON_NEGATIVE, needs=on("stiffness"), doc="force F_l with which the latch pulls the tip to its seat"
    )
    preload_length: Number = number(
        1e-4,
        "m",
        **POSITIVE,
        needs=(*on("stiffness"), *on("preload")),
        doc="distance over which that preload is reached",
    )
    turn_stiffness: Number = number(
        0.0,
        "N m/rad",
        **NON_NEGATIVE,
        needs=on("stiffness"),
        doc="stiffness k_t with which the probe is held along the cone's axis",
    )
    turn_damping: Number = number(
        0.0, "N m s/rad", **NON_NEGATIVE, needs=on("stiffness"), doc="damping c_t of the probe's turning"
    )
    closing_time: Number = number(
        0.02, "s", **NON_NEGATIVE, needs=on("stiffness"), doc="time in which the latch closes"
    )
    depth: Number = number(0.0, "m", needs=on("stiffness"), doc="depth of the seat behind the capture plane")
    strength: Number = number(
        None, "N", **POSITIVE, needs=on("stiffness"), doc="force that tears the latch; not set: none does"
    )
    quiet: Number = number(
        1e-3,
        "-",
        low=0.0,
        high=1.0,
        low_open=True,
        high_open=True,
        needs=on("stiffness"),
        doc="share of the first energy of relative motion at which the vehicles count as held",
    )

    def check_together(self) -> None:
        if not self.has("strength"):
            return
        preload, strength, closing = (concrete(x) for x in (self.preload, self.strength, self.closing_time))
        if preload is not None and strength is not None and np.any(below := strength <= preload):
            both = [float(array[below].flat[0]) for array in np.broadcast_arrays(strength, preload)]
            raise InputError(
                f"latch.strength = {both[0]:g} N must be above latch.preload = {both[1]:g} N: the preload alone would"
                " tear the latch"
            )
        if closing is not None and np.any(closing == 0.0):
            raise InputError(
                "latch.closing_time = 0 s with a latch.strength: the latch would jump to its force at once, and its"
                " tearing would depend on nothing; give a closing time above 0 s, the default 0.02 s say"
            )

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        if self.has("strength"):
            yield inside(self.strength, low=self.preload, low_open=True)
            yield inside(self.closing_time, **POSITIVE)


class Cone(Part):
    """The cone on the passive vehicle (M30).

    - ``half_angle``: β [rad].
    - ``offset``: L_T, from the throat plane to the centre of mass of T [m].
    - ``throat_radius``: R_c [m].
    - ``length``: L_c, along the flank [m].
    - ``young_modulus`` [Pa], ``poisson_ratio`` [-]: of the flanks; None: that of the tip, as `Contact` has it.
    """

    section: ClassVar[str] = "cone"
    half_angle: Number = number(
        math.pi / 4, "rad", low=0.0, high=math.pi / 2, low_open=True, high_open=True, doc="half angle β of the cone"
    )
    offset: Number = number(
        0.096, "m", **NON_NEGATIVE, doc="L_T, from the throat plane to the passive vehicle's centre of mass"
    )
    throat_radius: Number = number(0.015, "m", **POSITIVE, doc="radius R_c of the throat")
    length: Number = number(0.0735, "m", **POSITIVE, doc="L_c, along the flank")
    young_modulus: Number = number(
        None, "Pa", **POSITIVE, doc="Young's modulus of the flanks; not set: contact.young_modulus"
    )
    poisson_ratio: Number = number(
        None,
        "-",
        low=-1.0,
        high=0.5,
        low_open=True,
        doc="Poisson's ratio of the flanks; not set: contact.poisson_ratio",
    )
