"""What a program is made from: code that the versions of packages pin down, and code of the user's, which may change.

Python lets a name stand for another class later on, and a method read globals that change. Programs of such code are
kept in memory only, by a `fingerprint` that differs where the code does. Packages' own code has a `label` instead, by
which another process finds the program on disk. A sweep or a tuning that is resumed, in whatever process, knows the
user's code by its `digest`.
"""

import dataclasses
import enum
import functools
import hashlib
import pickle
import sys
import types
from collections.abc import Hashable
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import numpy as np

from .process import PACKAGES

OURS = frozenset({"jaxbuffer"})
_KNOWN = frozenset(sys.stdlib_module_names) | frozenset(PACKAGES)
CAN_CHANGE = 1 << 9  # a class's flag, `Py_TPFLAGS_HEAPTYPE`: made as the program runs, rather than part of Python
_PLAIN = (type(None), bool, int, float, complex, str, bytes, type(Ellipsis), type(NotImplemented), range)
# What Python, dataclasses and Equinox write into a class by themselves, from what is described anyway
_MADE = frozenset(
    "__dict__ __weakref__ __doc__ __module__ __qualname__ __annotations__ __annotate_func__ "  # noqa: SIM905
    "__annotations_cache__ __dataclass_params__ __dataclass_fields__ __match_args__ __parameters__ __orig_bases__ "
    "__abstractmethods__ _abc_impl __abstractvars__ __abstractclassvars__ __firstlineno__ __static_attributes__".split()
)
_WRAPPERS: tuple[tuple[Any, tuple[str, ...]], ...] = (  # of functions, and where these are in them
    (types.MethodType, ("__func__", "__self__")),
    (property, ("fget", "fset", "fdel")),
    ((staticmethod, classmethod), ("__func__",)),
    (functools.partial, ("func", "args", "keywords")),
    (functools.cached_property, ("func",)),
    (type(jax.jit(lambda: None)), ("__wrapped__",)),
)

SITES = ("site-packages", "dist-packages")  # folders of packages that are installed


class UserCode(ValueError):
    """Code that no package's version pins down."""


class Visited(dict[int, tuple[int, Any]]):
    """What was described already, by identity: in which order it came, and the thing itself, which so stays alive.

    ``for_all``: whether the description is to mean the same in every process, rather than in this one alone.
    """

    def __init__(self, for_all: bool = False) -> None:
        super().__init__()
        self.for_all = for_all


class Same:
    """An object that is described by itself: equal to itself alone, in this process alone."""

    __slots__ = ("object",)

    def __init__(self, object: Any) -> None:
        self.object = object

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and other.object is self.object

    def __hash__(self) -> int:
        return id(self.object)


# Packages' code


def known(thing: Any) -> bool:
    """Return whether a class, function, module or empty mark is found under its own name in a package whose version
    says what it is."""
    if isinstance(thing, types.ModuleType):
        return _known_package(thing.__name__)
    if isinstance(thing, type) and not thing.__flags__ & CAN_CHANGE:
        return True
    module, name = _address(thing)
    if not (isinstance(module, str) and isinstance(name, str) and _known_package(module)):
        return False
    target: Any = sys.modules.get(module)
    for part in name.split("."):
        target = getattr(target, part, None)
    return target is thing


def label(thing: Any) -> Hashable:  # noqa: PLR0911 # a table of kinds
    """Describe a class, function or value that is the same in every process with the same packages.

    **Raises:** `UserCode` where the thing is or holds code that the packages do not pin down.
    """
    kind = type(thing)
    if kind in _PLAIN or isinstance(thing, np.dtype):
        return (kind.__name__, repr(thing))
    if isinstance(thing, (tuple, list)):
        return (label(kind), *map(label, thing))
    if kind is dict:
        return ("dict", *map(label, thing.items()))
    if isinstance(thing, enum.Enum):
        return (label(kind), thing.name)
    if isinstance(thing, eqx.Module):
        return (label(kind), *((name, label(value)) for name, value in vars(thing).items()))
    if known(thing):
        return ("known", *_address(thing))
    if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        compared = (field.name for field in dataclasses.fields(thing) if field.compare)
        return (label(kind), *((name, label(getattr(thing, name))) for name in compared))
    if isinstance(thing, types.FunctionType) and "<" in thing.__qualname__ and _known_package(thing.__module__):
        # A lambda, or a function made by another, has no address; its code and what it is closed over tell it apart.
        around = (cell.cell_contents for cell in thing.__closure__ or ())
        return ("made", thing.__module__, _code(thing.__code__), label(thing.__defaults__), *map(label, around))
    raise UserCode(f"{thing!r} is no package's code")


def lasts(thing: Any) -> bool:
    """Return whether a class, function or value stays what it is as long as the packages do."""
    try:
        label(thing)
    except UserCode:
        return False
    return True


def _address(thing: Any) -> tuple[str | None, str | None]:
    """Return the module and the name by which a thing says that it can be found."""
    return getattr(thing, "__module__", None), getattr(thing, "__qualname__", None) or _mark(thing)


def _mark(thing: Any) -> str | None:
    """Return the name of an object without content that its own module has as a mark, `dataclasses.MISSING` say."""
    if getattr(thing, "__dict__", None) != {} or isinstance(thing, type):
        return getattr(thing, "__name__", None)
    values = vars(sys.modules.get(type(thing).__module__, types)).items()
    return next((name for name, value in values if value is thing), None)


def _known_package(name: str) -> bool:
    first = name.partition(".")[0]
    return first in _KNOWN or first in OURS


# The user's code


def fingerprint(*things: Any) -> Hashable:
    """Describe classes, functions and values, for this process alone, by nested tuples that are equal where the things
    are alike. What cannot be described, such as code of a C extension, is equal to itself."""
    visited = Visited()
    return tuple(_described(thing, visited) for thing in things)


def digest(*things: Any) -> str:
    """Return a hash of code, with all of the user's that it reads, that is the same in every process with this Python.
    What cannot be described counts by its type alone."""
    visited = Visited(for_all=True)
    text = repr(tuple(_described(thing, visited) for thing in things))
    return hashlib.sha256(text.encode(errors="backslashreplace")).hexdigest()[:16]


def _described(thing: Any, visited: Visited) -> Hashable:  # noqa: PLR0911, PLR0912 # a table of kinds
    kind = type(thing)
    if kind in _PLAIN:
        return (kind.__name__, repr(thing))
    if kind is tuple or kind is list:
        return (kind.__name__, *(_described(part, visited) for part in thing))
    if id(thing) in visited:  # code refers to its own class, and classes to each other
        return ("again", visited[id(thing)][0])
    # Kept with the thing itself, since the id of one that is gone may become another's.
    visited[id(thing)] = (len(visited), thing)
    if known(thing):
        return ("known", *_address(thing)) if visited.for_all else Same(thing)
    if visited.for_all and (package := _installed(thing)):
        return package
    if isinstance(thing, type):
        return _class(thing, visited)
    if isinstance(thing, types.FunctionType):
        return _function(thing, visited)
    if isinstance(thing, (dict, types.MappingProxyType)):
        return _mapping(thing, visited)
    if isinstance(thing, tuple):
        return (_described(kind, visited), *(_described(part, visited) for part in thing))
    if isinstance(thing, (set, frozenset)) and all(type(part) in _PLAIN for part in thing):
        return (kind.__name__, *sorted((type(part).__name__, repr(part)) for part in thing))
    if isinstance(thing, enum.Enum):
        return (_described(kind, visited), thing.name)
    if isinstance(thing, (eqx.Module, jax.custom_jvp, jax.custom_vjp)):
        return (_described(kind, visited), *_mapping(vars(thing), visited))
    if isinstance(thing, (np.ndarray, np.generic, jax.Array)) and not isinstance(thing, jax.core.Tracer):
        numbers = np.asarray(thing)
        if not numbers.dtype.hasobject:
            return (str(numbers.dtype), numbers.shape, hashlib.sha256(numbers.tobytes()).hexdigest())
    for wrappers, names in _WRAPPERS:
        if isinstance(thing, wrappers):
            return (kind.__name__, *(_described(getattr(thing, name), visited) for name in names))
    return _object(thing, visited) if visited.for_all else Same(thing)


def _object(thing: Any, visited: Visited) -> Hashable:
    """Describe an object of any other class by what it holds, so that another process describes it alike."""
    kind = type(thing)
    if dataclasses.is_dataclass(thing):
        parts = {field.name: getattr(thing, field.name, None) for field in dataclasses.fields(thing) if field.compare}
    elif isinstance(thing, types.ModuleType):
        return ("module", thing.__name__)
    elif not known(kind) and not _installed(kind) and hasattr(thing, "__dict__"):
        # Whether a cached property was asked for yet says nothing of the thing.
        cached = {name for name, value in vars(kind).items() if isinstance(value, functools.cached_property)}
        parts = {name: value for name, value in vars(thing).items() if name not in cached}
    elif hasattr(thing, "__wrapped__"):
        parts = {"wrapped": thing.__wrapped__}
    else:
        try:
            parts = {"pickled": hashlib.sha256(pickle.dumps(thing, protocol=4)).hexdigest()}
        except Exception:  # a lock, a stream: its type says what can be said
            parts = {}
    return ("object", _described(kind, visited), *_mapping(parts, visited))


def _installed(thing: Any) -> Hashable:
    """Describe a class or function of an installed package by its name and that package's source; None for any other
    thing."""
    module, name = getattr(thing, "__module__", None), getattr(thing, "__qualname__", None)
    if not (isinstance(module, str) and isinstance(name, str)) or "<" in name:
        return None
    source = _package_source(module.partition(".")[0])
    return ("installed", module, name, source) if source else None


@functools.cache
def _package_source(name: str) -> str:
    """Return a hash of the Python files of an installed package, "" for what is not installed."""
    place = Path(getattr(sys.modules.get(name), "__file__", None) or "")
    if not set(SITES) & set(place.parts):
        return ""
    content = hashlib.sha256()
    for file in sorted(place.parent.rglob("*.py")) if place.name == "__init__.py" else [place]:
        content.update(f"{file.name}\0".encode() + file.read_bytes())
    return content.hexdigest()[:16]


def _mapping(mapping: Any, visited: Visited) -> tuple[Hashable, ...]:
    return tuple((_described(key, visited), _described(value, visited)) for key, value in mapping.items())


def _class(cls: type, visited: Visited) -> tuple[Hashable, ...]:
    fields = [
        (field.name, _described(dict(field.metadata), visited), _described(field.default_factory, visited))
        for field in getattr(cls, "__dataclass_fields__", {}).values()
    ]
    own = {name: value for name, value in vars(cls).items() if name not in _MADE}
    above = (_described(base, visited) for base in (type(cls), *cls.__bases__))
    return (f"{cls.__module__}.{cls.__qualname__}", *above, *fields, *_mapping(own, visited))


def _function(function: types.FunctionType, visited: Visited) -> tuple[Hashable, ...]:
    """Describe a function by its code and all that it reads: defaults, variables around it, globals and modules that it
    imports by name."""
    code = function.__code__
    names = _names(code)
    reads = {name: function.__globals__.get(name, sys.modules.get(name)) for name in sorted(names)}
    return (
        _code(code),
        *(_described(part, visited) for part in (function.__defaults__, function.__kwdefaults__, function.__dict__)),
        tuple(_cell(cell, names, visited) for cell in function.__closure__ or ()),
        tuple((name, _global(value, names, visited)) for name, value in reads.items() if value is not None),
    )


def _global(value: Any, names: frozenset[str], visited: Visited) -> Hashable:
    """Describe what a global stands for; of a module of the user's, the attributes that the code names."""
    if not isinstance(value, types.ModuleType) or known(value):
        return _described(value, visited)
    used = {name: vars(value)[name] for name in sorted(names) if name in vars(value)}
    return ("module", value.__name__, *_mapping(used, visited))


def _cell(cell: types.CellType, names: frozenset[str], visited: Visited) -> Hashable:
    try:
        return _global(cell.cell_contents, names, visited)
    except ValueError:  # not filled yet
        return "empty"


@functools.lru_cache(maxsize=4096)
def _code(code: types.CodeType) -> tuple[Hashable, ...]:
    """Describe code by its instructions and all that they name, but by neither file nor lines."""
    constants = tuple(_code(c) if isinstance(c, types.CodeType) else _constant(c) for c in code.co_consts)
    words = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
    counts = (code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags)
    return (code.co_code, getattr(code, "co_exceptiontable", b""), words, counts, constants)


def _constant(value: Any) -> Hashable:
    if isinstance(value, frozenset):  # in an order that differs between processes
        return ("frozenset", *sorted(map(repr, value)))
    return (type(value).__name__, *map(_constant, value)) if isinstance(value, tuple) else (type(value), repr(value))


@functools.lru_cache(maxsize=4096)
def _names(code: types.CodeType) -> frozenset[str]:
    """Return the names of globals, attributes and imported modules in a function and those within."""
    return frozenset(code.co_names).union(*(_names(c) for c in code.co_consts if isinstance(c, types.CodeType)))
