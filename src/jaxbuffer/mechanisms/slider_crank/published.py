"""The slider-crank of *Impact Dynamics Analysis of Mobile Mechanical Systems* (2021) with a geometry of ours."""

from ..._types import Scalar
from .design import Crank, CrankDrive, SliderCrank
from .pins import ADAMS, PistonPin

MM = 1e-3  # m


def published_slider_crank(exponent: float = 0.1, stiffness: Scalar = 1e4) -> SliderCrank:
    """Return the slider-crank of clearance 1.1 mm in the piston pin, IMPACT on each component, torque 10 kN m (1 - ω/10
    rad/s).

    The paper prints no geometry: here it is the default one, whose lengths and masses are an engine's, with a crank of
    5 kg and 0.01 kg m², so that the drive has brought it to speed after some 10 µs. Start it at rest.

    **Arguments:** ``exponent``: e [-], printed 0.01, 0.1 and 0.2; ``stiffness``: k [N/mm^e], printed 1e4 and 1e5.

    **Example:**

    >>> run = jb.simulate(jb.published_slider_crank(), jb.SliderCrankScenario(crank_speed=0.0), duration=0.01)
    >>> print(f"{int(run.impact_count)} impact of {float(run.peak_force):.0f} N in 10 ms")
    1 impact of 4985 N in 10 ms
    """
    pin = PistonPin(
        contact="components",
        clearance=1.1 * MM,
        law=ADAMS,
        stiffness=stiffness * MM**-exponent,
        exponent=exponent,
        viscous=10.0 / MM,
        ramp_depth=1e-3 * MM,
    )
    drive = CrankDrive(kind="torque", torque=1e7 * MM, no_load_speed=10.0)
    return SliderCrank(crank=Crank(mass=5.0, inertia=0.01), drive=drive, piston_pin=pin)
