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
import time
from collections.abc import Callable, Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any, Generic, TypeVar

import jax
import numpy as np
from jax.experimental import serialize_executable
from jax.experimental.compilation_cache import compilation_cache

R = TypeVar("R")

PACKAGES = ("jax", "jaxlib", "equinox", "diffrax")
UNUSED = 30 * 86400.0  # s after which a program's file is deleted: new source makes new files
_log = logging.getLogger(__name__)
_folder: Path | None = None


def keep_in(folder: str | Path | None) -> None:
    """Keep programs of functions marked `kept` in a folder from now on, or, with None, in memory only."""
    global _folder  # noqa: PLW0603 # process-wide like JAX's own cache, which is set beside it
    _folder = None if folder is None else Path(folder)


class kept(Generic[R]):  # a decorator
    """`jax.jit` for a function of trees of arrays, its programs kept in the folder of `keep_in`.

    Under a transformation, and without a folder, it is `jax.jit` and nothing else. What cannot be read or written is
    compiled as ever.
    """

    def __init__(self, function: Callable[..., R]) -> None:
        self.function, self.jitted = function, jax.jit(function)
        self.programs: dict[Any, Callable[..., Any]] = {}
        functools.update_wrapper(self, function)

    def __call__(self, *arguments: Any) -> R:
        leaves, structure = jax.tree.flatten(arguments)
        if _folder is None or any(isinstance(leaf, jax.core.Tracer) for leaf in leaves):
            return self.jitted(*arguments)
        folder = _folder
        key = (folder, structure, tuple((np.shape(leaf), np.result_type(leaf)) for leaf in leaves))
        if key not in self.programs:
            file = folder / f"{self.function.__name__}-{_digest(*map(str, key[1:]))}.program"
            self.programs[key] = _read(file, leaves) or self._compiled(leaves, structure, file)
        return self.programs[key](leaves)

    def _compiled(self, leaves: list[Any], structure: Any, file: Path) -> Callable[..., Any]:
        shape: list[Any] = []

        def flat(leaves: list[Any]) -> list[Any]:
            result = self.function(*jax.tree.unflatten(structure, leaves))
            shape.append(jax.tree.structure(result))
            return jax.tree.leaves(result)

        with _without_cache():
            compiled = jax.jit(flat).lower(leaves).compile()
        # a tree of zeros stands for its structure, which cannot be pickled where it has static fields of its own
        example = jax.tree.unflatten(shape[0], [0] * shape[0].num_leaves)
        with contextlib.suppress(jax.errors.JaxRuntimeError, pickle.PicklingError, OSError, ValueError):
            _write(file, pickle.dumps((serialize_executable.serialize(compiled), example)))
        return lambda leaves: jax.tree.unflatten(shape[0], compiled(leaves))


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


def _read(file: Path, leaves: list[Any]) -> Callable[..., Any] | None:
    """The program of a file if there is one and it runs on ``leaves``."""
    try:
        stored, example = pickle.loads(file.read_bytes())
        with contextlib.suppress(OSError):  # a folder shared read-only serves as well
            file.touch()
        compiled = serialize_executable.deserialize_and_load(*stored)
        jax.block_until_ready(compiled(leaves))
    except FileNotFoundError:
        return None
    except Exception as error:  # a torn file, another machine's: whatever it is, compiling helps
        _log.info("%s cannot be used: %s", file, error)
        return None
    structure = jax.tree.structure(example)
    return lambda leaves: jax.tree.unflatten(structure, compiled(leaves))


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
