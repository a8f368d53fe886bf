"""What `configure` sets before JAX starts."""

import os
import subprocess
import sys
import textwrap
from importlib.metadata import version

import jax
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms.probe_cone.comparison import compare_laws
from jaxbuffer.programs import process as runtime
from jaxbuffer.programs import xla_flags


@pytest.fixture
def flags(monkeypatch):
    """XLA's flags after `configure` in a process whose backend is down, by the flags before and jaxlib's version."""

    def configured(before, version="0.10.2"):
        monkeypatch.setenv("XLA_FLAGS", before)
        monkeypatch.setattr(runtime, "backend_is_up", lambda: False)
        monkeypatch.setattr(runtime, "version", {"jaxlib": version}.__getitem__)
        runtime.configure(cache=None)
        return runtime.os.environ["XLA_FLAGS"].split()

    return configured


@pytest.fixture
def trials(monkeypatch):
    """The flags that were tried, in lists, by a jaxlib that takes all but `NO_EMITTERS`."""
    begun = []

    def takes(flags):
        begun.append(list(flags))
        return [flag != xla_flags.NO_EMITTERS for flag in flags]

    monkeypatch.setattr(xla_flags, "_takes", takes)
    return begun


def test_flags_of_a_version_that_can_do_without_emitters(flags, trials):
    assert flags("") == list(xla_flags.TRIALS)
    assert not trials


def test_flags_of_a_version_that_cannot_do_without_emitters(flags, trials):
    """`NO_EMITTERS` would end the process there."""
    others = [xla_flags.FEW_PASSES, xla_flags.ONE_MODULE, xla_flags.WIDE_VECTORS]
    assert flags("", version="0.12.0.1") == [xla_flags.SHORT_LOOPS, *others]
    assert not trials


def test_what_is_set_already_stays(flags):
    result = flags("--xla_cpu_parallel_codegen_split_count=8 --xla_force_host_platform_device_count=2")
    assert result[:2] == ["--xla_cpu_parallel_codegen_split_count=8", "--xla_force_host_platform_device_count=2"]
    assert len(result) == 1 + len(xla_flags.TRIALS)
    assert flags(" ".join(result)) == result


def test_flags_of_another_version_are_tried_once_and_kept_with_it(flags, trials, monkeypatch, tmp_path):
    monkeypatch.setattr(xla_flags.store, "folder", lambda: tmp_path)
    first = flags("", version="0.13.0")
    assert first == flags("", version="0.12.0")
    assert flags("", version="0.13.0") == first
    assert trials == [list(xla_flags.TRIALS)]
    assert flags("", version="0.13.1") == first
    assert len(trials) == 2
    (file,) = tmp_path.glob("*0.13.0*")
    file.write_text("{half")  # damaged
    assert flags("", version="0.13.0") == first
    assert len(trials) == 3
    file.write_text('{"--xla_of_an_earlier_jaxbuffer=1": true}')
    assert flags("", version="0.13.0") == first
    assert len(trials) == 4


def test_another_version_is_not_tried_at_every_start_where_nothing_can_be_kept(flags, trials, monkeypatch, tmp_path):
    monkeypatch.setattr(xla_flags.store, "folder", lambda: None)
    alone = [xla_flags.ONE_KERNEL]
    assert flags("", version="0.13.0") == alone
    monkeypatch.setattr(xla_flags.store, "folder", lambda: tmp_path)
    monkeypatch.setattr(xla_flags.os, "access", lambda *_: False)
    assert flags("", version="0.13.0") == alone
    assert not trials


def test_a_full_disk_ends_no_start(trials, tmp_path):
    folder = tmp_path / "a file"  # nothing can be written in it
    folder.write_text("")
    assert xla_flags.tried(folder, "0.13.0") == tuple(it for it in xla_flags.TRIALS if it != xla_flags.NO_EMITTERS)


@pytest.mark.long
def test_a_trial_says_which_flag_this_jaxlib_takes():
    """One that XLA does not know, one that LLVM does not know, and what the table says of this version."""
    unknown = ["--xla_no_such_flag=1", f"{xla_flags.ONE_KERNEL},-no-such-option=1"]
    answers = dict(zip(flags := [*unknown, *xla_flags.TRIALS], xla_flags._takes(flags), strict=True))
    assert not any(answers[flag] for flag in unknown)
    taken = tuple(flag for flag in xla_flags.TRIALS if answers[flag])
    series = [it for it in xla_flags.TAKEN if version("jaxlib").startswith(it)]
    assert all(taken == xla_flags.TAKEN[it] for it in series)
    assert xla_flags.SHORT_LOOPS in taken


def test_a_trial_without_an_interpreter_takes_no_flag(monkeypatch, tmp_path):
    monkeypatch.setattr(xla_flags.sys, "executable", str(tmp_path / "none"))
    assert xla_flags._takes(xla_flags.TRIALS[:2]) == [False, False]


KEEPS = """
    {before}
    import os, jax, jaxbuffer as jb
    jb.configure({arguments})
    from jaxbuffer.programs.store import folder
    for place in (folder(), jax.config.jax_compilation_cache_dir):
        print(place and os.path.relpath(place, {here!r}))
"""


@pytest.mark.parametrize(
    ("before", "arguments", "kept"),
    [
        ("", "", ["default", "default"]),
        ("", "cache=None", [None, None]),
        ("", "cache={here!r} + '/given'", ["given", "given"]),
        ("import jax; jax.config.update('jax_compilation_cache_dir', {here!r} + '/jax')", "", ["default", "jax"]),
    ],
)
def test_where_programs_are_kept(tmp_path, before, arguments, kept):
    """By default where the command line keeps them; what JAX was given stays."""
    here = str(tmp_path)
    program = KEEPS.format(before=before.format(here=here), arguments=arguments.format(here=here), here=here)
    code, printed, errors = process(program, JAXBUFFER_CACHE=str(tmp_path / "default"))
    assert (code, printed.split(), errors) == (0, [str(place) for place in kept], "")


def test_too_late_is_said(monkeypatch):
    jax.devices()
    monkeypatch.setenv("XLA_FLAGS", "")
    with pytest.warns(RuntimeWarning, match="before the first JAX computation"):
        runtime.configure(cache=None)
    assert runtime.os.environ["XLA_FLAGS"] == ""


def process(program, **environment):
    """A process of its own that runs ``program``: its exit code, and what it printed."""
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)],
        check=False,
        capture_output=True,
        text=True,
        timeout=240,
        env={**os.environ, "XLA_FLAGS": "", "JAX_ENABLE_X64": "0", **environment},
    )
    return done.returncode, done.stdout, done.stderr


SLOW = "jb.configure() was not called before JAX's backend started: captures take about ten times longer"
COMPUTE = """
    import jaxbuffer as jb
    {before}
    for speed in (0.1, 0.2):
        jb.first_impact(jb.table2(), jb.Scenario(approach_speed=speed))
"""


@pytest.mark.slow
def test_slow_loops_are_said_once_and_only_where_they_are_slow():
    code, _, errors = process(COMPUTE.format(before=""), JAX_ENABLE_X64="1")
    assert code == 0 and errors.count(SLOW) == 1
    assert process(COMPUTE.format(before="jb.configure()")) == (0, "", "")
    late = "import jax; jax.devices(); jb.configure()"
    code, _, errors = process(COMPUTE.format(before=late))
    assert code == 0 and SLOW not in errors and errors.count("jaxbuffer.configure() came after") == 1
    # flags that are set once the backend has started are of no use
    late = f"import jax, os; jax.devices(); os.environ['XLA_FLAGS'] = {xla_flags.ONE_KERNEL!r}"
    code, _, errors = process(COMPUTE.format(before=late), JAX_ENABLE_X64="1")
    assert code == 0 and errors.count(SLOW) == 1


@pytest.mark.parametrize(
    "call",
    [
        lambda: jb.simulate(jb.table2()),
        lambda: jb.first_impact(jb.table2()),
        lambda: jb.sensitivity(jb.table2()),
        lambda: jb.sweep(jb.table2(), jb.Scenario()),
        lambda: jb.tune(jb.Problem(jb.table2(), (jb.Scenario(),), (jb.Variable("buffer.k_A", 300.0, 700.0),))),
        lambda: compare_laws(jb.table2()),
        lambda: jax.jit(lambda v: jb.simulate(jb.table2(), jb.Scenario(approach_speed=v)).peak_force)(0.1),
    ],
)
def test_single_precision_is_refused_with_what_to_call(call):
    jax.config.update("jax_enable_x64", False)
    try:
        with pytest.raises(jb.InputError, match=r"needs double precision: call jb\.configure\(\) before the first JAX"):
            call()
    finally:
        jax.config.update("jax_enable_x64", True)


FORKED = """
    import os, signal, warnings
    import jaxbuffer as jb
    jb.configure()
    warnings.simplefilter("ignore")
    {parent}
    for call in {calls}:
        child = os.fork()
        if child == 0:
            signal.alarm(60)  # s, then the child ends by a signal: a hang is a failure, not a wait
            try:
                eval(call)
                print("computed", flush=True)
                os._exit(0)
            except RuntimeError as error:
                print(error, flush=True)
                os._exit(3)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""
COMPUTED = "jb.first_impact(jb.table2())"
CALLS = [
    COMPUTED,
    "jb.simulate(jb.table2())",
    "jb.sweep(jb.table2(), jb.Scenario())",
    "jb.sensitivity(jb.table2())",
    "jb.tune(jb.Problem(jb.table2(), (jb.Scenario(),), (jb.Variable('buffer.k_A', 300.0, 700.0),)))",
]


@pytest.mark.slow
def test_a_fork_after_the_first_computation_is_refused_rather_than_hang():
    """One process forks for each call, because it is its start that takes long."""
    code, printed, _ = process(FORKED.format(parent=COMPUTED, calls=CALLS))
    lines = printed.splitlines()
    assert code == 0 and lines[1::2] == ["3"] * len(CALLS), printed
    for message in lines[::2]:
        assert "forked from one in which JAX had started" in message
        assert "multiprocessing.get_context('spawn') or 'forkserver'" in message


@pytest.mark.slow
def test_a_fork_before_the_first_computation_computes():
    assert process(FORKED.format(parent="", calls=[COMPUTED]))[:2] == (0, "computed\n0\n")
