"""Whole processes: a short run of `python -m verify.faults`, one compilation for many, a tuning over a scheduler."""

import subprocess
import sys

import numpy as np
import pytest

import jaxbuffer as jb
from verify import faults

CAPTURES = 500
COMPILES = """
import sys
import jaxbuffer as jb
jb.configure(cache=sys.argv[1])
from jaxbuffer.programs import cache as programs
compiled = programs.stored._compiled
def told(*arguments):
    with open(sys.argv[2], "a") as file:
        file.write("compiled\\n")
    return compiled(*arguments)
programs.stored._compiled = told
print(float(jb.simulate(jb.BarDrop(), jb.BarDropScenario(), 0.01).peak_force).hex())
"""


@pytest.fixture(scope="module")
def setup(tmp_path_factory, programs):
    return faults.Setup(tmp_path_factory.mktemp("faults"), programs, faults.words(CAPTURES), 3, 16)


@pytest.mark.slow
def test_kills_cost_no_bit(setup):
    """Of a worker, the scheduler or the driver, at random."""
    assert faults.kills(setup).startswith("3 kills")


@pytest.mark.slow
def test_of_processes_that_need_one_program_one_compiles(tmp_path):
    command = [sys.executable, "-c", COMPILES, str(tmp_path / "cache"), str(tmp_path / "told")]
    both = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    found = {process.communicate(timeout=300)[0] for process in both}
    assert len(found) == 1 and all(process.returncode == 0 for process in both)
    assert len((tmp_path / "told").read_text().splitlines()) == len(list((tmp_path / "cache").glob("*.program")))


@pytest.mark.long
def test_a_tuning_over_a_scheduler_is_the_same(tmp_path):
    problem = jb.Problem(jb.table2(), [jb.Scenario()], [jb.Variable("buffer.k_A", 100.0, 2000.0)])
    here, there = (jb.tune(problem, iterations=2, starts=1, client=client) for client in (None, "local"))
    assert jb.get(here.design, "buffer.k_A") == jb.get(there.design, "buffer.k_A")
    np.testing.assert_array_equal(here.objective, there.objective)
    assert here.records == there.records
