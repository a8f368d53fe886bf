"""Compiled programs stored on disk whole, so that a later process runs them without tracing them first.

JAX's own cache spares the compilation alone. Tracing and lowering a capture, which lead to that cache's key, take
longer than loading what it holds; here the key is all that a program is made from: the structure of its inputs, every
class and contact law in it, our own source, the packages, the processor and JAX's settings.
"""

import contextlib
import functools
import hashlib
import logging
import os
import sys
import threading
import time
from collections.abc import Callable, Hashable, Iterator
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.experimental.compilation_cache import compilation_cache
from jax.stages import Compiled

from ..contact.laws import LAWS
from . import executable, program_files, structure
from .backend import check_ready
from .folder import made_private
from .identity import fingerprint, lasting, lasts
from .kind import kind
from .split import compiled, run

R = TypeVar("R")

UNKNOWN = 10.0  # s, a run's on two cores
_log = logging.getLogger(__name__)
_folder: Path | None = None
_watcher: Callable[[float | None], None] | None = None
_compiling = threading.RLock()


def store_in(folder: str | Path | None) -> str:
    """Keep programs of functions marked `stored` in a folder from now on, or, with None, in memory only.

    **Returns:** why the folder is not used, if others can write there; "" otherwise.
    """
    global _folder  # noqa: PLW0603 # process-wide like JAX's own cache, which is set beside it
    _folder = None
    if folder is None:
        return ""
    wrong = made_private(Path(folder).absolute())
    if not wrong:
        _folder = Path(folder).resolve()
    return wrong


def folder() -> Path | None:
    """Where programs are kept, if anywhere."""
    return _folder


@contextlib.contextmanager
def watched(watcher: Callable[[float | None], None]) -> Iterator[None]:
    """Call ``watcher`` whenever a program's compilation begins, with the time that it is expected to take [s], and with
    None when it has ended."""
    global _watcher  # noqa: PLW0603 # one front shows what the whole process does
    before, _watcher = _watcher, watcher
    try:
        yield
    finally:
        _watcher = before


class Static(eqx.Module):
    """An argument of a function marked `stored` that its program is made for, rather than given."""

    value: Any = eqx.field(static=True)


def made_from(tree: Any, *code: Any) -> Static:
    """What may change between two calls although the structure of the arguments is the same, for functions under
    `jax.jit`: the laws that names in a tree stand for, classes of the user's, and ``code`` called."""
    return Static((_changeable(jax.tree.structure(tree)), fingerprint(*code)))


class _Program(NamedTuple):
    """A compiled function of arrays, in its parts, where the leaves of its result come from, and how long compiling it
    took [s]."""

    parts: list[Compiled]
    structure: Any
    sources: tuple[int | None, ...]  # the argument that a leaf of the result is, or None: the next one that is computed
    seconds: float

    def __call__(self, leaves: list[Any], given: list[Any]) -> Any:
        computed = iter(run(self.parts, given))
        found = [next(computed) if source is None else leaves[source] for source in self.sources]
        return jax.tree.unflatten(self.structure, found)


class stored(Generic[R]):  # a decorator
    """`jax.jit` for a function of trees of arrays, with compiled programs stored in the folder of `store_in`, if any.

    - Python floats among the arguments are passed as one array, which takes less time per call than one by one.
    - Arguments that the function returns unchanged are not passed through the program.
    - Under a transformation (`grad`, `vmap`) it is `jax.jit`. Inside another program that is being traced it is a plain
      call, because a nested `jit` would be traced twice where derivatives are asked for.
    - A program that cannot be read or written is compiled in memory.
    - Every call checks classes and contact laws that are not the package's own. Where one has changed, or its name
      means another one by now, a new program is compiled.
    """

    def __init__(
        self, function: Callable[..., R], first: Callable[..., Any] | None = None, seconds: float = UNKNOWN
    ) -> None:
        self.last, self.first, self.seconds = function, first, seconds

        def compiled_for(*arguments: Any, made_from: Any = None) -> R:
            return self.function(*arguments)

        self.jitted = jax.jit(compiled_for, static_argnames="made_from")
        self.programs: dict[Any, _Program] = {}
        functools.update_wrapper(self, function)

    def function(self, *arguments: Any) -> R:
        """All of it, uncompiled."""
        return self.last(*arguments) if self.first is None else self.last(*arguments, self.first(*arguments))

    def __call__(self, *arguments: Any) -> R:
        check_ready()
        leaves, tree = jax.tree.flatten(arguments)
        kinds = tuple(map(_kind, leaves))
        if any(kind is jax.core.Tracer for kind in kinds):
            return self.function(*arguments) if _tracing() else self.jitted(*arguments, made_from=_changeable(tree))
        numbers = np.array([leaf for leaf, kind in zip(leaves, kinds, strict=True) if kind is float])
        given = [numbers, *(leaf for leaf, kind in zip(leaves, kinds, strict=True) if kind is not float)]
        key = (_folder, tree, kinds, _changeable(tree))
        if key not in self.programs:
            with _compiling:  # of many threads that come at once, one compiles
                if key not in self.programs:
                    self.programs[key] = self._program(tree, kinds, given)
        return self.programs[key](leaves, given)

    def _program(self, tree: Any, kinds: tuple[Any, ...], given: list[Any]) -> _Program:
        described = fingerprint(structure.outline(tree), *structure.nodes(tree), *_laws(tree))
        if _folder is None or not lasting(described):
            return self._compiled(tree, kinds, given)
        file = _folder / f"{self.last.__name__}-{_digest(repr(described), str(kinds))}{program_files.SUFFIX}"
        program = _read(file, tree, given)
        if program is None:
            with program_files.being_made(file):  # of many processes that come at once, one compiles
                program = _read(file, tree, given)
                if program is None:
                    with _without_cache():
                        program = self._compiled(tree, kinds, given)
                    _write(file, tree, program)
        return program

    def _compiled(self, tree: Any, kinds: tuple[Any, ...], given: list[Any]) -> _Program:
        between: list[Any] = []  # the structure of what the first part finds
        result: list[Any] = []

        def separate(numbers: Any, *others: Any) -> tuple[list[Any], Iterator[Any]]:
            each, rest = iter(numbers), iter(others)
            return [next(each if kind is float else rest) for kind in kinds], rest

        def begun(*arrays: Any) -> list[Any]:
            assert self.first is not None
            found, structure_found = jax.tree.flatten(self.first(*jax.tree.unflatten(tree, separate(*arrays)[0])))
            between[:] = [structure_found]
            return found

        def flat(*arrays: Any) -> list[Any]:
            leaves, carried = separate(*arrays)
            arguments = [*jax.tree.unflatten(tree, leaves), *(jax.tree.unflatten(it, carried) for it in between)]
            found, structure_found = jax.tree.flatten(self.last(*arguments))
            place = {id(leaf): k for k, leaf in enumerate(leaves)}
            sources = tuple(place.get(id(leaf)) for leaf in found)
            result[:] = [structure_found, sources]
            return [leaf for leaf, source in zip(found, sources, strict=True) if source is None]

        watcher, begin = _watcher or (lambda _: None), time.monotonic()
        watcher(_expected(self.last.__name__, self.seconds))
        try:
            parts = compiled(flat, given, begun if self.first else None)
            return _Program(parts, result[0], result[1], time.monotonic() - begin)
        finally:
            watcher(None)


def after(first: Callable[..., Any], seconds: float = UNKNOWN) -> Callable[[Callable[..., R]], stored[R]]:
    """`stored` for a function whose last argument is what ``first`` finds from the others: each is a program of its
    own, and the second is traced and compiled while XLA is at work on the first. ``seconds``: how long that takes,
    roughly, until it has been done once."""
    return lambda function: stored(function, first, seconds)


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


def _changeable(tree: Any) -> Hashable:
    """What may change between two calls with arguments of one structure: contact laws, and code that is not known by
    the version of its package."""
    laws = _laws(tree)
    things = [*_own(tree), *(law for law in laws if not lasts(law))]
    return (laws, fingerprint(*things)) if things else laws


def _laws(tree: Any) -> tuple[type, ...]:
    """The laws whose names are in the arguments: looked up anew, since a name can be registered again."""
    return tuple(LAWS[word] for word in _words(tree) if word in LAWS)


@functools.lru_cache(maxsize=1024)
def _words(tree: Any) -> tuple[str, ...]:
    return tuple(value for _, static in structure.nodes(tree) for value in _flat(static) if isinstance(value, str))


@functools.lru_cache(maxsize=1024)
def _own(tree: Any) -> tuple[Any, ...]:
    """Types and static values of the arguments that are, or hold, code that may change."""
    parts = [part for kind, static in structure.nodes(tree) for part in (kind, *_flat(static))]
    return tuple(part for part in parts if not lasts(part))


def _flat(static: Any) -> Iterator[Any]:
    if isinstance(static, (tuple, list)):
        for part in static:
            yield from _flat(part)
    else:
        yield static


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


def _read(file: Path, tree: Any, given: list[Any]) -> _Program | None:
    """The program of a file if there is one and it runs on these arguments; one that does not is deleted."""
    try:
        stored = program_files.read(file)
        if stored is None:
            return None
        with program_files.being_loaded(file):
            described = zip(stored.description["parts"], stored.code, strict=True)
            parts = [executable.put_together(*part) for part in described]
            jax.block_until_ready(run(parts, given))
        found = structure.read(stored.description["structure"], tree)
        return _Program(parts, found, tuple(stored.description["sources"]), stored.description["seconds"])
    except Exception as error:  # another machine's, another JAX's: whatever it is, compiling helps
        _log.info("%s cannot be used: %s", file, error)
        program_files.remove(file)
        return None


def _write(file: Path, tree: Any, program: _Program) -> None:
    try:
        parts = [executable.taken_apart(part) for part in program.parts]
        description = {
            "structure": structure.written(program.structure, tree),
            "sources": program.sources,
            "seconds": program.seconds,
            "parts": [described for described, _ in parts],
        }
        program_files.write(file, program_files.Stored(description, [code for _, code in parts]))
    except Exception as error:  # a full disk, a JAX whose insides are others: the program is in memory
        _log.info("%s cannot be written: %s", file, error)


def _expected(name: str, otherwise: float) -> float:
    """How long it will take to compile a function of this name [s]: as long as the last one that was stored."""
    with contextlib.suppress(OSError):  # another process may delete files
        files = [] if _folder is None else list(_folder.glob(f"{name}-*{program_files.SUFFIX}"))
        last = program_files.read(max(files, key=os.path.getmtime)) if files else None
        return otherwise if last is None else last.description.get("seconds", otherwise)
    return otherwise


def _digest(*parts: str) -> str:
    """A hash of the parts and of everything else that a program depends on."""
    content = hashlib.sha256(_made_from())
    for part in parts:
        content.update(part.encode() + b"\0")
    return content.hexdigest()[:32]


@functools.cache
def _made_from() -> bytes:
    """Our own source, the packages, the processor and JAX's settings."""
    return hashlib.sha256("\0".join([sys.version, *kind().values()]).encode()).digest()
