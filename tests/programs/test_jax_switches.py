"""JAX's own switches: each works, or ends a command in one line that names it, with its value, and exit code 2."""

import os
import subprocess
import sys

import jax
import pytest

import jaxbuffer as jb
from in_short import often, quick

STUDY = 'kind = "bar_drop"\n[scenario]\nheight = 0.01\n[options]\nduration = 0.06\n'  # m, s


def command(folder, name, value):
    """`jaxbuffer simulate` in a process of its own with a switch set: what it ended with and printed."""
    (folder / "drop.toml").write_text(STUDY)
    return subprocess.run(
        [sys.executable, "-m", "jaxbuffer", "simulate", "drop.toml", "--trust", "off", "--output", "out"],
        check=False, capture_output=True, text=True, timeout=240, cwd=folder, env={**os.environ, name: value},
    )  # fmt: skip


IN_THE_WAY = [
    ("JAX_DEBUG_NANS", "1", "JAX_DEBUG_NANS=True: jaxbuffer cannot work with this switch of JAX"),
    ("JAX_DISABLE_JIT", "true", "JAX_DISABLE_JIT=True: jaxbuffer cannot work with this switch of JAX"),
    ("JAX_CHECK_TRACER_LEAKS", "1", "JAX_CHECK_TRACER_LEAKS=True: jaxbuffer cannot work with this switch"),
    ("JAX_NUMPY_DTYPE_PROMOTION", "strict", "JAX_NUMPY_DTYPE_PROMOTION=strict: jaxbuffer cannot work with"),
    ("JAX_TRANSFER_GUARD", "disallow", "JAX_TRANSFER_GUARD=disallow: jaxbuffer cannot work with this switch"),
    ("JAX_NO_TRACING", "1", "JAX_NO_TRACING=True: jaxbuffer cannot work with this switch of JAX"),
    ("JAX_PLATFORMS", "cuda", "JAX_PLATFORMS=cuda: JAX cannot start there: "),
    ("JAX_PLATFORMS", "nonsense", "JAX_PLATFORMS=nonsense: JAX cannot start there: "),
    ("JAX_PLATFORM_NAME", "rocm", "JAX_PLATFORM_NAME=rocm: JAX cannot start there: "),
    ("JAX_ENABLE_X64", "maybe", "invalid truth value 'maybe' for environment 'JAX_ENABLE_X64'"),
    ("JAX_TRANSFER_GUARD", "no", 'Invalid value "no" for JAX flag jax_transfer_guard'),
]
# Of those that jaxbuffer refuses, of devices that are missing and of words that JAX refuses; the test of `switch` below
# has all that jaxbuffer refuses, in one process.
SOME = ("JAX_DEBUG_NANS=1", "JAX_TRANSFER_GUARD=disallow", "JAX_PLATFORMS=nonsense", "JAX_ENABLE_X64=maybe")


@pytest.mark.slow
@pytest.mark.parametrize(("name", "value", "shown"), quick(IN_THE_WAY, *SOME, names=lambda it: f"{it[0]}={it[1]}"))
def test_a_switch_that_is_in_the_way_is_named_in_one_line(tmp_path, name, value, shown):
    if jax.default_backend() != "cpu" and name.startswith("JAX_PLATFORM"):
        pytest.skip("this machine may have that device")
    found = command(tmp_path, name, value)
    assert (found.returncode, found.stdout) == (2, "")
    assert found.stderr.count("\n") == 1 and shown in found.stderr
    assert not (tmp_path / "out").exists()


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """The command with a switch that changes nothing: what it ended with and printed."""
    return command(tmp_path_factory.mktemp("plain"), "JAX_ENABLE_X64", "1")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "value"),
    often(
        [
            ("JAX_ENABLE_X64", "0"),
            ("JAX_DEBUG_INFS", "1"),
            ("JAX_LOG_COMPILES", "1"),
            ("JAX_NUMPY_RANK_PROMOTION", "raise"),
            ("JAX_TRANSFER_GUARD", "log"),
            ("JAX_ENABLE_CHECKS", "1"),
        ],
        "JAX_ENABLE_X64",
        "JAX_ENABLE_CHECKS",
        names=lambda it: it[0],
    ),
)
def test_a_switch_that_is_not_changes_no_number(tmp_path, plain, name, value):
    found = command(tmp_path, name, value)
    assert (plain.returncode, found.returncode) == (0, 0), found.stderr
    assert found.stdout == plain.stdout and "Traceback" not in found.stderr


@pytest.mark.parametrize(
    "switch",
    [
        lambda: jax.debug_nans(True),
        jax.disable_jit,
        lambda: jax.numpy_dtype_promotion("strict"),
        lambda: jax.transfer_guard("disallow"),
        lambda: jax.transfer_guard_host_to_device("disallow_explicit"),
        jax.checking_leaks,
    ],
)
def test_a_switch_is_an_input_error_in_python(switch):
    with switch(), pytest.raises(jb.InputError, match="jaxbuffer cannot work with this switch of JAX, because"):
        jb.simulate(jb.BarDrop(), jb.BarDropScenario())


def test_a_sweep_says_it_too():
    with jax.debug_nans(True), pytest.raises(jb.InputError, match="JAX_DEBUG_NANS=True"):
        jb.sweep(jb.BarDrop(), jb.BarDropScenario(height=[0.1, 0.2]))


def test_the_way_out_of_the_message_is_one():
    """What it says to call makes it work."""
    before = jax.config.jax_debug_nans
    jax.config.update("jax_debug_nans", True)
    try:
        with pytest.raises(jb.InputError, match=r"jax\.config\.update\('jax_debug_nans', False\)") as error:
            jb.first_impact(jb.table2())
        exec(str(error.value).rpartition("or call ")[2], {"jax": jax})
        assert jb.first_impact(jb.table2()).elastic_peak > 0.0
    finally:
        jax.config.update("jax_debug_nans", before)
