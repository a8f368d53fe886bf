"""The rigid probe against the closed form of a Hertz impact: effective mass 4.103 kg, 931 N, 1.147 ms.

Those figures neglect the masses of probe and cylinder, which add 2 to 3 %; friction and hysteresis are switched off. In
the stiffest case the maxima of contact and buffer force lie within nanoseconds of each other and must both be found.
"""

import pytest

import jaxbuffer as jb


def first_impact(factor=1.0, **changes):
    rigid = jb.rigid_probe()
    stiffer = {f"buffer.{k}": getattr(rigid.buffer, k) * factor for k in ("k_A", "k_T")}
    damped = {f"buffer.{c}": getattr(rigid.buffer, c) * factor**0.5 for c in ("c_A", "c_T")}
    design = jb.replace(rigid, {**stiffer, **damped, **changes})
    impacts = jb.simulate(design, duration=0.01, rtol=1e-6).impacts
    return float(impacts.peak_force[0]), float(impacts.release_time[0])


def test_closed_form():
    peak, duration = first_impact(10.0, **{"contact.friction": 0.0, "contact.restitution": 1.0})
    assert peak == pytest.approx(931.0, rel=0.03)
    assert duration == pytest.approx(1.147e-3, rel=0.025)


def test_stiff_enough():
    assert first_impact()[0] == pytest.approx(first_impact(10.0)[0], rel=5e-3)
