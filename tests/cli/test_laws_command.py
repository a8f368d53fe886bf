"""`jaxbuffer laws`: the comparison as a table, a file and a figure."""

import csv

import pytest
from numpy.testing import assert_allclose

import jaxbuffer as jb
from jaxbuffer.cli.entry import run
from jaxbuffer.contact.laws import LAWS
from jaxbuffer.mechanisms.probe_cone.comparison import ASKED, compare_laws, first_contact
from verification.test_first_impact import closed_form


@pytest.mark.slow
def test_first_contact_has_the_joints_effective_mass():
    mass, speed = first_contact(jb.table2(), jb.Scenario())
    assert_allclose(mass, closed_form(jb.table2(), jb.Scenario())[1], rtol=1e-12)
    assert_allclose(speed, 0.1 * 0.5**0.5, rtol=1e-12)


@pytest.mark.slow
def test_first_contact_in_space_is_the_planar_flank_s_turned_about_the_axis():
    in_space = first_contact(jb.docking3d(), jb.Scenario3D(azimuth=0.7))
    assert_allclose(in_space, first_contact(jb.table2(), jb.Scenario()), rtol=1e-9)


@pytest.mark.slow
def test_defaults_of_the_other_laws_are_as_stiff_and_as_lossy_as_table_2s():
    found = {law.name: law.impact for law in compare_laws(jb.table2()).laws}
    for name in ("kelvin-voigt", "adams"):
        assert abs(found[name].max_penetration / found["lankarani-nikravesh"].max_penetration - 1) < 0.02
        assert abs(found[name].restitution - found["lankarani-nikravesh"].restitution) < 0.02


def test_table_file_and_figure(tmp_path, capsys):
    words = ["laws", "--contact.restitution", "0.5", "--mass", "1", "--speed", "4.4294", "--contact.stiffness", "1.4e8"]
    assert run([*words, "--output", str(tmp_path / "out")]) == 0
    shown = capsys.readouterr().out
    assert "Impact of 1 kg at 4.4294 m/s, restitution 0.5 asked for" in shown
    assert all(name in shown for name in LAWS)
    with (tmp_path / "out" / "laws.csv").open() as file:
        rows = {row["law"]: row for row in csv.DictReader(file)}
    assert list(rows) == list(LAWS)
    assert_allclose(float(rows["hertz"]["peak_force [N]"]), 12.366e3, rtol=1e-4)
    assert_allclose([float(rows["exact"][f"delivered restitution for {e:g} [-]"]) for e in ASKED], ASKED, rtol=1e-12)
    assert (tmp_path / "out" / "laws.png").read_bytes().startswith(b"\x89PNG")
    assert run([*words, "--output", str(tmp_path / "out")]) == 2
    assert "--force overwrites" in capsys.readouterr().err


@pytest.mark.parametrize(("word", "message"), [("--mass=-1", "mass = -1 kg"), ("--speed=0", "speed = 0 m/s")])
def test_bad_impacts_are_refused(word, message, capsys):
    assert run(["laws", word]) == 2
    assert message in capsys.readouterr().err
