"""The bodies of the docking in space: the roll inertia that cylinder and probe share."""

import pytest

from jaxbuffer import docking3d, replace
from jaxbuffer.mechanisms.docking3d.bodies import assemble_system
from jaxbuffer.mechanisms.probe_cone.bodies import B, P, probe_masses


@pytest.mark.parametrize("free_tip", [False, True], ids=["welded tip", "free tip"])
def test_cylinder_and_probe_have_the_probes_roll_inertia_together(free_tip):
    design = replace(docking3d(), {"probe.free_tip": free_tip})
    system = assemble_system(design, probe_masses(design), 20.0)
    roll = 0.5 * design.probe.rod_mass * 0.009**2 + (0.0 if free_tip else 0.4 * design.probe.tip_mass * 0.015**2)
    assert system.bodies[B].inertia[0] + system.bodies[P].inertia[0] == pytest.approx(roll)
