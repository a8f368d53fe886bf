"""Compiled programs that a later process runs without tracing them first.

JAX's persistent cache spares the compilation only: tracing and lowering a capture, which lead to that cache's key, take
longer than loading what it holds. Here the key is all that a program is made from: the structure of its arguments, our
own source, the packages, the processor and JAX's settings. A program of code of the user's, a contact law say, stays in
memory.
"""

import contextlib
import functools
import gc
import hashlib
import logging
import os
import pickle
import sys
import threading
import time
import weakref
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.stages import Compiled

from . import ahead, load, store
from .identity import Description, skeleton
from .process import check_ready, kind, trim

R = TypeVar("R")


class Compilation(NamedTuple):
    """A compilation that begins: ``what`` is compiled, in words, and how long that usually takes (``seconds``)."""

    what: str
    seconds: float


Watcher = Callable[[Compilation | None], None]

UNKNOWN = 10.0  # s, a run's on two cores
PROGRAM = "a program"
_log = logging.getLogger(__name__)
_watcher: Watcher | None = None
_compiling = threading.RLock()


@contextlib.contextmanager
def watched(watcher: Watcher) -> Iterator[None]:
    """Call ``watcher`` whenever a program's compilation begins, with what that is, and with None when it has ended."""
    global _watcher  # noqa: PLW0603 # one front shows what the whole process does
    before, _watcher = _watcher, watcher
    try:
        yield
    finally:
        _watcher = before


class Static(eqx.Module):
    """An argument of a function marked `stored` that its program is made for, rather than given."""

    value: Any = eqx.field(static=True)


class _Program(NamedTuple):
    """A compiled function of arrays, in its parts.

    ``sources``: the index of the argument that is returned unchanged as this output, or None if it is computed;
    ``seconds``: how long compiling it took [s].
    """

    parts: list[Compiled]
    structure: Any
    sources: tuple[int | None, ...]
    seconds: float

    def __call__(self, leaves: list[Any], given: list[Any]) -> Any:
        computed = iter(_run(self.parts, given))
        leaves_now = [next(computed) if source is None else leaves[source] for source in self.sources]
        return jax.tree.unflatten(self.structure, leaves_now)


class stored(Generic[R]):  # a decorator
    """`jax.jit` for a function of trees of arrays, with programs stored in the folder of `store_in`, if any.

    - Python floats among the arguments are passed as one array, which takes less time per call than one by one.
    - Arguments that the function returns unchanged are not passed through the program.
    - Under a transformation (`grad`, `vmap`) it is `jax.jit`. Inside another program that is being traced it is a plain
      call, because a nested `jit` would be traced twice where derivatives are asked for.
    - A program that cannot be read or written, or is made from code of the user's, is compiled in memory.
    - A class that is defined again is a new program. Globals that its code reads are read once, as under `jax.jit`.
    """

    def __init__(
        self,
        function: Callable[..., R],
        first: Callable[..., Any] | None = None,
        seconds: float = UNKNOWN,
        what: str = PROGRAM,
    ) -> None:
        self.last, self.first, self.seconds, self.what = function, first, seconds, what

        self.jitted = jax.jit(self.function)
        self.programs: dict[Any, _Program] = {}
        functools.update_wrapper(self, function)
        _functions.add(self)

    def function(self, *arguments: Any) -> R:
        """Call the function, ``first`` before it, uncompiled."""
        return self.last(*arguments) if self.first is None else self.last(*arguments, self.first(*arguments))

    def __call__(self, *arguments: Any) -> R:
        check_ready()
        leaves, tree = jax.tree.flatten(arguments)
        kinds = tuple(map(_kind, leaves))
        if any(kind is jax.core.Tracer for kind in kinds):
            # While a larger program is being traced, even a constant is part of it.
            larger = isinstance(jnp.zeros(()), jax.core.Tracer)
            return self.function(*arguments) if larger else self.jitted(*arguments)
        numbers = np.array([leaf for leaf, kind in zip(leaves, kinds, strict=True) if kind is float])
        given = [numbers, *(leaf for leaf, kind in zip(leaves, kinds, strict=True) if kind is not float)]
        # The folder too, so that programs are kept in one that is given later.
        key = (store.folder(), tree, kinds)
        program = self.programs.get(key)
        if program is None:
            with _compiling:  # of many threads that come at once, one compiles
                program = self.programs.get(key)
                if program is None:
                    program = self.programs[key] = self._program(tree, kinds, given)
        return program(leaves, given)

    def _program(self, tree: Any, kinds: tuple[Any, ...], given: list[Any]) -> _Program:
        folder, described = store.folder(), Description(skeleton(tree))
        if folder is None or described.of_user:
            return self._compiled(tree, kinds, given)
        file = folder / self._file_name(repr(described.parts), str(kinds))
        if (program := self._read(file, given)) is not None:
            return program
        with store.being_made(file):  # of many processes that come at once, one compiles
            return self._read(file, given) or self._compiled(tree, kinds, given, file)

    def _file_name(self, *parts: str) -> str:
        """Return the name of a program's file: a hash of its parts and of everything else that it depends on."""
        content = hashlib.sha256(_made_from() + b"".join(part.encode() + b"\0" for part in parts))
        return f"{self.last.__name__}-{content.hexdigest()[:32]}{store.SUFFIX}"

    def _read(self, file: Path, given: list[Any]) -> _Program | None:
        """Read the program of a file if there is one and it runs on these arguments."""
        ready = ahead.taken(file)
        try:
            stored = store.read(file) if ready is None else ready.stored
            if stored is None:
                return None
            with store.being_loaded(file):
                parts = load.all_ready(stored.compiled) if ready is None else ready.parts
                return _checked(stored, parts, given)
        except Exception as error:  # another machine's, another JAX's: whatever it is, compiling helps
            _log.info("%s cannot be used: %s", file, error)
            store.remove(file)
            return None

    def _compiled(self, tree: Any, kinds: tuple[Any, ...], given: list[Any], file: Path | None = None) -> _Program:
        """Trace and compile the program, and write it to a file, if any."""
        between: list[Any] = []  # the structure of what the first part finds
        result: list[Any] = []

        def separate(numbers: Any, *others: Any) -> tuple[list[Any], Iterator[Any]]:
            each, rest = iter(numbers), iter(others)
            return [next(each if kind is float else rest) for kind in kinds], rest

        def begun(*arrays: Any) -> list[Any]:
            assert self.first is not None
            outputs, output_structure = jax.tree.flatten(self.first(*jax.tree.unflatten(tree, separate(*arrays)[0])))
            between[:] = [output_structure]
            return outputs

        def flat(*arrays: Any) -> list[Any]:
            leaves, carried = separate(*arrays)
            arguments = [*jax.tree.unflatten(tree, leaves), *(jax.tree.unflatten(it, carried) for it in between)]
            outputs, output_structure = jax.tree.flatten(self.last(*arguments))
            # A function that returns an argument unchanged returns the same object.
            place = {id(leaf): k for k, leaf in enumerate(leaves)}
            sources = tuple(place.get(id(leaf)) for leaf in outputs)
            result[:] = [output_structure, sources]
            return [leaf for leaf, source in zip(outputs, sources, strict=True) if source is None]

        begin = time.monotonic()
        functions = [begun, flat] if self.first else [flat]
        with _announced(Compilation(self.what, _expected(self.last.__name__, self.seconds))):
            built = _built(functions, given, keep=file is not None)
        trim()  # what only compiling needed is half of what the process then holds
        program = _Program(built.parts, result[0], result[1], time.monotonic() - begin)
        if file is not None and built.codes:
            _write(file, program, built.codes)
        return program


_functions: weakref.WeakSet[stored[Any]] = weakref.WeakSet()


def drop_programs() -> None:
    """Drop the programs of all functions from memory; those that run meanwhile in other threads stay until they end."""
    with _compiling:
        for function in list(_functions):
            function.programs.clear()


def after(
    first: Callable[..., Any], seconds: float = UNKNOWN, what: str = PROGRAM
) -> Callable[[Callable[..., R]], stored[R]]:
    """Mark a function as `stored` whose last argument is what ``first`` finds from the others: each is a program of its
    own, and the second is traced and compiled while XLA is at work on the first. ``seconds``: how long that takes,
    roughly, until it has been done once; ``what``: what it computes, in words."""
    return lambda function: stored(function, first, seconds, what)


def _kind(leaf: Any) -> Any:
    """Return `float` for a number that may share an array with others, `Tracer`, or shape and type."""
    if type(leaf) is float or (type(leaf) is np.ndarray and leaf.shape == () and leaf.dtype == float):
        return float
    if isinstance(leaf, jax.core.Tracer):
        return jax.core.Tracer
    shape, kind = np.shape(leaf), jax.dtypes.result_type(leaf)
    return float if shape == () and kind is np.dtype(float) else (shape, kind)


@contextlib.contextmanager
def _announced(compilation: Compilation) -> Iterator[None]:
    """Tell the watcher that a compilation begins, and when it ends."""
    watcher = _watcher or (lambda _: None)
    watcher(compilation)
    try:
        yield
    finally:
        watcher(None)


@contextlib.contextmanager
def _uncollected() -> Iterator[None]:
    """Suspend garbage collections, which go through everything that is being traced again and again."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


class _Built(NamedTuple):
    """The parts of a program that this process has compiled, and their codes: none where they cannot be kept."""

    parts: list[Compiled]
    codes: list[load.MachineCode]


@_uncollected()
def _built(functions: Sequence[Callable[..., list[Any]]], arguments: Sequence[Any], keep: bool) -> _Built:
    """Compile functions of arrays for arguments like these, for `_run`, to ``keep`` their codes or not.

    Each takes the results of those before as well. XLA compiles most of a program on one core, and a loop that is one
    kernel cannot be taken apart (see `process`). So what is computed from the loop's results is a program of its own:
    it is traced and compiled while XLA is at work on the loop.
    """
    made, compiling = [], []
    with ThreadPoolExecutor(len(functions)) as beside, load.beside_the_cache_of_jax():
        for function in functions:
            made.append(load.lowered(function, *arguments))
            compiling.append(beside.submit(made[-1].compile))
            arguments = [*arguments, *jax.tree.leaves(made[-1].out_info)]
        parts = [it.result() for it in compiling]
    try:
        return _Built(parts, [load.MachineCode.of(*pair) for pair in zip(made, parts, strict=True)] if keep else [])
    except Exception as error:  # callbacks, say: the program is in memory
        _log.info("a program cannot be kept: %s", error)
        return _Built(parts, [])


def _checked(there: store.Stored, parts: list[Compiled], given: list[Any]) -> _Program:
    """Return the program with these parts. It is run once here, where one that this machine cannot run may still be
    compiled anew."""
    jax.block_until_ready(_run(parts, given))
    # Reading a pickle may run code, and so may the machine code in the same file: trust comes from the folder.
    structure = jax.tree.structure(pickle.loads(there.example))
    return _Program(parts, structure, tuple(there.description["sources"]), there.description["seconds"])


def _run(parts: Sequence[Compiled], arguments: Sequence[Any]) -> list[Any]:
    """Return what the functions return: a second part gets the arguments and what the first one found."""
    between = parts[0](*arguments)
    return parts[1](*arguments, *between) if len(parts) > 1 else between


def _write(file: Path, program: _Program, codes: list[load.MachineCode]) -> None:
    """Write a program to a file, unless its result has classes of the user's."""
    example = skeleton(program.structure)
    if Description(example).of_user:
        return
    try:
        description = {"sources": program.sources, "seconds": program.seconds}
        store.write(file, store.Stored(description, pickle.dumps(example), codes))
    except (OSError, pickle.PicklingError, AttributeError, TypeError) as error:
        # The disk is full, or something has no pickle: the program is in memory.
        _log.info("%s cannot be written: %s", file, error)


def _expected(name: str, otherwise: float) -> float:
    """Return how long it will take to compile a function of this name [s]: as long as the last one that was stored."""
    folder = store.folder()
    with contextlib.suppress(OSError):  # another process may delete files
        files = [] if folder is None else list(folder.glob(f"{name}-*{store.SUFFIX}"))
        if files:
            file = max(files, key=os.path.getmtime)
            last = store.read(file)
            return otherwise if last is None else float(last.description["seconds"])
    return otherwise


@functools.cache
def _made_from() -> bytes:
    """Hash our own source, the packages, the processor and JAX's settings."""
    return hashlib.sha256("\0".join([sys.version, *kind().values()]).encode()).digest()
