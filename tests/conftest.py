"""Every test runs in double precision and with strict rank promotion, and may leave evidence for the report.

Compiled programs, which take most of the time, are kept in one folder for all processes of a test run. Those in memory
are dropped where a process holds too much, and read from there again. A run ends with what it took.

`make test` runs what has none of the markers `slow`, `whole` and `long`, `make test-slow` what is slow or whole and not
long, `make test-long` what is long. `WHOLE` names the files whose tests are whole unless they are marked `quick`.
"""

import gc
import os
import resource
import shutil
import tempfile
from pathlib import Path

import pytest

import jaxbuffer as jb
import jaxbuffer.cli.quick
import jaxbuffer.programs.process

jaxbuffer.cli.quick.prepare()
jaxbuffer.programs.process.configure(cache=None)  # the run's own folder, once it is known

import jax  # noqa: E402

from evidence import Evidence  # noqa: E402
from jaxbuffer.programs.cache import drop_programs  # noqa: E402
from jaxbuffer.programs.store import store_in  # noqa: E402

jax.config.update("jax_numpy_rank_promotion", "raise")

EVIDENCE = Evidence()
PROGRAMS = pytest.StashKey[Path]()
WITHOUT_QUICK = pytest.StashKey[set[str]]()  # files, of those collected, that `make test` leaves out as a whole
# Bytes that a process may hold: at the end of a file, whose tests share programs, and of any test.
MOST_AFTER_A_FILE, MOST_AFTER_A_TEST = 1.1e9, 1.2e9
RESOURCES: list[tuple[float, float]] = []  # processor time [s] and largest size [bytes] of each process
# Tests here solve whole runs of a mechanism, mostly one of their own: they compile large programs or start processes.
# Each may be quick by itself; all together they are too long for `make test`, which takes those marked `quick`: of each
# claim one that needs no run, or a run that other tests compile.
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


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item, nextitem):
    """Fixtures of the test, and of the file where it is the last, have ended."""
    last = nextitem is None or nextitem.path != item.path
    most = MOST_AFTER_A_FILE if last else MOST_AFTER_A_TEST
    # Large programs are read from disk again; the many single operations would be compiled again, so they go last.
    for drop in (_drop_programs, jb.clear_caches):
        if _resident() > most:
            drop()


def _resident():
    """Size of this process [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


def _drop_programs():
    """Drop our programs from memory; JAX's caches stay."""
    drop_programs()
    gc.collect()
    jaxbuffer.programs.process.trim()


def pytest_addoption(parser):
    parser.addoption("--kills", type=int, default=2, help="how often test_lost_work_kills kills each command")
    parser.addoption("--evidence", type=Path, help="write what tests measured to this JSON file")
    parser.addoption("--programs", type=Path, help="use and keep compiled programs of another test run in this folder")


def pytest_configure(config):
    given = getattr(config, "workerinput", {}).get("programs") or config.getoption("--programs")
    config.stash[PROGRAMS] = Path(given or tempfile.mkdtemp(prefix="jaxbuffer-programs-"))
    os.environ["JAXBUFFER_CACHE"] = str(config.stash[PROGRAMS])  # of commands, in this process and others
    jaxbuffer.programs.process.configure(cache=config.stash[PROGRAMS])


@pytest.hookimpl(tryfirst=True)  # before tests are selected by their markers
def pytest_collection_modifyitems(config, items):
    quick, every = set(), set()
    for item in items:
        if not item.path.is_relative_to(TESTS):
            continue
        if item.path.relative_to(TESTS).as_posix().startswith(WHOLE) and not item.get_closest_marker("quick"):
            item.add_marker("whole")
        every.add(name := item.path.relative_to(TESTS).as_posix())
        if not any(map(item.get_closest_marker, ("slow", "whole", "long"))):
            quick.add(name)
    config.stash[WITHOUT_QUICK] = every - quick
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
    output = getattr(node, "workeroutput", {})
    EVIDENCE.add(output.get("evidence", []))
    RESOURCES.extend(map(tuple, output.get("resources", [])))


def resources():
    """Processor time [s] and largest size [bytes] of this process with those that it has started."""
    each = [resource.getrusage(whose) for whose in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(it.ru_utime + it.ru_stime for it in each), max(1024.0 * it.ru_maxrss for it in each)


def pytest_terminal_summary(terminalreporter):
    seconds, sizes = zip(*(RESOURCES or [resources()]), strict=True)
    processes = f"{len(seconds)} process{'es' if len(seconds) > 1 else ''}"
    terminalreporter.write_line(
        f"{sum(seconds):.0f} s of processor in {processes}, the largest {max(sizes) / 1e9:.2f} GB"
    )


def pytest_sessionfinish(session):
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["evidence"] = list(EVIDENCE.records.values())
        session.config.workeroutput["resources"] = [resources()]
    elif path := session.config.getoption("--evidence"):
        EVIDENCE.write(path)


def pytest_unconfigure(config):
    if not hasattr(config, "workerinput") and not config.getoption("--programs"):
        shutil.rmtree(config.stash[PROGRAMS], ignore_errors=True)


@pytest.fixture
def files_without_quick(pytestconfig):
    """The files of tests, of those collected, that `make test` leaves out as a whole."""
    return pytestconfig.stash[WITHOUT_QUICK]
