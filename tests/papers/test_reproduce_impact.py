"""`jaxbuffer reproduce impact`: the printed data, verdicts by hand-made rows, what a fixed step sees."""

import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.cli.entry import run as command
from jaxbuffer.fields import replace
from jaxbuffer.mechanisms.bar_drop import BarDrop, BarDropScenario
from jaxbuffer.output.style import png
from jaxbuffer.papers import PAPERS, paper_named
from jaxbuffer.papers.claims import NO, PARTLY, YES
from jaxbuffer.papers.impact import element_studies, elements
from jaxbuffer.papers.impact.bar_claims import CLAIMS
from jaxbuffer.papers.impact.bar_rows import harmonics, sampled_at
from jaxbuffer.papers.impact.bar_studies import STUDIES
from jaxbuffer.papers.impact.element_studies import pressure
from jaxbuffer.papers.impact.fixed_steps import components, peaks
from jaxbuffer.papers.study import run

BY_NAME = {study.name: study for study in STUDIES}


def claim(start):
    (found,) = [claim for claim in CLAIMS if claim.claim.startswith(start)]
    return found


def test_every_paper_says_what_the_command_needs():
    for name in PAPERS:
        paper = paper_named(name)
        assert paper.name == name and paper.studies and paper.note
        assert len({study.name for study in paper.studies}) == len(paper.studies)
        assert all(set(part.shown) <= set(part.columns) for part in paper.parts)


def test_the_printed_values_are_studied():
    """k = 48 049 N/mm^2.2, e = 2.2, d = 0.01 mm, c = 1 and 6 N s/mm, bar 240 x 4 mm, plate 300 x 100 x 6 mm, 194 mm."""
    for study in STUDIES:
        for case in study.cases:
            d = case.design
            assert float(d.impact.damping) == 1e3 * case.value or study.name.startswith("friction")
            assert float(d.impact.stiffness) == pytest.approx(48_049.0 * 1000.0**2.2)
            assert [float(x) for x in (d.impact.exponent, d.impact.ramp_depth)] == [2.2, 1e-5]
            assert [float(x) for x in (d.bar.length, d.bar.diameter)] == [0.24, 0.004]
            assert [float(x) for x in (d.plate.length, d.plate.width, d.plate.thickness)] == [0.3, 0.1, 0.006]
    for name in ("drop", "friction", "friction_rigid"):
        assert {float(case.scenario.height) for case in BY_NAME[name].cases} == {0.194}
    assert [case.value for case in BY_NAME["drop"].cases] == [0.0, 1.0, 6.0]
    assert [float(case.design.impact.friction) for case in BY_NAME["friction"].cases] == [0.0, 0.3, 1.0, 10.0]
    assert float(BY_NAME["speed"].cases[0].scenario.height) == pytest.approx(1.325**2 / (3 * 9.81))


@pytest.mark.parametrize(("springs", "verdict"), [((244.5, 5.0), PARTLY), ((300.0, 5.0), NO), ((300.0, 251.0), YES)])
def test_the_analytical_force(springs, verdict):
    rows = tuple({"spring_peak": spring, "peak_force": 840.0} for spring in springs)
    assert claim("The spring's part reaches").judge({"speed": rows}).verdict == verdict


@pytest.mark.parametrize(("six", "verdict"), [(20.0, YES), (29.9, NO)])
def test_a_displacement_is_less_if_it_is_by_a_hundredth(six, verdict):
    rows = tuple({"plate_deflection": 1e-6 * bent} for bent in (60.0, 30.0, six))
    assert claim("More damping, less").judge({"plate": rows, "bodies": rows}).verdict == verdict


@pytest.mark.parametrize(
    ("none", "rough", "verdict"), [(381.0, 827.0, PARTLY), (433.0, 915.0, YES), (550.0, 520.0, NO)]
)
def test_a_rough_contact_has_the_printed_ratio_and_the_printed_forces(none, rough, verdict):
    rows = ({"peak_force": none}, {"peak_force": rough})
    assert claim("A rough contact").judge({"friction": rows, "friction_rigid": rows}).verdict == verdict


def test_equation_15_gives_another_stiffness():
    """4/3 E* √R with E* = E/2(1 - ν²), R = 2 mm: 214 463 N/mm^1.5."""
    said = claim("k = 48 049").judge({})
    assert f"{2.0 / 3.0 * 207e3 / 0.91 * 2.0**0.5:.6g}" in said.finding and said.verdict == NO


def test_the_damping_of_the_printed_step():
    """0 at the touch, half of c at half of the depth d, c from there; as printed 2 c, 1.5 c, c."""
    design, depths = BarDrop(), np.array([1e-12, 5e-6, 1e-5, 2e-5])
    for printed, shares in ((False, (0.0, 0.5, 1.0, 1.0)), (True, (2.0, 1.5, 1.0, 1.0))):
        spring, damper = components(design, depths, 1.0, printed)
        np.testing.assert_allclose(damper, 1000.0 * np.array(shares), atol=1e-6)
    np.testing.assert_allclose(spring, 48_049.0 * (1e3 * depths) ** 2.2, rtol=1e-12)


def test_backward_differences_converge_to_the_force_of_an_independent_program():
    """550.2013 N without damper; steps of 1e-4 s compute half of it at most."""
    design = replace(BarDrop(), {"impact.damping": 0.0})
    np.testing.assert_allclose(peaks(design, BarDropScenario(), 1e-6), 550.2013, rtol=1e-3)
    assert peaks(design, BarDropScenario(), 1e-4).max() < 0.51 * 550.2


def test_the_contact_pressure_is_that_of_hertz():
    """p₀ = 3F/(2πa²), a³ = 3FR/(4E*)."""
    modulus = 207e9 / 1.82
    radius = (3.0 * 100.0 * 2e-3 / (4.0 * modulus)) ** (1.0 / 3.0)
    assert pressure(BarDrop(), 100.0) == pytest.approx(150.0 / (np.pi * radius**2))


@pytest.mark.slow
def test_elements_vibrate_as_bars():
    """Lowest frequencies of the bar on its hinge and of the plate on simple supports, in closed form."""
    system, *_ = elements._assembled(BarDrop(), BarDropScenario(), 60)
    free = np.flatnonzero(np.asarray(system.inverse_mass).ravel())
    stiffness = np.zeros((system.inverse_mass.size,) * 2)
    for part in system.elements:
        corners = part.quads.incidence.corners
        places = np.stack([2 * corners, 2 * corners + 1], axis=2).reshape(len(corners), 8)
        for rows, one in zip(places, np.asarray(part.stiffness(jnp.zeros_like(system.positions))), strict=True):
            stiffness[np.ix_(rows, rows)] += one
    root = np.sqrt(np.asarray(system.inverse_mass).ravel()[free])
    squared = np.linalg.eigvalsh(root[:, None] * stiffness[np.ix_(free, free)] * root)
    speed = np.sqrt(207e9 / 7850.0)
    plate = (np.pi / 0.3) ** 2 * speed * 0.006 / np.sqrt(12.0) * np.array([1.0, 4.0])
    bar = (np.array([3.926602, 7.068583]) / 0.24) ** 2 * speed * 0.004 / 4.0
    np.testing.assert_allclose(np.sqrt(squared[1:5]), np.sort([*plate, *bar]), rtol=5e-3)  # the first turns the bar


@pytest.mark.long
def test_elements_give_nearly_the_first_peak_of_modes():
    """92.935 N: eight modes of bar and plate without damping and a linear spring, by `mechanisms.bar_drop_peer`; the
    mesh has more modes. No energy is made or lost."""
    case = element_studies.STUDIES[0].cases[0]
    row = element_studies.row(case, element_studies.solve(case))
    assert row["first_peak"] == pytest.approx(92.935, rel=0.08)
    assert float(row["energy_error"]) < 1e-6


def test_what_a_fixed_step_sees_of_a_triangle():
    """A triangle of 10 µs seen at 100 µs: nine of ten grids see nothing, none more than its height."""
    sampled = sampled_at(1e-4, np.array([0.0, 1e-3, 1.005e-3, 1.01e-3, 2e-3]), np.array([0.0, 0.0, 7.0, 0.0, 0.0]))
    assert np.mean(sampled > 0.0) == pytest.approx(0.1, abs=0.01)
    assert 6.5 < sampled.max() <= 7.0
    assert harmonics(np.linspace(0.0, 3e-3, 301), np.sin(np.linspace(0.0, 6.0 * np.pi, 301)).clip(0.0)) == 3


@pytest.mark.slow
def test_the_undamped_force_at_the_printed_speed():
    """244.5 N, from an independent program; the impact without weight that it solves is 0.1 % lower."""
    part, *_ = paper_named("impact").parts
    (studied,) = run(part, (BY_NAME["speed"],))
    assert float(studied.rows[0]["speed"]) == pytest.approx(1.325, rel=1e-9)
    assert float(studied.rows[0]["peak_force"]) == pytest.approx(244.5, rel=1.5e-3)
    assert float(studied.rows[1]["peak_force"]) == pytest.approx(840.0, rel=1e-3)
    assert png(part.figure(studied)).startswith(b"\x89PNG")


def test_an_unknown_paper_is_refused(tmp_path, capsys):
    assert command(["reproduce", "impacts", "--output", str(tmp_path)]) == 2
    assert "choose one of docking, impact, load, tank; did you mean impact?" in capsys.readouterr().err
