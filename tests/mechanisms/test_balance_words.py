"""A run whose energy is off says first that it cannot be trusted."""

import dataclasses

import numpy as np
import pytest

from made_up import made_up_capture


@pytest.mark.quick
@pytest.mark.parametrize(
    ("energy", "said"), [(1e-6, False), (9e-3, False), (-1.1e6, True), (0.02, True), (np.nan, False)]
)
def test_energy_that_is_off_is_said(energy, said):
    run = made_up_capture()
    run = dataclasses.replace(run, balance=dataclasses.replace(run.balance, energy=np.asarray(energy)))
    assert bool(run.balance.warnings) == said
    assert ("no number of this run can be trusted" in repr(run)) == said
