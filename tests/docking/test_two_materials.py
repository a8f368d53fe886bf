"""A tip and a cone of two materials, against Hertz's formulas written out by hand."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import jaxbuffer as jb
from jaxbuffer.contact.laws import laws_with
from jaxbuffer.fields import get
from jaxbuffer.mechanisms.probe_cone.assembly import tip_on_flanks
from jaxbuffer.mechanisms.probe_cone.law_validity import pressure, validity
from jaxbuffer.study.design_toml import design_toml
from jaxbuffer.study.load import load

STEEL_ON_TITANIUM = {
    "contact.young_modulus": 207e9,
    "contact.poisson_ratio": 0.29,
    "cone.young_modulus": 114e9,
    "cone.poisson_ratio": 0.34,
}
SIGMA = (1.0 - 0.29**2) / 207e9 + (1.0 - 0.34**2) / 114e9  # 1/E*


@pytest.mark.parametrize("law", laws_with("stiffness")())
def test_every_law_with_a_stiffness_takes_both_materials(law):
    pair = tip_on_flanks(jb.replace(jb.table2(), STEEL_ON_TITANIUM | {"contact.law": law}))
    expected = 4.0 / 3.0 * np.sqrt(0.015) / SIGMA
    assert_allclose(pair.law.stiffness, expected, rtol=1e-14)
    assert_allclose(pair.law.elastic(1e-5), expected * 1e-5**1.5, rtol=1e-13)


def test_one_number_sets_both():
    """To the bit, so that no run of one material moves."""
    both = {"contact.young_modulus": 114e9, "contact.poisson_ratio": 0.34}
    one = jb.replace(jb.table2(), both)
    assert (one.cone.young_modulus, one.cone.poisson_ratio) == (None, None)
    written = 4.0 * 0.015**0.5 / (3.0 * ((1.0 - 0.34**2) / 114e9 + (1.0 - 0.34**2) / 114e9))
    assert float(one.contact_stiffness) == written
    same = jb.replace(one, {"cone.young_modulus": 114e9, "cone.poisson_ratio": 0.34})
    assert float(same.contact_stiffness) == written


def test_a_cone_may_have_one_of_both_numbers():
    stiffer = jb.replace(jb.table2(), {"cone.young_modulus": 207e9})
    sigma = (1.0 - 0.3**2) * (1.0 / 71.7e9 + 1.0 / 207e9)
    assert_allclose(stiffer.contact_stiffness, 4.0 / 3.0 * np.sqrt(0.015) / sigma, rtol=1e-14)


def test_a_stiffness_that_is_given_stands_for_both():
    given = jb.replace(jb.table2(), STEEL_ON_TITANIUM | {"contact.stiffness": 1e9})
    assert given.contact_stiffness == 1e9


def test_pressure_and_yield():
    """p = 3 F/(2 π a²) with a³ = 3 F R/(4 E*); of both Poisson's ratios the smaller one yields first."""
    design = jb.replace(jb.table2(), STEEL_ON_TITANIUM | {"contact.yield_stress": 880e6})
    a = (3.0 * 250.0 * 0.015 * SIGMA / 4.0) ** (1.0 / 3.0)
    largest = 3.0 * 250.0 / (2.0 * np.pi * a**2)
    assert_allclose(pressure(design, 250.0), largest, rtol=1e-12)
    expected = largest / (1.295 * np.exp(0.736 * 0.29) * 880e6)
    assert_allclose(validity(design, np.asarray(1e-5), np.asarray(250.0)).pressure, expected, rtol=1e-12)


def test_a_design_file_keeps_both(tmp_path):
    design = jb.replace(jb.table2(), STEEL_ON_TITANIUM)
    (tmp_path / "design.toml").write_text(design_toml(design))
    read = load(tmp_path / "design.toml").design
    assert [get(read, path) for path in STEEL_ON_TITANIUM] == list(STEEL_ON_TITANIUM.values())


@pytest.mark.long
def test_slopes_by_both_moduli_are_those_of_differences(evidence):
    """Of the peak force, against central differences of tight solves."""
    design, wrt = jb.replace(jb.table2(), STEEL_ON_TITANIUM), tuple(STEEL_ON_TITANIUM)
    found = jb.sensitivity(design, wrt=wrt, quantities=("peak_force",), rtol=1e-9, duration=0.05, certify="none")
    for k, path in enumerate(wrt):
        step = 1e-3 * STEEL_ON_TITANIUM[path]

        def peak(by, path=path, step=step):
            changed = jb.replace(design, {path: STEEL_ON_TITANIUM[path] + by * step})
            return float(jb.simulate(changed, duration=0.05, rtol=1e-11).peak_force)

        slope = (peak(1.0) - peak(-1.0)) / (2.0 * step)
        off = abs(float(found.gradients[0, k]) / slope - 1.0)
        evidence("Gradients", f"two materials: peak force by {path}", off, 1e-5, "central differences of tight solves")
