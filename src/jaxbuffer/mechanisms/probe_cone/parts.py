"""The parts of the probe-cone mechanism: every number of its design, checked when a part is made.

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
from ...contact import LAWS
from ...errors import (
    InputError,
    check_entries,
    concrete,
    inside,
)
from ...fields import NON_NEGATIVE, POSITIVE, Curve, Number, Part, choice, curve, number, whole

ALUMINIUM_DENSITY = 2740.0  # kg/m³, the paper's section 7
ROD_RADIUS = 0.009  # m, r_p of Table 2
TIP_RADIUS = 0.015  # m, R_tip of Table 2
PROBE_LENGTH = 0.2  # m, L_P of Table 2
HERTZ_EXPONENT = 1.5  # -
DAMPER = ("damper_curve", "c_A2", "rebound_factor")  # what the axial damper may have besides c_A
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


class Buffer(Part):
    """Axial and torsional spring-dampers, the cylinder between them, and the buffer's end.

    - ``k_A``: stiffness along the cylinder [N/m] (M23).
    - ``c_A``: damping along the cylinder [N s/m] (M23).
    - ``k_T``: stiffness about the hinge [N m/rad] (M26).
    - ``c_T``: damping about the hinge [N m s/rad] (M26).
    - ``free_length``: l_0 of the axial spring [m].
    - ``cylinder_mass`` m_B [kg], ``cylinder_length`` L_C [m]: a slender rod (M5).
    - ``spring_curve``: measured points (stroke [m], force [N]) in place of ``k_A`` (M173).
    - ``damper_curve``: measured points (speed [m/s], force [N]) in place of ``c_A`` and ``c_A2`` (M173).
    - ``preload`` F_p [N], reached over ``preload_length`` s_p [m]: with which the spring pushes at once (M171).
    - ``c_A2``: quadratic damping along the cylinder [N s²/m²] (M172).
    - ``rebound_factor``: ρ, by which the damper's force is larger on the way out [-] (M172).
    - ``friction`` F_f [N], regularised below ``friction_speed`` v_f [m/s] (M172).
    - ``rebound_stiffness`` k_r [N/m], ``rebound_damping`` c_r [N s/m]: a stop that holds the probe near its free
      length, from ``rebound_gap`` g_r [m] beyond it on (M174). None: the spring also pulls, as in the paper.
    - ``max_stroke``: stroke s_m at which the buffer is at its end [m]; None: ``free_length``, where the spring's ends
      meet. Without an end stop a run that gets there ends as "bottomed" (M66).
    - ``stop_stiffness`` k_s [N/m], ``stop_damping`` c_s [N s/m]: an end stop that pushes the probe out again while the
      stroke exceeds s_m (M28). Only ``free_length`` ends that run. None: no end stop.
    - ``damping``: "physical" damps L̇ (M23); "published" damps the whole rate of the separation (M24), which does not
      conserve angular momentum.
    """

    section: ClassVar[str] = "buffer"
    k_A: Number = number(500.0, "N/m", **POSITIVE, doc="stiffness along the cylinder")
    c_A: Number = number(5.0, "N s/m", **NON_NEGATIVE, doc="damping along the cylinder")
    k_T: Number = number(300.0, "N m/rad", **POSITIVE, doc="stiffness about the hinge")
    c_T: Number = number(2.0, "N m s/rad", **NON_NEGATIVE, doc="damping about the hinge")
    free_length: Number = number(0.1365, "m", **POSITIVE, doc="free length l_0 of the axial spring")
    cylinder_mass: Number = number(1.0, "kg", **POSITIVE, doc="mass m_B of the cylinder")
    cylinder_length: Number = number(0.1365, "m", **POSITIVE, doc="length L_C of the cylinder, a slender rod")
    max_stroke: Number = number(
        None, "m", **POSITIVE, doc="stroke s_m at which the buffer is at its end; not set: the free length"
    )
    stop_stiffness: Number = number(
        None, "N/m", **POSITIVE, doc="stiffness k_s of an end stop beyond the largest stroke; not set: none"
    )
    stop_damping: Number = number(0.0, "N s/m", **NON_NEGATIVE, doc="damping c_s of the end stop")
    spring_curve: Curve | None = curve(
        ("stroke", "m"),
        ("force", "N"),
        instead_of=("k_A",),
        doc="measured points [stroke [m], force [N]] of the axial spring, in place of k_A; not set: none",
    )
    damper_curve: Curve | None = curve(
        ("speed", "m/s"),
        ("force", "N"),
        instead_of=("c_A", "c_A2"),
        doc="measured points [speed [m/s], force [N]] of the axial damper, in place of c_A and c_A2; not set: none",
    )
    preload: Number = number(None, "N", **NON_NEGATIVE, doc="force F_p with which the axial spring pushes at once")
    preload_length: Number = number(1e-4, "m", **POSITIVE, doc="stroke over which the preload is reached")
    c_A2: Number = number(None, "N s²/m²", **NON_NEGATIVE, doc="quadratic damping along the cylinder; not set: none")
    rebound_factor: Number = number(
        None, "-", **POSITIVE, doc="factor of the damper's force on the way out; not set: 1"
    )
    friction: Number = number(None, "N", **NON_NEGATIVE, doc="friction F_f along the cylinder; not set: none")
    friction_speed: Number = number(1e-3, "m/s", **POSITIVE, doc="speed below which that friction falls to zero")
    rebound_stiffness: Number = number(
        None, "N/m", **POSITIVE, doc="stiffness k_r of a stop beyond the free length; not set: none"
    )
    rebound_damping: Number = number(0.0, "N s/m", **NON_NEGATIVE, doc="damping c_r of the rebound stop")
    rebound_gap: Number = number(5e-4, "m", **POSITIVE, doc="way beyond the free length at which that stop begins")
    damping: str = choice(
        "physical",
        "physical",
        "published",
        doc="physical: the rate of the length is damped; published: the whole rate of the separation",
    )

    def check_together(self) -> None:
        if self.max_stroke is not None:
            check_entries("buffer.max_stroke", self.max_stroke, "m", 0.0, self.free_length, high_open=False)
        damping = concrete(self.stop_damping)
        if self.stop_stiffness is None and damping is not None and np.any(damping != 0.0):
            shown = f"buffer.stop_damping = {float(damping.flat[np.argmax(damping)]):g} N s/m"
            raise InputError(f"{shown} needs an end stop: give buffer.stop_stiffness [N/m] too")
        damping = concrete(self.rebound_damping)
        if self.rebound_stiffness is None and damping is not None and np.any(damping != 0.0):
            shown = f"buffer.rebound_damping = {float(damping.flat[np.argmax(damping)]):g} N s/m"
            raise InputError(f"{shown} needs a rebound stop: give buffer.rebound_stiffness [N/m] too")
        self._check_curves()

    def _check_curves(self) -> None:
        """A curve and the numbers that it stands for are not given together, nor with the paper's damping."""
        for measured, names in (("spring_curve", ("k_A",)), ("damper_curve", ("c_A", "c_A2"))):
            both = [name for name in names if getattr(self, name) is not None]
            if getattr(self, measured) is not None and both:
                raise InputError(
                    f"buffer.{measured} and buffer.{both[0]} are given together; the curve stands for"
                    f" {' and '.join(names)}: keep one of them"
                )
        if self.damping == "published" and (more := [name for name in DAMPER if getattr(self, name) is not None]):
            raise InputError(
                f'buffer.damping = "published" has the paper\'s damper alone, which buffer.{more[0]} is no part of:'
                ' leave it out, or set damping to "physical"'
            )

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        if self.max_stroke is not None:
            yield inside(self.max_stroke, high=self.free_length, **POSITIVE)
        if self.stop_stiffness is None:
            yield inside(self.stop_damping, low=0.0, high=0.0)
        if self.rebound_stiffness is None:
            yield inside(self.rebound_damping, low=0.0, high=0.0)

    @property
    def end(self) -> Scalar:
        """The stroke at which the buffer is at its end or its end stop, if there is one, begins to push [m] (M28)."""
        return self.free_length if self.max_stroke is None else self.max_stroke

    @property
    def longest_stroke(self) -> Scalar:
        """The stroke that ends a run as "bottomed" [m] (M66): with an end stop that is where the spring's ends meet."""
        return self.end if self.stop_stiffness is None else self.free_length


class Probe(Part):
    """The rod and its ball tip, welded to the rod or spinning freely about its centre (M6).

    - ``length``: L_P, from the rod's rear end to the tip's centre [m].
    - ``rod_mass``: m_r [kg] (default: M7).
    - ``tip_radius``: R [m].
    - ``tip_mass``: m_t [kg] (default: M7).
    - ``free_tip``: whether the tip spins freely (M8).
    - ``bending_stiffness``: E I of the rod, which is clamped in the cylinder's guide [N m²] (M108); None: it does not
      bend. `with_bending` finds it for a frequency.
    - ``bending_modes``: how many modes bend it; the first two let the tip move and turn.
    - ``bending_damping``: β, the damping of the bending over its stiffness [s]: the mode of ω has the ratio β ω/2.
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
    bending_stiffness: Number = number(
        None,
        "N m²",
        **POSITIVE,
        doc="E I of the rod, which is clamped in the cylinder's guide; not set: it does not bend",
    )
    bending_modes: int = whole(BENDING_MODES, 2, doc="how many modes bend the rod")
    bending_damping: Number = number(0.0, "s", **NON_NEGATIVE, doc="damping of the bending over its stiffness")

    @property
    def tip_inertia(self) -> Scalar:
        """I_t of the tip about its centre [kg m²] (M6)."""
        return 0.4 * self.tip_mass * self.tip_radius**2


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
    bush_radius: Number = number(0.005, "m", **POSITIVE, doc="radius of the bush")
    damping: Number = number(
        5.0, "s/m", **NON_NEGATIVE, doc="factor a of the contact's damping; impacts part with about 1 - 2/3 a v"
    )
    young_modulus: Number = number(71.7e9, "Pa", **POSITIVE, doc="Young's modulus of pin and bush")
    poisson_ratio: Number = number(0.3, "-", low=-1.0, high=0.5, low_open=True, doc="Poisson's ratio of pin and bush")

    def check_together(self) -> None:
        if self.play is not None:
            check_entries("hinge.play", self.play, "m", 0.0, self.bush_radius)

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        if self.play is not None:
            yield inside(self.play, high=self.bush_radius, high_open=True, **POSITIVE)

    @property
    def pin_radius(self) -> Scalar:
        """The bush's radius less the play [m]."""
        return self.bush_radius - (0.0 if self.play is None else self.play)


class Latch(Part):
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
    damping: Number = number(0.0, "N s/m", **NON_NEGATIVE, doc="damping c_l of the tip in its seat")
    preload: Number = number(0.0, "N", **NON_NEGATIVE, doc="force F_l with which the latch pulls the tip to its seat")
    preload_length: Number = number(1e-4, "m", **POSITIVE, doc="distance over which that preload is reached")
    turn_stiffness: Number = number(
        0.0, "N m/rad", **NON_NEGATIVE, doc="stiffness k_t with which the probe is held along the cone's axis"
    )
    turn_damping: Number = number(0.0, "N m s/rad", **NON_NEGATIVE, doc="damping c_t of the probe's turning")
    closing_time: Number = number(0.02, "s", **NON_NEGATIVE, doc="time in which the latch closes")
    depth: Number = number(0.0, "m", doc="depth of the seat behind the capture plane")
    strength: Number = number(None, "N", **POSITIVE, doc="force that tears the latch; not set: none does")
    quiet: Number = number(
        1e-3,
        "-",
        low=0.0,
        high=1.0,
        low_open=True,
        high_open=True,
        doc="share of the first energy of relative motion at which the vehicles count as held",
    )

    def check_together(self) -> None:
        if self.strength is None:
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
        if self.strength is not None:
            yield inside(self.strength, low=self.preload, low_open=True)
            yield inside(self.closing_time, **POSITIVE)


class Cone(Part):
    """The cone on the passive vehicle (M30).

    - ``half_angle``: β [rad].
    - ``offset``: L_T, from the throat plane to the centre of mass of T [m].
    - ``throat_radius``: R_c [m].
    - ``length``: L_c, along the flank [m].
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


class Contact(Part):
    """Tip against flank: a normal law and regularised Coulomb friction.

    - ``law``: a name of `contact.laws.LAWS`; each law takes those of the following fields that it has. The defaults of
      "kelvin-voigt" and "adams" are as stiff and as lossy as Table 2's law at the depth of its first impact.
    - ``stiffness``: K [N/m^1.5], of "adams" [N/m^exponent]; None: computed from the materials and the tip's radius
      (M53).
    - ``restitution``: e in (0, 1] that is asked of the laws with hysteresis [-].
    - ``friction`` μ [-], ``slip_speed`` v_s [m/s]: M59.
    - ``young_modulus`` [Pa], ``poisson_ratio`` [-]: of both sides.
    - ``yield_stress``: of the softer side [Pa]; if given, the answer says where the materials yield (M57).
    - ``linear_stiffness`` k [N/m] of "kelvin-voigt"; ``damping`` c [N s/m] of "kelvin-voigt" and "adams".
    - ``exponent`` n [-], ``ramp_depth`` d [m]: of "adams".
    - ``onset_length`` ε [m], ``memory_time`` τ_m [s]: of the smooth contact (M60, M61).
    - ``memory``: "event" holds the speed of the last touchdown, located as an event (M36); "smooth" lets it follow the
      approach speed while out of contact (M61) and rounds the onset (M60).
    - ``arms``: "moving" acts at the foot (M33); "published" freezes the arm on T where the first contact was (M34).
    """

    section: ClassVar[str] = "contact"
    law: str = eqx.field(
        default="lankarani-nikravesh",
        static=True,
        metadata={"doc": "contact law; it takes those of the other fields that it has", "choices": LAWS},
    )
    stiffness: Number = number(
        None, "N/m^1.5", **POSITIVE, doc="stiffness K; not set: computed from materials and tip radius"
    )
    restitution: Number = number(
        0.9, "-", low=0.0, high=1.0, low_open=True, doc="restitution that is asked of laws with hysteresis"
    )
    friction: Number = number(0.33, "-", **NON_NEGATIVE, doc="coefficient of friction μ")
    slip_speed: Number = number(1e-3, "m/s", **POSITIVE, doc="slip speed v_s below which friction falls to zero")
    young_modulus: Number = number(71.7e9, "Pa", **POSITIVE, doc="Young's modulus of both sides")
    poisson_ratio: Number = number(0.3, "-", low=-1.0, high=0.5, low_open=True, doc="Poisson's ratio of both sides")
    yield_stress: Number = number(
        None, "Pa", **POSITIVE, doc="yield stress of the softer side; not set: yielding is not looked at"
    )
    linear_stiffness: Number = number(1.5e7, "N/m", **POSITIVE, doc="stiffness k of the law kelvin-voigt")
    damping: Number = number(80.0, "N s/m", **NON_NEGATIVE, doc="damping c of the laws kelvin-voigt and adams")
    exponent: Number = number(1.5, "-", low=1.0, doc="exponent n of the law adams")
    ramp_depth: Number = number(1e-6, "m", **POSITIVE, doc="depth d over which the damping of adams sets in")
    onset_length: Number = number(1e-8, "m", **POSITIVE, doc="length over which the smooth contact sets in")
    memory_time: Number = number(
        2e-4, "s", **POSITIVE, doc="time in which the smooth contact's memory follows the approach speed"
    )
    memory: str = choice(
        "event",
        "event",
        "smooth",
        doc="event: the speed of the last touchdown is held; smooth: it follows while out of contact",
    )
    arms: str = choice(
        "moving",
        "moving",
        "published",
        doc="moving: the force acts at the foot; published: where the first contact was",
    )

    def check_together(self) -> None:
        exponent = concrete(self.exponent)
        if exponent is not None and np.any(exponent != HERTZ_EXPONENT):
            shown = f"contact.exponent = {float(exponent.flat[0]):g}"
            if self.law != "adams":
                raise InputError(f"{shown}: only contact.law = 'adams' has an exponent other than {HERTZ_EXPONENT}")
            if self.stiffness is None:
                raise InputError(f"{shown} needs contact.stiffness in N/m^exponent: Hertz's is in N/m^{HERTZ_EXPONENT}")
        if self.memory == "smooth" and LAWS[self.law].jumps:
            raise InputError(
                f"contact.law = {self.law!r}: its force jumps at touchdown; contact.memory must be 'event'"
            )

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        if self.law != "adams" or self.stiffness is None:
            yield inside(self.exponent, low=HERTZ_EXPONENT, high=HERTZ_EXPONENT)
