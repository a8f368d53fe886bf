"""Deflection and stress of bars that bend in their first mode, by the tables of beams."""

from types import SimpleNamespace

import jax
import jax.numpy as jnp
import pytest

from jaxbuffer import BarDrop, SliderCrank, replace
from jaxbuffer.mechanisms.bar_drop.assembly import BAR, bar_deflection
from jaxbuffer.mechanisms.slider_crank.sensors import ROD, rod_deflection, rod_stress

FREE_MIDDLE, FREE_END = -1.2157, 2.0  # of a free beam's first mode, ∫ φ² dξ = 1 (Blevins, table 8-1)
CLAMPED_MIDDLE = 1.5882  # of a clamped beam's: φ'' of the free one over β²
BETA = 4.7300407
BENT = 1e-4  # m


def bent(body, modes):
    """The motion of bodies of which one is bent by `BENT` in its first mode."""
    modal = {body: (jnp.zeros(modes).at[0].set(BENT), jnp.zeros(modes))}
    return SimpleNamespace(modal=lambda k: modal[k])


@pytest.mark.quick
def test_the_bars_middle_against_its_ends():
    bar = replace(BarDrop(), {"bar.modes": 30}).bar
    found = jax.jit(lambda: bar_deflection(bent(BAR, 30), bar.middle_off_ends))()
    assert float(found) == pytest.approx(BENT * (FREE_END - FREE_MIDDLE), rel=1e-4)


@pytest.mark.quick
def test_the_rods_middle_against_its_ends_and_its_stress():
    """E h/2 w'': the depth h is that of the section."""
    design = replace(SliderCrank(), {"rod.depth": 0.012, "rod.modes": 30})

    @jax.jit
    def of_the_rod():
        rod, kin = design.rod.bent, bent(ROD, 30)
        return rod_deflection(kin, rod), rod_stress(kin, rod)

    deflection, stress = of_the_rod()
    length, young = float(design.rod.length), float(design.rod.young_modulus)
    assert float(deflection) == pytest.approx(BENT * (FREE_END - FREE_MIDDLE), rel=1e-4)
    expected = young * 0.006 * BETA**2 * CLAMPED_MIDDLE * BENT / length**2
    assert float(stress) == pytest.approx(expected, rel=1e-3)  # 30 modes come that near
