"""What `configure` sets before JAX starts."""

import jax
import pytest

from jaxbuffer import runtime


@pytest.fixture
def flags(monkeypatch):
    """XLA's flags after `configure` in a process whose backend is down, by the flags before and jaxlib's version."""

    def configured(before, version="0.10.2"):
        monkeypatch.setenv("XLA_FLAGS", before)
        monkeypatch.setattr(runtime, "_backend_is_up", lambda: False)
        monkeypatch.setattr(runtime, "version", {"jaxlib": version}.__getitem__)
        runtime.configure()
        return runtime.os.environ["XLA_FLAGS"].split()

    return configured


OURS = [runtime.ONE_KERNEL + runtime.SHORT_LOOPS, *runtime.QUICK_COMPILATION, runtime.WIDE_VECTORS]


def test_all_flags_of_a_version_that_was_tried(flags):
    assert flags("") == OURS


def test_what_is_set_already_stays(flags):
    found = flags("--xla_cpu_parallel_codegen_split_count=8 --xla_force_host_platform_device_count=2")
    assert found[:2] == ["--xla_cpu_parallel_codegen_split_count=8", "--xla_force_host_platform_device_count=2"]
    assert len(found) == 1 + len(OURS)
    assert flags(" ".join(found)) == found


def test_a_version_that_was_not_tried_gets_no_flags_that_may_end_it(flags):
    assert flags("", version="0.11.0") == [runtime.ONE_KERNEL]


def test_too_late_is_said(monkeypatch):
    jax.devices()
    monkeypatch.setenv("XLA_FLAGS", "")
    with pytest.warns(RuntimeWarning, match="before the first JAX computation"):
        runtime.configure()
    assert runtime.os.environ["XLA_FLAGS"] == ""
