"""A docking as a Functional Mock-up Unit: what it says of itself, and a co-simulation by fmpy."""

import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile

import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

import jaxbuffer as jb
from jaxbuffer.cli.entry import run

# A tool of its own process, as any is: inputs held over steps of 0.05 s, a step back, and what comes out.
TOOL = """
import sys
import fmpy
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

file, folder, cache = sys.argv[1:]
import jaxbuffer as jb
jb.configure(cache=cache)
assert not validate_fmu(file), validate_fmu(file)
described = fmpy.read_model_description(file)
place = {it.name: it.valueReference for it in described.modelVariables}
unit = FMU3Slave(
    guid=described.guid, unzipDirectory=fmpy.extract(file, folder), instanceName="docking",
    modelIdentifier=described.coSimulation.modelIdentifier,
)
unit.instantiate()
unit.enterInitializationMode()
unit.exitInitializationMode()
names = ["run_time", "active.position.x", "active.angle", "passive.velocity.y", "hinge_force", "peak_force"]
of = lambda kind, *wanted: getattr(unit, "get" + kind)([place[name] for name in wanted])
print(*of("Float64", *names), *of("Int32", "outcome"))
step, tried = 0.05, False
for k in range(24):
    unit.setFloat64([place["active.force.x"], place["active.moment"]], [0.3 if k < 4 else 0.0, 0.01 if k < 4 else 0.0])
    before = unit.getFMUState() if k == 2 else None
    unit.doStep(k * step, step)
    if before is not None:  # another load, and back
        first = of("Float64", *names)
        unit.setFMUState(before)
        unit.setFloat64([place["active.force.x"]], [-5.0])
        unit.doStep(k * step, step)
        assert of("Float64", *names) != first
        unit.setFMUState(before)
        unit.setFloat64([place["active.force.x"]], [0.3])
        unit.doStep(k * step, step)
        assert of("Float64", *names) == first
    print(*of("Float64", *names), *of("Int32", "outcome"))
print(*of("String", "outcome_name"))
unit.terminate()
unit.freeInstance()
"""


@pytest.fixture
def unit(tmp_path, monkeypatch):
    """A unit that the command writes."""
    pytest.importorskip("pythonfmu3")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text("[scenario]\napproach_speed = 0.1\n")
    assert run(["export-fmu", "study.toml", "--buffer.k_A", "510", "--output", "docking.fmu"]) == 0
    return tmp_path / "docking.fmu"


def test_a_unit_says_what_goes_in_and_comes_out(unit, capsys):
    with zipfile.ZipFile(unit) as packed:
        described = ET.fromstring(packed.read("modelDescription.xml"))
        assert "k_A = 510.0" in packed.read("resources/design.toml").decode()
    assert described.get("fmiVersion") == "3.0" and described.get("modelName") == "docking"
    variables = {it.get("name"): it for it in described.find("ModelVariables")}
    inputs = [name for name, it in variables.items() if it.get("causality") == "input"]
    loads = ("force.x", "force.y", "moment")
    assert inputs == [f"{body}.{load}" for body in ("active", "passive") for load in loads]
    assert all(variables[name].get("variability") == "discrete" for name in inputs)
    units = {"passive.angle": "rad", "active.velocity.y": "m/s", "lower.contact_force": "N", "stroke": "m"}
    assert {name: variables[name].get("unit") for name in units} == units
    capsys.readouterr()
    assert run(["export-fmu", "study.toml", "--output", "docking.fmu"]) == 2
    assert "docking.fmu exists; --force overwrites" in capsys.readouterr().err
    assert run(["export-fmu", "study.toml", "--output", "my docking.fmu"]) == 2
    assert "give a name of letters" in capsys.readouterr().err
    assert run(["export-fmu", "study.toml"]) == 2
    assert "--output FILE" in capsys.readouterr().err


@pytest.mark.slow
def test_a_co_simulation_is_the_stepper(unit, programs):
    pytest.importorskip("fmpy")
    plant = jb.stepper(jb.replace(jb.table2(), {"buffer.k_A": 510.0}), jb.Scenario(approach_speed=0.1))
    state = plant.start()
    all_seen = [plant.observe(state)]
    for k in range(24):
        loads = plant.loads({"active": (0.3 if k < 4 else 0.0, 0.0)}, {"active": 0.01 if k < 4 else 0.0})
        state, seen = plant.step(state, loads, 0.05)
        all_seen.append(seen)
    command = [sys.executable, "-c", TOOL, str(unit), str(unit.parent / "unpacked"), str(programs)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    *lines, outcome = done.stdout.splitlines()
    wanted = [
        [it.time, *it.position[0, [0, 2]], it.velocity[3, 1], it.values["hinge_force"], it.peak_force, it.code]
        for it in map(lambda seen: jax.tree.map(np.asarray, seen), all_seen)
    ]
    rows = np.array([[float(word) for word in line.split()] for line in lines[-25:]])
    assert_allclose(rows, np.array(wanted, float), rtol=1e-12, atol=1e-15)
    assert outcome == "captured" == seen.outcome.name
