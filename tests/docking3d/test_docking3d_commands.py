"""Commands on studies of a docking in space, what they compute made up, and what they refuse."""

import pytest

from jaxbuffer.cli.entry import run as command

STUDY = """kind = "docking3d"
[scenario]
start = "free"
[latch]
stiffness = 300
[problem.grid]
offset_y = ["-1 cm", "1 cm"]
active_pitch = ["0 deg", "2 deg"]
[problem.variables]
buffer.k_A = [100, 2000]
active.roll_inertia = [0.1, 0.8, "linear"]
[problem.constraints]
stroke = "25 mm"
held = true
"""


@pytest.fixture
def study(tmp_path, monkeypatch):
    """A study in an empty folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path / "study.toml"


def test_check_says_what_a_tuning_in_space_would_do(study, capsys):
    assert command(["check", "study.toml"]) == 0
    shown = capsys.readouterr().out
    assert "4: 0.1 m/s, offset y 10 mm, active pitch 2 deg" in shown
    assert "active.roll_inertia in [0.1, 0.8] kg m², linear, from 0.2 kg m²" in shown
    assert "every load case must end held" in shown and "tune study.toml         2 variables over 4 scenarios" in shown


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ("[active]\nroll_inertia = 0.9", "active.roll_inertia = 0.9 kg m² is out of range; allowed: (0, 0.89] kg m²"),
        ("[passive]\nroll_inertia = 1.1", "passive.roll_inertia = 1.1 kg m² is out of range; allowed: (0, 1.0412] kg"),
        ('[scenario]\npassive_pitch = "100 deg"', "passive_pitch = 100 deg is out of range; allowed: (-90, 90) deg"),
        (
            '[scenario]\npassive_yaw = "80 deg"',
            "turn the probe by 1.39626 rad from the cone's axis; allowed: [0, 0.785",
        ),
        (
            '[scenario]\nstart = "free"\nactive_yaw = "60 deg"\npassive_yaw = "-60 deg"',
            "turn the probe by 2.0944 rad from the cone's axis; allowed: [0, 1.5708) rad; the probe must point towards",
        ),
        ('[problem.grid]\npassive_yaw = ["0 deg", "80 deg"]', "scenario 2 (0.1 m/s, passive yaw 80 deg)"),
        ("[problem.variables]\nactive.inertia = [0.05, 1.0]", "active.roll_inertia = 0.2 kg m² is out of range"),
        ("[sweep]\nactive.roll_inertia = [0.2, 1.2]", "active.roll_inertia = 1.2 kg m² is out of range"),
    ],
)
def test_what_no_docking_in_space_has_is_bad_input(study, capsys, section, message):
    study.write_text(f'kind = "docking3d"\n{section}\n')
    assert command(["check", "study.toml"]) == 2
    assert message in capsys.readouterr().err


def test_an_offset_outside_the_cone_is_said_and_may_be_run(study, capsys):
    """As in the plane: a sweep over offsets has runs that miss, and a lateral speed may lead back to the cone."""
    study.write_text('kind = "docking3d"\n[scenario]\nstart = "free"\noffset_z = "20 cm"\n')
    assert command(["check", "study.toml"]) == 0
    shown = capsys.readouterr().out
    assert "200 mm off the axis, beyond the rim at 66.97 mm" in shown and "scenario.offset_z is 200 mm" in shown
