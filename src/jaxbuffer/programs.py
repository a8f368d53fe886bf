"""Compiled programs kept on disk whole, so that a later process runs them without tracing them first.

JAX's own cache spares the compilation alone. Tracing and lowering a capture, which lead to that cache's key, take
longer than loading what it holds; here the key is the inputs' structure and all that the program is made from.
"""

import contextlib
import functools
import hashlib
import logging
import os
import pickle
import platform
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.experimental import serialize_executable
from jax.experimental.compilation_cache import compilation_cache
from jax.stages import Compiled

from .halves import compiled, run

R = TypeVar("R")

PACKAGES = ("jax", "jaxlib", "equinox", "diffrax")
UNUSED = 30 * 86400.0  # s after which a program's file is deleted: new source makes new files
_log = logging.getLogger(__name__)
_folder: Path | None = None


def keep_in(folder: str | Path | None) -> None:
    """Keep programs of functions marked `kept` in a folder from now on, or, with None, in memory only."""
    global _folder  # noqa: PLW0603 # process-wide like JAX's own cache, which is set beside it
    _folder = None if folder is None else Path(folder)


class Static(eqx.Module):
    """An argument of a function marked `kept` that its program is made for, rather than given."""

    value: Any = eqx.field(static=True)


class _Program(NamedTuple):
    """A compiled function of arrays, in its parts, and where the leaves of its result come from."""

    parts: list[Compiled]
    structure: Any
    sources: tuple[int | None, ...]  # the argument that a leaf of the result is, or None: the next one that is computed

    def __call__(self, leaves: list[Any], given: list[Any]) -> Any:
        computed = iter(run(self.parts, given))
        found = [next(computed) if source is None else leaves[source] for source in self.sources]
        return jax.tree.unflatten(self.structure, found)


class kept(Generic[R]):  # a decorator
    """`jax.jit` for a function of trees of arrays that spares what surrounds a call, its programs kept in the folder of
    `keep_in`, if any.

    All numbers go in as one array (one at a time they take longer than they are worth), and what the function only
    hands on stays outside. Under a transformation it is `jax.jit` and nothing else; within a larger program that is
    being traced, a part of it: traced for itself first, a function is traced twice where derivatives are asked for.
    What cannot be read or written is compiled as ever.
    """

    def __init__(self, function: Callable[..., R]) -> None:
        self.function, self.jitted = function, jax.jit(function)
        self.programs: dict[Any, _Program] = {}
        self.compiling = threading.Lock()
        functools.update_wrapper(self, function)

    def __call__(self, *arguments: Any) -> R:
        leaves, structure = jax.tree.flatten(arguments)
        kinds = tuple(map(_kind, leaves))
        if any(kind is jax.core.Tracer for kind in kinds):
            return (self.function if _tracing() else self.jitted)(*arguments)
        numbers = np.array([leaf for leaf, kind in zip(leaves, kinds, strict=True) if kind is float])
        given = [numbers, *(leaf for leaf, kind in zip(leaves, kinds, strict=True) if kind is not float)]
        key = (_folder, structure, kinds)
        if key not in self.programs:
            with self.compiling:  # of many threads that come at once, one compiles
                if key not in self.programs:
                    self.programs[key] = self._program(structure, kinds, given)
        return self.programs[key](leaves, given)

    def _program(self, structure: Any, kinds: tuple[Any, ...], given: list[Any]) -> _Program:
        result: list[Any] = []

        def flat(numbers: Any, *others: Any) -> list[Any]:
            each, rest = iter(numbers), iter(others)
            leaves = [next(each if kind is float else rest) for kind in kinds]
            found, structure_found = jax.tree.flatten(self.function(*jax.tree.unflatten(structure, leaves)))
            place = {id(leaf): k for k, leaf in enumerate(leaves)}
            sources = tuple(place.get(id(leaf)) for leaf in found)
            result[:] = [structure_found, sources]
            return [leaf for leaf, source in zip(found, sources, strict=True) if source is None]

        if _folder is None:
            return _Program(compiled(flat, given), *result)
        file = _folder / f"{self.function.__name__}-{_digest(str(structure), str(kinds))}.program"
        program = _read(file, given)
        if program is not None:
            return program
        with _without_cache():
            program = _Program(compiled(flat, given), *result)
        # a tree of zeros stands for its structure, which cannot be pickled where it has static fields of its own
        example = jax.tree.unflatten(program.structure, [0] * len(program.sources))
        with contextlib.suppress(jax.errors.JaxRuntimeError, pickle.PicklingError, OSError, ValueError):
            stored = [serialize_executable.serialize(part) for part in program.parts]
            _write(file, pickle.dumps((stored, example, program.sources)))
        return program


def _tracing() -> bool:
    """Whether a larger program is being traced: then even a constant is part of it."""
    return isinstance(jnp.zeros(()), jax.core.Tracer)


def _kind(leaf: Any) -> Any:
    """`float` for a number that may share an array with others, `Tracer`, or shape and type."""
    if type(leaf) is float or (type(leaf) is np.ndarray and leaf.shape == () and leaf.dtype == float):
        return float
    if isinstance(leaf, jax.core.Tracer):
        return jax.core.Tracer
    shape, kind = np.shape(leaf), jax.dtypes.result_type(leaf)
    return float if shape == () and kind is np.dtype(float) else (shape, kind)


@contextlib.contextmanager
def _without_cache() -> Iterator[None]:
    """Without JAX's own cache: a program that was read from there lacks parts when it is written once more."""
    before = jax.config.jax_compilation_cache_dir  # type: ignore[attr-defined]
    try:
        jax.config.update("jax_compilation_cache_dir", None)
        compilation_cache.reset_cache()
        yield
    finally:
        jax.config.update("jax_compilation_cache_dir", before)
        compilation_cache.reset_cache()


def _read(file: Path, given: list[Any]) -> _Program | None:
    """The program of a file if there is one and it runs on these arguments."""
    try:
        stored, example, sources = pickle.loads(file.read_bytes())
        with contextlib.suppress(OSError):  # a folder shared read-only serves as well
            file.touch()
        parts = [serialize_executable.deserialize_and_load(*part) for part in stored]
        jax.block_until_ready(run(parts, given))
    except FileNotFoundError:
        return None
    except Exception as error:  # a torn file, another machine's: whatever it is, compiling helps
        _log.info("%s cannot be used: %s", file, error)
        return None
    return _Program(parts, jax.tree.structure(example), sources)


def _write(file: Path, content: bytes) -> None:
    """Put the file there in one go: another process may read it at the same time. Files long unused go."""
    file.parent.mkdir(parents=True, exist_ok=True)
    for old in file.parent.glob("*.program"):
        if time.time() - old.stat().st_mtime > UNUSED:
            old.unlink(missing_ok=True)
    with tempfile.NamedTemporaryFile(dir=file.parent, delete=False) as draft:
        draft.write(content)
    os.replace(draft.name, file)


def _digest(*parts: str) -> str:
    """A hash of the parts and of everything else that a program depends on."""
    content = hashlib.sha256(_made_from())
    for part in parts:
        content.update(part.encode() + b"\0")
    return content.hexdigest()[:32]


@functools.cache
def _made_from() -> bytes:
    """Our own source, the packages, the processor and JAX's settings."""
    content = hashlib.sha256()
    for file in sorted(Path(__file__).parent.rglob("*.py")):
        content.update(f"{file}\0".encode() + file.read_bytes())
    settings = [
        jax.default_backend(),
        str(jax.dtypes.canonicalize_dtype(float)),
        os.environ.get("XLA_FLAGS", ""),
        _processor(),
    ]
    content.update("\0".join([*map(version, PACKAGES), *settings]).encode())
    return content.digest()


def _processor() -> str:
    """What the machine's code may use."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    return next((line for line in lines if line.startswith(("flags", "Features"))), platform.platform())
