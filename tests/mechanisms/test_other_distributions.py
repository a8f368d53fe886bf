"""A mechanism of another distribution is known by its entry point, to Python and to every command."""

import sys

import pytest

import jaxbuffer as jb
from jaxbuffer.cli.entry import run
from jaxbuffer.mechanisms import all_mechanisms, mechanism_named
from jaxbuffer.mechanisms.registry import _BY_DESIGN

MODULE = '''
"""The bar drop under another name: what a package of its own would hold."""

import dataclasses

from jaxbuffer.fields import Part
from jaxbuffer.mechanisms.bar_drop import BarDrop, BarDropScenario
from jaxbuffer.mechanisms.registry import mechanism_of, register


class Chime(BarDrop):
    """A bar that strikes."""


class ChimeScenario(BarDropScenario):
    """From where it falls."""


register(dataclasses.replace(mechanism_of(BarDrop()), name="chime", design=Chime, scenario=ChimeScenario))
'''


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Return a function that installs a distribution with one module and its entry point, as pip would leave it."""

    def install(name, source):
        about = tmp_path / f"{name}-1.0.dist-info"
        about.mkdir()
        (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}-maker\nVersion: 1.0\n")
        (about / "entry_points.txt").write_text(f"[jaxbuffer.mechanisms]\n{name} = {name}_mechanism\n")
        (tmp_path / f"{name}_mechanism.py").write_text(source)

    all_mechanisms()  # modules register as they are imported, which happens once
    monkeypatch.syspath_prepend(tmp_path)
    before = dict(_BY_DESIGN)
    yield install
    _BY_DESIGN.clear()
    _BY_DESIGN.update(before)
    for module in [name for name in sys.modules if name.endswith("_mechanism")]:
        del sys.modules[module]


def test_a_mechanism_of_another_distribution(installed, tmp_path, monkeypatch, capsys):
    """Its runs are those of the mechanism that it copies."""
    installed("chime", MODULE)
    assert [mechanism.name for mechanism in all_mechanisms()][4:] == ["chime", "tank_drop"]
    chime = mechanism_named("chime")
    force, same = (float(jb.simulate(design).peak_force) for design in (chime.design(), jb.BarDrop()))
    assert force == same
    monkeypatch.chdir(tmp_path)
    (tmp_path / "chime.toml").write_text('kind = "chime"\n[scenario]\nheight = "100 mm"\n')
    assert run(["simulate", "chime.toml", "--trust", "off"]) == 0
    assert "from 100 mm" in capsys.readouterr().out


@pytest.mark.quick
def test_the_tank_comes_in_by_the_same_door():
    assert mechanism_named("tank_drop").design is jb.TankDrop


def test_a_package_that_cannot_be_imported_is_named(installed, tmp_path, monkeypatch, capsys):
    """It stops what asks for it, and nothing else."""
    installed("broken", "import no_such_module\n")
    assert mechanism_named("probe_cone").design is jb.Design
    with pytest.warns(RuntimeWarning, match="kind = 'broken': the package broken-maker cannot be imported"):
        assert "broken" not in [mechanism.name for mechanism in all_mechanisms()]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "broken.toml").write_text('kind = "broken"\n')
    assert run(["simulate", "broken.toml"]) == 2
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert (
        "the package broken-maker cannot be imported (ModuleNotFoundError: No module named 'no_such_module')" in error
    )
