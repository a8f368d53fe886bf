"""A capture under a law that starts with a jump: the energies balance, and the law is the one asked for."""

import numpy as np
import pytest

from jaxbuffer import replace, simulate, table2
from jaxbuffer.contact.laws import free_impact
from jaxbuffer.mechanisms.probe_cone.assembly import tip_on_flanks
from jaxbuffer.mechanisms.probe_cone.comparison import first_contact
from jaxbuffer.mechanisms.probe_cone.design import Scenario


@pytest.mark.long
def test_energy_and_first_impact():
    """The first impact is two free bodies' but for the buffer's softness: its peak within 1.5 % of the law's own."""
    design = replace(table2(), {"contact.law": "kelvin-voigt", "contact.friction": 0.0})
    capture = simulate(design, duration=0.2)
    assert int(capture.impact_count) > 3
    assert abs(float(capture.balance.energy)) < 1e-6
    assert float(capture.energy.hysteresis) > 0.0
    law, (mass, speed) = tip_on_flanks(design).law, first_contact(design, Scenario())
    np.testing.assert_allclose(capture.impacts.peak_force[0], free_impact(law, mass, speed).peak_force, rtol=0.015)
