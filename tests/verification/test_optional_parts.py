"""What holds of the default structure holds with every optional part: no threshold is NaN, energy is kept, no largest
value is below the run's own history, and elasticities are those of differences.

The parts, and how they are drawn, are those of the campaign (`benchmarks.optional_parts`).
"""

import numpy as np
import pytest

import jaxbuffer as jb
from benchmarks.campaign import (
    ANY_PARTS,
    BELOW_HISTORY,
    STUDIES,
    UNBALANCED,
    below_history,
    measured,
    names,
    studies_of,
)
from jaxbuffer.errors import InputError
from jaxbuffer.mechanisms.registry import mechanism_of

PARTS = [(title, part) for title, (_, parts) in ANY_PARTS.items() for part in parts]


def with_part(title, part):
    base, parts = ANY_PARTS[title]
    return STUDIES[base]().with_parts({part: parts[part]})


@pytest.mark.parametrize(("title", "part"), PARTS)
def test_thresholds_and_scales_are_numbers_with_every_optional_part(title, part):
    """Assembling refuses one that is not; that it looks at all is what the next test is for."""
    study = with_part(title, part)
    for design, scenario in study.drawn(2, 0):
        assembled = mechanism_of(design).system(design, scenario, 20.0)
        assert not np.any(np.isnan(np.asarray(assembled.roundoff())))
        assert np.all(np.isfinite(np.asarray(assembled.scales())))


@pytest.mark.quick
def test_a_threshold_that_is_no_number_is_refused(monkeypatch):
    from jaxbuffer.elements import Buffer

    monkeypatch.setattr(Buffer, "stiffness_at_rest", float("nan"))
    design = with_part("docking, any parts", "spring curve").design
    with pytest.raises(InputError, match="roundoff of hinge_force"):
        mechanism_of(design).system(design, jb.Scenario(), 20.0)


def test_a_largest_value_under_a_measured_curve_is_no_less_than_its_own_history():
    """The hinge force of the first of ten such designs was 190.86 N for 216.81 N where a threshold was NaN."""
    study = with_part("docking, any parts", "spring curve")
    for design, scenario in study.drawn(10, 5):
        run = measured(design, scenario, study.duration)
        assert not mechanism_of(design).outcomes(int(run.code)).failed
        short = below_history(run)
        assert np.max(short) < 1e-5, dict(zip(names(design, scenario), short, strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("title", ANY_PARTS)
def test_random_parts_together_keep_energy_and_their_largest_values(title):
    single = len(ANY_PARTS[title][1])
    for k, study in list(enumerate(studies_of(title, single + 2, seed=1)))[single:]:
        for design, scenario in study.drawn(5, k):
            run = measured(design, scenario, study.duration)
            assert not mechanism_of(design).outcomes(int(run.code)).failed, study.parts
            assert abs(float(run.energy)) < UNBALANCED, study.parts
            assert np.max(below_history(run)) <= BELOW_HISTORY, study.parts
