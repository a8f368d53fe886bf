"""The buffer between the active vehicle and the probe: its numbers, checked when it is made."""

from collections.abc import Iterator
from typing import ClassVar

import numpy as np
from jaxtyping import Array, Bool

from ..._types import Scalar
from ...errors import InputError, check_entries, concrete, inside
from ...fields import NON_NEGATIVE, POSITIVE, Curve, Number, Part, choice, curve, number, on

STOPS = {"stop": "an end stop", "rebound": "a rebound stop"}
DAMPER = ("damper_curve", "c_A2", "rebound_factor")  # what the axial damper may have besides c_A


class ProbeBuffer(Part):
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
    - ``stop_thickness`` h [m]: of an end stop of rubber, which stiffens from k_s on (M183). None: it is linear.
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
    stop_damping: Number = number(
        0.0, "N s/m", **NON_NEGATIVE, needs=on("stop_stiffness"), doc="damping c_s of the end stop"
    )
    stop_thickness: Number = number(
        None, "m", **POSITIVE, needs=on("stop_stiffness"), doc="thickness h of an end stop of rubber; not set: linear"
    )
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
    preload_length: Number = number(
        1e-4, "m", **POSITIVE, needs=on("preload"), doc="stroke over which the preload is reached"
    )
    c_A2: Number = number(None, "N s²/m²", **NON_NEGATIVE, doc="quadratic damping along the cylinder; not set: none")
    rebound_factor: Number = number(
        None,
        "-",
        **POSITIVE,
        needs=on("c_A", "c_A2", "damper_curve"),
        doc="factor of the damper's force on the way out; not set: 1",
    )
    friction: Number = number(None, "N", **NON_NEGATIVE, doc="friction F_f along the cylinder; not set: none")
    friction_speed: Number = number(
        1e-3, "m/s", **POSITIVE, needs=on("friction"), doc="speed below which that friction falls to zero"
    )
    rebound_stiffness: Number = number(
        None, "N/m", **POSITIVE, doc="stiffness k_r of a stop beyond the free length; not set: none"
    )
    rebound_damping: Number = number(
        0.0, "N s/m", **NON_NEGATIVE, needs=on("rebound_stiffness"), doc="damping c_r of the rebound stop"
    )
    rebound_gap: Number = number(
        5e-4, "m", **POSITIVE, needs=on("rebound_stiffness"), doc="way beyond the free length at which that stop begins"
    )
    damping: str = choice(
        "physical",
        "physical",
        "published",
        doc="physical: the rate of the length is damped; published: the whole rate of the separation",
    )

    def check_together(self) -> None:
        if self.has("max_stroke"):
            above = "; it ends where the spring's ends meet, at buffer.free_length"
            length = self.free_length
            check_entries("buffer.max_stroke", self.max_stroke, "m", 0.0, length, too_high=above, high_open=False)
        for stop, name in STOPS.items():
            damping = concrete(getattr(self, f"{stop}_damping"))
            if not self.has(f"{stop}_stiffness") and damping is not None and np.any(damping != 0.0):
                shown = f"buffer.{stop}_damping = {float(damping.flat[np.argmax(damping)]):g} N s/m"
                raise InputError(f"{shown} needs {name}: give buffer.{stop}_stiffness [N/m] too")
        self._check_curves()

    def _check_curves(self) -> None:
        """Raise `InputError` where a curve is given together with the numbers that it stands for, or with the paper's
        damping."""
        for measured, names in (("spring_curve", ("k_A",)), ("damper_curve", ("c_A", "c_A2"))):
            both = [name for name in names if self.has(name)]
            if self.has(measured) and both:
                raise InputError(
                    f"buffer.{measured} and buffer.{both[0]} are given together; the curve stands for"
                    f" {' and '.join(names)}: keep one of them"
                )
        if self.damping == "published" and (more := [name for name in DAMPER if self.has(name)]):
            raise InputError(
                f'buffer.damping = "published" has the paper\'s damper alone, which buffer.{more[0]} is no part of:'
                ' leave it out, or set damping to "physical"'
            )

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        if self.has("max_stroke"):
            yield inside(self.max_stroke, high=self.free_length, **POSITIVE)
        for stop in STOPS:
            if not self.has(f"{stop}_stiffness"):
                # Without a stop its damping must be zero, as `check_together` has it.
                yield inside(getattr(self, f"{stop}_damping"), low=0.0, high=0.0)

    @property
    def end(self) -> Scalar:
        """Return the stroke at which the buffer is at its end or its end stop, if there is one, begins to push [m]
        (M28)."""
        return self.max_stroke if self.has("max_stroke") else self.free_length

    @property
    def longest_stroke(self) -> Scalar:
        """Return the stroke that ends a run as "bottomed" [m] (M66): with an end stop that is where the spring's ends
        meet."""
        return self.free_length if self.has("stop_stiffness") else self.end
