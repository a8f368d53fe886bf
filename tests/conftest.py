"""Every test runs in double precision and with strict rank promotion, and may leave evidence for the report.

Compiled programs, which take most of the time, are kept in one folder for all processes of a test run. Those in memory
are dropped between files where a process holds too much.

`make test` runs what has none of the markers `slow`, `whole` and `long`, `make test-slow` what is slow or whole and not
long, `make test-long` what is long.
"""

import ctypes
import gc
import os
import shutil
import tempfile
from pathlib import Path

import pytest

import jaxbuffer.cli.quick
import jaxbuffer.programs.process

jaxbuffer.cli.quick.prepare()
jaxbuffer.programs.process.configure()

import jax  # noqa: E402

from evidence import Evidence  # noqa: E402
from jaxbuffer.programs.cache import stored  # noqa: E402
from jaxbuffer.programs.store import store_in  # noqa: E402

jax.config.update("jax_numpy_rank_promotion", "raise")

EVIDENCE = Evidence()
PROGRAMS = pytest.StashKey[Path]()
MOST_MEMORY = 5 * 2**30  # bytes that a process may hold at the end of a file
# Tests here solve whole runs of a mechanism, mostly one of their own: they compile large programs or start processes.
# Each may be quick by itself; all together they are too long for `make test`.
WHOLE = ("cluster/", "mechanisms/", "multibody/test_flexible_", "properties/", "verification/")
# Some tests here take minutes: begun last, one of them would keep one process busy after the other has finished.
FIRST = ("test_guides.py", "test_lost_work_kills.py", "test_lost_work_tank.py")
TESTS = Path(__file__).parent


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


@pytest.fixture
def computed(monkeypatch, tmp_path):
    """The command line without the wait: results are made up, what was asked for is remembered; in an empty folder."""
    from computed import stand_in

    monkeypatch.chdir(tmp_path)
    return stand_in(monkeypatch)


@pytest.fixture
def no_figures(monkeypatch):
    """Commands write small files in place of figures, for tests of what else they write."""
    monkeypatch.setattr(
        "jaxbuffer.output.style.both",
        lambda name, draw: {f"{name}.png": lambda: b"\x89PNG", f"{name}.svg": lambda: b"<svg/>"},
    )


@pytest.fixture(scope="module", autouse=True)
def _memory_freed():
    yield
    resident = int(Path("/proc/self/statm").read_text().split()[1]) * 4096
    if resident > MOST_MEMORY:
        jax.clear_caches()
        gc.unfreeze()  # what is frozen is in no list of objects
        for function in gc.get_objects():
            if isinstance(function, stored):
                function.programs.clear()
        gc.collect()
        # What is freed goes back to the system; else the process would seem to hold too much after every file to come,
        # and compile everything anew in each.
        ctypes.CDLL(None).malloc_trim(0)


def pytest_addoption(parser):
    parser.addoption("--kills", type=int, default=2, help="how often test_lost_work_kills kills each command")
    parser.addoption("--evidence", type=Path, help="write what tests measured to this JSON file")
    parser.addoption("--programs", type=Path, help="use and keep compiled programs of another test run in this folder")


def pytest_configure(config):
    given = getattr(config, "workerinput", {}).get("programs") or config.getoption("--programs")
    config.stash[PROGRAMS] = Path(given or tempfile.mkdtemp(prefix="jaxbuffer-programs-"))
    os.environ["JAXBUFFER_CACHE"] = str(config.stash[PROGRAMS])  # of commands, in this process and others
    jaxbuffer.programs.process.configure()


@pytest.hookimpl(tryfirst=True)  # before tests are selected by their markers
def pytest_collection_modifyitems(items):
    for item in items:
        if not item.path.is_relative_to(TESTS):
            continue
        if item.path.relative_to(TESTS).as_posix().startswith(WHOLE):
            item.add_marker("whole")
    items.sort(key=lambda item: item.path.name not in FIRST)


def pytest_collection_finish():
    """Modules and tests live as long as the process: the collector need not visit them again and again."""
    gc.collect()
    gc.freeze()


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
    if not hasattr(config, "workerinput") and not config.getoption("--programs"):
        shutil.rmtree(config.stash[PROGRAMS], ignore_errors=True)
