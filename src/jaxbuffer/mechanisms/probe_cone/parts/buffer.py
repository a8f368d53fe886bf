"""The buffer between the active vehicle and the probe: its numbers, checked when it is made."""

from typing import ClassVar

from ....errors import InputError
from ....fields import NON_NEGATIVE, POSITIVE, Curve, Number, Part, choice, curve, number, on
from .stops import EndStopFields, ReboundStopFields

DAMPER = ("damper_curve", "c_A2", "rebound_factor")  # what the axial damper may have besides c_A


class RealFields(Part):
    """What a real buffer's axial spring and damper have beside stiffness and damping.

    Preload (M171), quadratic damping, another damping on the way out and friction (M172), measured curves (M173).
    """

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
        1e-4, "m", **POSITIVE, needs=on("preload"), doc="stroke s_p over which the preload is reached"
    )
    c_A2: Number = number(None, "N s²/m²", **NON_NEGATIVE, doc="quadratic damping along the cylinder; not set: none")
    rebound_factor: Number = number(
        None,
        "-",
        **POSITIVE,
        needs=on("c_A", "c_A2", "damper_curve"),
        doc="factor ρ of the damper's force on the way out; not set: 1",
    )
    friction: Number = number(None, "N", **NON_NEGATIVE, doc="friction F_f along the cylinder; not set: none")
    friction_speed: Number = number(
        1e-3, "m/s", **POSITIVE, needs=on("friction"), doc="speed v_f below which that friction falls to zero"
    )

    def check_together(self) -> None:
        """Raise `InputError` where a curve is given together with the numbers that it stands for."""
        super().check_together()
        for measured, names in (("spring_curve", ("k_A",)), ("damper_curve", ("c_A", "c_A2"))):
            both = [name for name in names if self.has(name)]
            if self.has(measured) and both:
                raise InputError(
                    f"buffer.{measured} and buffer.{both[0]} are given together; the curve stands for"
                    f" {' and '.join(names)}: keep one of them"
                )


class ProbeBuffer(ReboundStopFields, RealFields, EndStopFields):
    """Springs and dampers, the cylinder between them, and the stops at either end of the buffer's way.

    Damping of the length's rate is M23, of the whole separation's M24, which does not conserve angular momentum. All
    other fields are those of `SpringFields`, `EndStopFields`, `RealFields` and `ReboundStopFields`.
    """

    section: ClassVar[str] = "buffer"
    damping: str = choice(
        "physical",
        "physical",
        "published",
        doc="physical: the rate of the length is damped; published: the whole rate of the separation",
    )

    def check_together(self) -> None:
        """Raise `InputError` where the paper's damping is given together with another damper."""
        super().check_together()
        if self.damping == "published" and (more := [name for name in DAMPER if self.has(name)]):
            raise InputError(
                f'buffer.damping = "published" has the paper\'s damper alone, which buffer.{more[0]} is no part of:'
                ' leave it out, or set damping to "physical"'
            )
