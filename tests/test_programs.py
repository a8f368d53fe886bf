"""Programs kept on disk: read back without tracing, and never in the place of another."""

import os
import time
from concurrent.futures import ThreadPoolExecutor

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer import programs
from jaxbuffer.programs import Static, keep_in, kept

CACHE = ("jax_compilation_cache_dir", "jax_persistent_cache_min_compile_time_secs")


class Polynomial(eqx.Module):
    coefficients: jax.Array
    scale: float
    kind: str = eqx.field(static=True, default="even")

    def __check_init__(self):
        if len(self.coefficients) < 2:  # checks its own arrays, as designs do
            raise ValueError("two coefficients at least")


@pytest.fixture
def folder(tmp_path):
    keep_in(tmp_path / "programs")
    yield tmp_path / "programs"
    keep_in(None)


@pytest.fixture
def traced():
    """A kept function anew, as in another process, and a list that grows with each trace."""
    traces = []

    def squares(polynomial, times):
        traces.append(1)
        ordered = jnp.sort(polynomial.coefficients * polynomial.scale)  # a sort's comparison is a program in a program
        total = jax.lax.fori_loop(0, times, lambda k, sum: sum + ordered[-1], 0.0)
        return Polynomial(ordered**2, total, "odd"), {"times": times}

    return (lambda: kept(squares)), traces


def asked(values=(3.0, 1.0, 2.0), scale=2.0):
    return Polynomial(np.array(values), np.asarray(scale)), np.asarray(4)


def test_another_process_runs_what_was_kept_without_tracing(folder, traced):
    fresh, traces = traced
    for values, scale in (((3.0, 1.0, 2.0), 2.0), ((5.0, 4.0, 6.0), 1.0)):
        found, rest = fresh()(*asked(values, scale))
        np.testing.assert_array_equal(found.coefficients, np.sort(np.array(values) * scale) ** 2)
        assert float(found.scale) == 4.0 * max(values) * scale
        assert (found.kind, int(rest["times"])) == ("odd", 4)
    assert len(traces) == 1 and len(list(folder.iterdir())) == 1


def test_other_shapes_static_fields_and_sources_are_other_programs(folder, traced, monkeypatch):
    fresh, traces = traced
    polynomial, times = asked()
    fresh()(polynomial, times)
    fresh()(*asked((1.0, 2.0)))
    fresh()(Polynomial(polynomial.coefficients, polynomial.scale, "odd"), times)
    monkeypatch.setattr(programs, "_made_from", lambda: b"another version")
    fresh()(polynomial, times)
    assert len(traces) == 4 and len(list(folder.iterdir())) == 4


def test_a_program_in_the_cache_of_jax_is_not_written_once_more(folder, traced, monkeypatch, tmp_path):
    before = {name: getattr(jax.config, name) for name in CACHE}
    fresh, traces = traced
    try:
        for name, value in zip(CACHE, (str(tmp_path / "jax"), 0.0), strict=True):
            jax.config.update(name, value)
        for version in (b"one", b"two", b"two"):
            monkeypatch.setattr(programs, "_made_from", lambda version=version: version)
            assert float(fresh()(*asked())[0].scale) == 24.0
        assert jax.config.jax_compilation_cache_dir == str(tmp_path / "jax"), "as it was"
    finally:
        for name, value in before.items():
            jax.config.update(name, value)
    assert len(traces) == 2, "the third found what the second had written"


@pytest.mark.parametrize("content", [b"", b"\x80\x04K\x01.", b"garbage"])
def test_a_broken_file_is_compiled_and_written_anew(folder, traced, content):
    fresh, traces = traced
    fresh()(*asked())
    (file,) = folder.iterdir()
    file.write_bytes(content)
    for _ in range(2):
        assert float(fresh()(*asked())[0].scale) == 24.0
    assert len(traces) == 2


def test_a_folder_that_cannot_be_written_is_no_error(tmp_path, traced):
    (tmp_path / "file").write_text("")
    keep_in(tmp_path / "file")
    try:
        assert float(traced[0]()(*asked())[0].scale) == 24.0
    finally:
        keep_in(None)


@pytest.mark.parametrize("kept_on_disk", [True, False])
def test_what_passes_through_stays_outside_and_numbers_share_an_array(tmp_path, kept_on_disk):
    seen = []

    @kept
    def scaled(polynomial, by, label):
        seen.append(label.value)
        return {"polynomial": polynomial, "scaled": polynomial.coefficients * by * polynomial.scale}

    keep_in(tmp_path if kept_on_disk else None)
    try:
        polynomial = Polynomial(np.array([1.0, 2.0]), 0.1)
        for by in (2.0, np.asarray(3.0), jnp.asarray(4.0)):
            found = scaled(polynomial, by, Static("a"))
            assert found["polynomial"].scale is polynomial.scale
            assert found["polynomial"].coefficients is polynomial.coefficients
            np.testing.assert_allclose(found["scaled"], np.array([0.1, 0.2]) * float(by), rtol=1e-15)
        np.testing.assert_array_equal(scaled(polynomial, 2, Static("a"))["scaled"], [0.2, 0.4])
        scaled(polynomial, 2.0, Static("b"))
    finally:
        keep_in(None)
    assert seen == ["a", "a", "b"], "an integer is no number to share an array; another label is another program"


def test_of_threads_that_come_at_once_one_compiles(traced):
    fresh, traces = traced
    function = fresh()
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: float(function(*asked())[0].scale), range(8)))
    assert found == [24.0] * 8 and len(traces) == 1


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
    keep_in(None)
    fresh()(*asked())
    assert not any(folder.iterdir()), "nothing was kept"


def test_files_long_unused_go_once_another_is_written(folder, traced):
    fresh, _ = traced
    old, recent = folder / "old.program", folder / "recent.program"
    for file, age in ((old, 31), (recent, 29)):
        file.touch()
        os.utime(file, (time.time() - age * 86400,) * 2)
    fresh()(*asked())
    assert recent.exists() and not old.exists()
    (written,) = set(folder.iterdir()) - {recent}
    os.utime(written, (0, 0))
    fresh()(*asked())
    assert time.time() - written.stat().st_mtime < 86400
