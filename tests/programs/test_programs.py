"""Programs stored on disk: read back without tracing, and never in the place of another."""

import os
import pickle
import signal
import subprocess
import sys
import time
import zlib
from concurrent.futures import ThreadPoolExecutor

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax._src import compilation_cache

from jaxbuffer.programs import cache, identity
from jaxbuffer.programs import store as program_files
from jaxbuffer.programs.cache import Static, stored
from jaxbuffer.programs.store import store_in

CACHE = ("jax_compilation_cache_dir", "jax_persistent_cache_min_compile_time_secs")


class Polynomial(eqx.Module):
    coefficients: jax.Array
    scale: float
    kind: str = eqx.field(static=True, default="even")

    def __check_init__(self):
        if len(self.coefficients) < 2:  # checks its own arrays, as designs do
            raise ValueError("two coefficients at least")


@pytest.fixture(autouse=True)
def _classes_here_are_ours(monkeypatch):
    """Programs of any other classes stay in memory."""
    monkeypatch.setattr(identity, "OURS", identity.OURS | {__name__})


@pytest.fixture
def folder(tmp_path):
    before = {name: getattr(jax.config, name) for name in CACHE}
    store_in(tmp_path / "programs")
    for name, value in zip(CACHE, (str(tmp_path / "programs"), 0.0), strict=True):
        jax.config.update(name, value)
    compilation_cache.reset_cache()
    yield tmp_path / "programs"
    store_in(None)
    for name, value in before.items():
        jax.config.update(name, value)
    compilation_cache.reset_cache()


def files(folder):
    """The programs in a folder."""
    return list(folder.glob("*.program"))


@pytest.fixture
def traced():
    """A stored function anew, as in another process, and a list that grows with each trace."""
    traces = []

    def squares(polynomial, times):
        traces.append(1)
        ordered = jnp.sort(polynomial.coefficients * polynomial.scale)  # a sort's comparison is a program in a program
        total = jax.lax.fori_loop(0, times, lambda k, sum: sum + ordered[-1], 0.0)
        return Polynomial(ordered**2, total, "odd"), {"times": times}

    return (lambda: stored(squares)), traces


def inputs(values=(3.0, 1.0, 2.0), scale=2.0):
    return Polynomial(np.array(values), np.asarray(scale)), np.asarray(4)


def test_another_process_runs_what_was_kept_without_tracing(folder, traced):
    fresh, traces = traced
    for values, scale in (((3.0, 1.0, 2.0), 2.0), ((5.0, 4.0, 6.0), 1.0)):
        result, rest = fresh()(*inputs(values, scale))
        np.testing.assert_array_equal(result.coefficients, np.sort(np.array(values) * scale) ** 2)
        assert float(result.scale) == 4.0 * max(values) * scale
        assert (result.kind, int(rest["times"])) == ("odd", 4)
    assert len(traces) == 1 and len(files(folder)) == 1


class Pair(eqx.Module):
    first: float | None = None
    second: float | None = None


@pytest.mark.parametrize("parts", [
    (Pair(first=2.0), Pair(second=2.0)),
    ((2.0, None), (None, 2.0)),
    ((2.0, (None,)), ((2.0, None),)),
    ({"a": 2.0, "b": None}, {"a": None, "b": 2.0}),
])  # fmt: skip
def test_which_numbers_are_left_out_makes_another_program(folder, parts):
    """As many numbers of the same kinds, in nodes of the same kinds in the same order."""

    def weighed(part):
        return jnp.asarray(sum((3.0 ** len(str(path))) * leaf for path, leaf in jax.tree.leaves_with_path(part)))

    for part in parts:
        assert float(stored(weighed)(part)) == float(weighed(part))
    assert len(files(folder)) == 2


@pytest.mark.long
def test_a_stiffness_given_in_one_process_is_no_yield_stress_in_the_next(tmp_path):
    """It was: a capture of 253.13 N failed with a stored program that read 300 MPa as 300e6 N/m^1.5."""
    code = (
        "import sys, jaxbuffer as jb; jb.configure(cache='programs'); path, value = sys.argv[1:];"
        "print(float(jb.simulate(jb.replace(jb.table2(), {path: float(value)})).peak_force))"
    )
    for given in ("contact.stiffness=1e9", "contact.yield_stress=300e6"):
        words = [sys.executable, "-c", code, *given.split("=")]
        done = subprocess.run(words, check=True, cwd=tmp_path, capture_output=True, text=True)
    assert float(done.stdout) == pytest.approx(253.1315, rel=1e-5)


def test_other_shapes_static_fields_and_sources_are_other_programs(folder, traced, monkeypatch):
    fresh, traces = traced
    polynomial, times = inputs()
    fresh()(polynomial, times)
    fresh()(*inputs((1.0, 2.0)))
    fresh()(Polynomial(polynomial.coefficients, polynomial.scale, "odd"), times)
    monkeypatch.setattr(cache, "_made_from", lambda: b"another version")
    fresh()(polynomial, times)
    assert len(traces) == 4 and len(files(folder)) == 4


def test_jax_keeps_no_code_of_a_program(folder, traced):
    """Its own cache would have it twice, and what is read from there could not be kept again."""
    traced[0]()(*inputs())
    assert len(files(folder)) == 1 and not list(folder.glob("*-cache"))
    assert jax.config.jax_persistent_cache_min_compile_time_secs == 0.0


@pytest.mark.parametrize("content", [b"", b"\x80\x04K\x01.", b"garbage"])
def test_a_broken_file_is_compiled_and_written_anew(folder, traced, content):
    fresh, traces = traced
    fresh()(*inputs())
    (file,) = files(folder)
    file.write_bytes(content)
    for _ in range(2):
        assert float(fresh()(*inputs())[0].scale) == 24.0
    assert len(traces) == 2


def test_a_folder_that_cannot_be_written_is_no_error(tmp_path, traced):
    (tmp_path / "file").write_text("")
    store_in(tmp_path / "file")
    try:
        assert float(traced[0]()(*inputs())[0].scale) == 24.0
    finally:
        store_in(None)


@pytest.mark.parametrize("kept_on_disk", [True, False])
def test_what_passes_through_stays_outside_and_numbers_share_an_array(tmp_path, kept_on_disk):
    calls = []

    @stored
    def scaled(polynomial, by, label):
        calls.append(label.value)
        return {"polynomial": polynomial, "scaled": polynomial.coefficients * by * polynomial.scale}

    store_in(tmp_path if kept_on_disk else None)
    try:
        polynomial = Polynomial(np.array([1.0, 2.0]), 0.1)
        for by in (2.0, np.asarray(3.0), jnp.asarray(4.0)):
            result = scaled(polynomial, by, Static("a"))
            assert result["polynomial"].scale is polynomial.scale
            assert result["polynomial"].coefficients is polynomial.coefficients
            np.testing.assert_allclose(result["scaled"], np.array([0.1, 0.2]) * float(by), rtol=1e-15)
        np.testing.assert_array_equal(scaled(polynomial, 2, Static("a"))["scaled"], [0.2, 0.4])
        scaled(polynomial, 2.0, Static("b"))
    finally:
        store_in(None)
    assert calls == ["a", "a", "b"], "an integer is no number to share an array; another label is another program"


def test_of_threads_that_come_at_once_one_compiles(folder, traced):
    fresh, traces = traced
    function = fresh()
    with ThreadPoolExecutor(4) as pool:
        result = list(pool.map(lambda _: float(function(*inputs())[0].scale), range(8)))
    assert result == [24.0] * 8 and len(traces) == 1


def test_a_part_of_a_larger_program_is_traced_once(traced):
    fresh, traces = traced
    function = fresh()
    total = lambda scale: function(Polynomial(jnp.array([1.0, 2.0]), scale), 4)[0].scale  # noqa: E731
    assert float(jax.jit(jax.jacfwd(total))(3.0)) == 8.0
    assert len(traces) == 1


def test_transformations_and_no_folder_are_jit(folder, traced):
    fresh, _ = traced
    function = fresh()
    values = jnp.array([1.0, 2.0])
    total = lambda scale: function(Polynomial(values, scale), 4)[0].scale  # noqa: E731
    assert float(jax.jit(total)(3.0)) == 24.0 and float(jax.jacfwd(total)(3.0)) == 8.0
    np.testing.assert_array_equal(jax.vmap(total)(jnp.arange(3.0)), [0.0, 8.0, 16.0])
    store_in(None)
    fresh()(*inputs())
    assert not files(folder), "nothing was stored"


def test_files_long_unused_go_once_another_is_written(folder, traced):
    fresh, _ = traced
    old, recent = folder / "old.program", folder / "recent.program"
    for file, age in ((old, 31), (recent, 29)):
        file.touch()
        os.utime(file, (time.time() - age * 86400,) * 2)
    fresh()(*inputs())
    assert recent.exists() and not old.exists()
    (written,) = set(files(folder)) - {recent}
    os.utime(written, (0, 0))
    fresh()(*inputs())
    assert time.time() - written.stat().st_mtime < 86400


def test_a_planted_pickle_is_not_run(folder, traced, tmp_path):
    class Command:
        def __reduce__(self):
            return os.system, (f"touch {tmp_path / 'ran'}",)

    fresh, traces = traced
    fresh()(*inputs())
    (file,) = files(folder)
    for content in (pickle.dumps(Command()), program_files.MAGIC + pickle.dumps(Command())):
        file.write_bytes(content)
        assert float(fresh()(*inputs())[0].scale) == 24.0
    assert not (tmp_path / "ran").exists() and len(traces) == 3
    assert file.read_bytes().startswith(program_files.MAGIC), "replaced by a program"


@pytest.mark.parametrize("place", [0, 12, 25, 60, 300, -1])
@pytest.mark.parametrize("harm", ["flip", "cut"])
def test_a_damaged_file_is_replaced_before_it_is_looked_into(folder, traced, place, harm, monkeypatch):
    fresh, traces = traced
    fresh()(*inputs())
    (file,) = files(folder)
    whole = file.read_bytes()
    damaged = bytearray(whole)
    damaged[place] ^= 0x10
    file.write_bytes(bytes(damaged) if harm == "flip" else whole[:place])
    loaded = []
    with monkeypatch.context() as patched:
        patched.setattr(cache.load, "all_ready", lambda *_: loaded.append(1))
        assert float(fresh()(*inputs())[0].scale) == 24.0
    assert len(traces) == 2 and not loaded
    assert float(fresh()(*inputs())[0].scale) == 24.0 and len(traces) == 2, "whole again"


PROCESS = """
import sys
import jax, jaxbuffer.programs.process
jaxbuffer.programs.process.configure(cache={folder!r})
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
import numpy as np, jax.numpy as jnp, signal, os
from jaxbuffer.programs import cache as programs

@programs.stored
def squares(values):
    return [jnp.sort(values) ** 2, values]

compiled = []
{crash}
with programs.watched(compiled.append):
    print(np.asarray(squares(np.array([3.0, 1.0, 2.0]))[0]).tolist(), any(compiled))
"""
CRASH = "programs._run = lambda *_: os.kill(os.getpid(), signal.SIGSEGV)"
RIGHT = "[1.0, 4.0, 9.0]"


def process(folder, crash=""):
    """Another process that asks for a stored program: its exit code, and what it printed."""
    program = PROCESS.format(folder=str(folder), crash=crash)
    done = subprocess.run([sys.executable, "-c", program], check=False, capture_output=True, text=True, timeout=120)
    return done.returncode, done.stdout.strip(), done.stderr


@pytest.mark.slow
def test_a_file_that_ended_a_process_is_replaced(tmp_path):
    folder = tmp_path / "programs"
    assert process(folder)[:2] == (0, f"{RIGHT} True")
    assert process(folder)[:2] == (0, f"{RIGHT} False")
    assert process(folder, CRASH)[0] == -signal.SIGSEGV
    assert process(folder)[:2] == (0, f"{RIGHT} True"), "compiled anew"
    assert process(folder)[:2] == (0, f"{RIGHT} False")
    assert [file.suffix for file in folder.iterdir() if "squares" in file.name] == [".program"], "no marker stays"


SOLVED = """
import jax, jaxbuffer.programs.process
jaxbuffer.programs.process.configure(cache={folder!r})
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
import numpy as np, jax.numpy as jnp
from jaxbuffer.programs import cache as programs

compiled = []
solved = programs.stored(jnp.linalg.solve)
with programs.watched(compiled.append):
    print(float(solved(2.0 * np.eye(3), np.ones(3))[0]), any(compiled))
"""


@pytest.mark.slow
def test_a_program_that_solves_equations_runs_in_another_process(tmp_path):
    """Its LAPACK is made ready where the program is traced, and must be where it is read as well."""
    for compiled in (True, False):
        program = SOLVED.format(folder=str(tmp_path / "programs"))
        done = subprocess.run([sys.executable, "-c", program], check=False, capture_output=True, text=True, timeout=120)
        assert (done.returncode, done.stdout.strip()) == (0, f"0.5 {compiled}"), done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.2, 0.4, 0.6, 0.8, 0.95])
def test_code_that_is_wrong_behind_a_right_checksum_ends_one_process_at_most(tmp_path, share):
    """As when a disk is sound and the program was not: made by a broken compiler, say."""
    folder = tmp_path / "programs"
    process(folder)
    (file,) = folder.glob("squares*.program")
    stored = program_files.read(file)
    (part,) = stored.compiled
    code = bytearray(zlib.decompress(part.content))
    start = int(share * len(code))
    code[start : start + 64] = bytes(64)
    program_files.write(file, stored._replace(compiled=[part._replace(content=zlib.compress(bytes(code)))]))
    process(folder)
    code, printed, _ = process(folder)
    assert (code, printed.startswith(RIGHT)) == (0, True)


def test_a_file_being_loaded_by_another_process_is_left_alone(folder, traced):
    fresh, traces = traced
    fresh()(*inputs())
    (file,) = files(folder)
    with program_files.being_loaded(file):
        assert float(fresh()(*inputs())[0].scale) == 24.0
    assert len(traces) == 1 and files(folder) == [file] and not list(folder.glob("*.loading"))


def test_a_full_disk_leaves_nothing_behind(folder, traced, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    fresh, _ = traced
    monkeypatch.setattr(program_files.files, "write", full)
    assert float(fresh()(*inputs())[0].scale) == 24.0
    assert not files(folder)


def test_a_result_with_a_class_of_someone_elses_is_not_kept(folder):
    class Local(eqx.Module):
        value: jax.Array

    result = stored(lambda value: Local(value + 1.0))(2.0)
    assert float(result.value) == 3.0 and not files(folder)


def private(folder):
    """Whether programs are stored there, and what is said where not."""
    try:
        return store_in(folder)
    finally:
        store_in(None)


def test_a_folder_is_made_for_its_owner_alone(tmp_path):
    before = os.umask(0)
    try:
        assert private(tmp_path / "new" / "programs") == ""
    finally:
        os.umask(before)
    for place in (tmp_path / "new", tmp_path / "new" / "programs"):
        assert place.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("mode", [0o777, 0o775, 0o722])
def test_a_folder_where_others_may_write_is_not_used(tmp_path, mode, traced):
    folder = tmp_path / "programs"
    folder.mkdir()
    folder.chmod(mode)
    said = store_in(folder)
    assert said == f"others may write to {folder}; once you trust what is in it: chmod 700 '{folder}'"
    assert float(traced[0]()(*inputs())[0].scale) == 24.0
    assert not any(folder.iterdir())
    folder.chmod(0o700)
    assert private(folder) == ""


def test_a_folder_that_others_may_replace_is_not_used(tmp_path):
    parent = tmp_path / "shared"
    (parent / "programs").mkdir(parents=True, mode=0o700)
    parent.chmod(0o777)
    assert private(parent / "programs").startswith(f"others may write to {parent}: chmod go-w")
    parent.chmod(0o1777)
    assert private(parent / "programs") == "", "sticky: only an owner replaces what is his"


def test_a_link_is_not_used_and_one_above_counts_as_where_it_leads(tmp_path):
    (tmp_path / "real" / "programs").mkdir(parents=True, mode=0o700)
    (tmp_path / "link").symlink_to(tmp_path / "real" / "programs")
    assert private(tmp_path / "link") == f"{tmp_path / 'link'} is a link; set JAXBUFFER_CACHE to where it leads"
    (tmp_path / "above").symlink_to(tmp_path / "real")
    assert private(tmp_path / "above" / "programs") == ""
    (tmp_path / "real").chmod(0o777)
    assert private(tmp_path / "above" / "programs").startswith(f"others may write to {tmp_path / 'real'}")


def test_a_folder_of_another_user_is_not_used(tmp_path, monkeypatch):
    (tmp_path / "theirs").mkdir(mode=0o700)
    another = os.getuid() + 1
    monkeypatch.setattr(os, "getuid", lambda: another)
    assert private(tmp_path / "theirs") == (
        f"{tmp_path / 'theirs'} belongs to another user; set JAXBUFFER_CACHE to a folder of your own"
    )


@pytest.mark.slow
def test_neither_jax_nor_we_use_an_open_folder_and_a_line_says_so(tmp_path):
    folder = tmp_path / "programs"
    folder.mkdir()
    folder.chmod(0o777)
    code, printed, errors = process(folder)
    assert (code, printed) == (0, f"{RIGHT} True") and not any(folder.iterdir())
    assert errors == (
        f"note: compiled programs are not stored: others may write to {folder}; "
        f"once you trust what is in it: chmod 700 '{folder}'\n"
    )


def test_a_class_redefined_under_its_name_is_another_program_in_memory(folder):
    def weight(factor):
        class Weight(eqx.Module):
            value: float

            def of(self, times):
                return factor * times * self.value

        return Weight(2.0)

    def weighed(weight, times):
        return weight.of(times)

    function = stored(weighed)
    for factor in (2.0, 5.0):
        assert float(function(weight(factor), 3.0)) == float(stored(weighed)(weight(factor), 3.0)) == 6.0 * factor
        assert float(jax.vmap(function, (None, 0))(weight(factor), jnp.ones(2))[1]) == 2.0 * factor
    assert not files(folder), "it is in memory"


def applied(x, function):
    return function.value(x)


@pytest.mark.parametrize("name", ["__main__", "mine"])
def test_a_function_of_the_users_that_has_changed_is_another_program_in_memory(folder, tmp_path, name):
    """Typed, or of a file that was edited and run again, as a notebook's cell or a module."""
    file = tmp_path / "mine.py"
    for place in ("<stdin>", str(file)):
        for factor in (2.0, 5.0):
            code, names = f"def times(x): return {factor} * x", {"__name__": name}
            file.write_text(code)
            exec(compile(code, place, "exec"), names)
            assert float(stored(applied)(3.0, Static(names["times"]))) == 3.0 * factor
    assert not files(folder), "it is in memory"


def test_a_packages_lambda_is_known_by_its_code_and_the_numbers_around_it(folder):
    times = lambda factor: (lambda x: factor * x, lambda x: factor / x)  # noqa: E731 # classes here are ours
    for _ in range(2):  # the second time they are read
        for factor in (2.0, 5.0):
            for function, value in zip(times(factor), (3.0 * factor, factor / 3.0), strict=True):
                assert float(stored(applied)(3.0, Static(function))) == pytest.approx(value)
    assert len(files(folder)) == 4


def test_watched_is_called_where_a_program_is_compiled(folder, traced):
    fresh, _ = traced
    calls = []
    with cache.watched(calls.append):
        for _ in range(2):
            fresh()(*inputs())
    assert calls == [(cache.PROGRAM, cache.UNKNOWN), None], "the second is read"


def test_a_compilation_is_expected_to_take_as_long_as_the_last(folder):
    def slow(x):
        time.sleep(0.3)  # while it is traced
        return 2.0 * x

    calls = []
    with cache.watched(calls.append):
        for shape in (1, 2):
            stored(slow, what="slow things")(np.ones(shape))
    assert calls[0] == ("slow things", cache.UNKNOWN) and calls[1] is calls[3] is None
    assert 0.3 < calls[2].seconds < 5.0
