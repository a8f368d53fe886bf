"""Every test runs in double precision and with strict rank promotion, and may leave evidence for the report.

Compiled programs, which take most of the time, are kept in one folder for all processes of a test run. Those in memory
are dropped between files where a process holds too much.
"""

import gc
import os
import shutil
import tempfile
from pathlib import Path

import pytest

import jaxbuffer.process

jaxbuffer.process.configure(cache=None)

import jax  # noqa: E402

from evidence import Evidence  # noqa: E402
from jaxbuffer.cache import stored  # noqa: E402
from jaxbuffer.program_files import store_in  # noqa: E402

jax.config.update("jax_numpy_rank_promotion", "raise")

EVIDENCE = Evidence()
PROGRAMS = pytest.StashKey[Path]()
MOST_MEMORY = 3 * 2**30  # bytes that a process may hold at the end of a file


@pytest.fixture(scope="session")
def evidence():
    """Asserts a measured error and remembers it; see `Evidence`."""
    return EVIDENCE


@pytest.fixture(scope="session")
def programs(pytestconfig):
    """The folder of compiled programs."""
    return pytestconfig.stash[PROGRAMS]


@pytest.fixture(autouse=True)
def _programs_kept(programs):
    """Whatever folder the test before has chosen."""
    store_in(programs)


@pytest.fixture(scope="module", autouse=True)
def _memory_freed():
    yield
    resident = int(Path("/proc/self/statm").read_text().split()[1]) * 4096
    if resident > MOST_MEMORY:
        jax.clear_caches()
        for function in gc.get_objects():
            if isinstance(function, stored):
                function.programs.clear()
        gc.collect()


def pytest_addoption(parser):
    parser.addoption("--kills", type=int, default=4, help="how often test_lost_work_kills kills each command")
    parser.addoption("--evidence", type=Path, help="write what tests measured to this JSON file")


def pytest_configure(config):
    given = getattr(config, "workerinput", {}).get("programs")
    config.stash[PROGRAMS] = Path(given or tempfile.mkdtemp(prefix="jaxbuffer-programs-"))
    os.environ["JAXBUFFER_CACHE"] = str(config.stash[PROGRAMS])  # of commands, in this process and others
    jaxbuffer.process.configure()


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node):
    """What pytest-xdist gives each of its processes."""
    node.workerinput["programs"] = str(node.config.stash[PROGRAMS])


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node, error):
    """What pytest-xdist has from each of its processes."""
    EVIDENCE.add(getattr(node, "workeroutput", {}).get("evidence", []))


def pytest_sessionfinish(session):
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["evidence"] = list(EVIDENCE.records.values())
    elif path := session.config.getoption("--evidence"):
        EVIDENCE.write(path)


def pytest_unconfigure(config):
    if not hasattr(config, "workerinput"):
        shutil.rmtree(config.stash[PROGRAMS], ignore_errors=True)
