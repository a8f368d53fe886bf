"""Whose code a program is made from: that of packages, which their versions pin down, or the user's, which may change.

A program of packages' code is kept on disk by the code's `Description`. One of the user's code stays in memory, where a
class is its own key, because a class that is defined again is another object. A sweep or a tuning that is resumed, in
whatever process, knows the user's code by its `user_code`: by what Python has compiled, rather than by a file, so that
it is the same where ``resume=True`` was added below it, and code that was typed at a prompt or in a notebook has one.
"""

import contextlib
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

import jax
import numpy as np
from jax.tree_util import PyTreeDef

from .process import PACKAGES

OURS = frozenset({"jaxbuffer"})
SITES = ("site-packages", "dist-packages")  # folders of packages that are installed
LEAF = ...  # stands for a number of a tree: JAX takes it for a leaf, and no static value is one
_KNOWN = frozenset(sys.stdlib_module_names) | frozenset(PACKAGES)
_CAN_CHANGE = 1 << 9  # a class's flag, `Py_TPFLAGS_HEAPTYPE`: made as the program runs, rather than part of Python
_PLAIN = (type(None), bool, int, float, complex, str, bytes, type(Ellipsis), type(NotImplemented), range)
# Where methods, properties, partial and compiled functions have the functions that they are made of.
_INSIDE = ("__wrapped__", "__func__", "__self__", "fget", "fset", "fdel", "func", "args", "keywords")


def code_hash(*things: Any) -> str:
    """Return a hash of classes and functions, with the user's code and the values that they use: the same in every
    process with this Python."""
    return _hash(Description(*things).parts)


def user_code(*things: Any) -> str:
    """Return a hash of the user's code that numbers of these designs, mechanisms and classes depend on, the same in
    every process with this Python; "" where the packages have all of it."""
    structures = tuple(thing if isinstance(thing, type) else jax.tree.structure(thing) for thing in things)
    return _hash(_described(structures).of_user) if _of_user(structures) else ""


def skeleton(structure: PyTreeDef) -> Any:
    """Return a tree of this structure, with its classes and static values, and `LEAF` in place of each number."""
    return jax.tree.unflatten(structure, [LEAF] * structure.num_leaves)


def _described(structures: tuple[Any, ...]) -> "Description":
    return Description(*(it if isinstance(it, type) else skeleton(it) for it in structures))


# Remembered, because looking takes over a quarter of a sweep of one run, and the code of the packages does not change.
@functools.lru_cache(maxsize=64)
def _of_user(structures: tuple[Any, ...]) -> bool:
    """Return whether any of the user's code belongs to these structures and classes."""
    return bool(_described(structures).of_user)


def _hash(parts: Any) -> str:
    return hashlib.sha256(repr(parts).encode(errors="backslashreplace")).hexdigest()[:16]


def known(thing: Any) -> bool:
    """Return whether a class, function or module is found under its own name in a package whose version says what it
    is."""
    if isinstance(thing, types.ModuleType):
        return _of_package(thing.__name__)
    if isinstance(thing, type) and not thing.__flags__ & _CAN_CHANGE:
        return True
    module, name = _address(thing)
    if not (isinstance(module, str) and isinstance(name, str) and _of_package(module)):
        return False
    target: Any = sys.modules.get(module)
    for part in name.split("."):
        target = getattr(target, part, None)
    return target is thing


class Description:
    """Classes, functions and values, described by nested tuples of text that are the same in every process.

    ``parts``: those tuples; ``of_user``: those of code that no package's version pins down.
    """

    def __init__(self, *things: Any) -> None:
        self.of_user: list[Hashable] = []
        self._visited: dict[int, tuple[int, Any]] = {}  # by identity, with the thing itself, which so stays alive
        self.parts = tuple(map(self._of, things))

    def _of(self, thing: Any) -> Hashable:  # noqa: PLR0911, PLR0912 # a table of kinds
        kind = type(thing)
        if kind in _PLAIN or isinstance(thing, np.dtype):
            return (kind.__name__, repr(thing))
        if isinstance(thing, (tuple, list)):
            return (self._of(kind), *map(self._of, thing))
        if isinstance(thing, (set, frozenset)):  # in an order that differs between processes
            return (kind.__name__, *sorted(repr(self._of(part)) for part in thing))
        if isinstance(thing, (dict, types.MappingProxyType)):
            return ("dict", *map(self._of, thing.items()))
        if isinstance(thing, (np.ndarray, np.generic, jax.Array)) and not isinstance(thing, jax.core.Tracer):
            numbers = np.asarray(thing)
            return (str(numbers.dtype), numbers.shape, hashlib.sha256(numbers.tobytes()).hexdigest())
        if isinstance(thing, types.CodeType):
            names = (thing.co_names, thing.co_varnames, thing.co_argcount, thing.co_kwonlyargcount, thing.co_flags)
            return (thing.co_code, *names, self._of(thing.co_consts))
        if known(thing):
            return ("known", *_address(thing))
        if isinstance(thing, types.FunctionType) and _written_in_package(thing):
            return self._made(thing)
        if not isinstance(thing, (type, types.FunctionType, types.ModuleType)) and known(kind):
            return self._object(thing)
        if id(thing) in self._visited:  # code refers to its own class, and classes to each other
            return self._users("again", self._visited[id(thing)][0])
        self._visited[id(thing)] = (len(self._visited), thing)
        if isinstance(thing, types.ModuleType):
            return self._users("module", thing.__name__)
        if isinstance(thing, type):
            return self._users(*(_installed(thing) or self._class(thing)))
        if isinstance(thing, types.FunctionType):
            return self._users(*(_installed(thing) or self._function(thing)))
        return self._object(thing)

    def _users(self, *parts: Hashable) -> Hashable:
        """Return the description of something that no package's version pins down, and note it."""
        self.of_user.append(parts)
        return parts

    def _made(self, function: types.FunctionType) -> tuple[Hashable, ...]:
        """Describe a function by its name, what Python has compiled, and the values that it is closed over."""
        name = (function.__module__, function.__qualname__)
        return (*name, *map(self._of, (function.__code__, function.__defaults__, *_around(function))))

    def _object(self, thing: Any) -> Hashable:
        """Describe an object by what it holds that makes it equal to another."""
        kind = type(thing)
        if isinstance(thing, enum.Enum):
            return (self._of(kind), thing.name)
        inside = {name: getattr(thing, name) for name in _INSIDE if hasattr(thing, name)}
        # A method shows its function's names, and is no empty mark for all that.
        if not inside and kind.__bases__ == (object,) and getattr(thing, "__dict__", None) == {}:  # an empty mark
            return self._of(kind)
        if dataclasses.is_dataclass(thing):
            compared = [field.name for field in dataclasses.fields(thing) if field.compare]
            return (self._of(kind), self._of({name: getattr(thing, name, None) for name in compared}))
        if isinstance(thing, (jax.custom_jvp, jax.custom_vjp)) or not (known(kind) or _installed(kind) or inside):
            # Whether a cached property was asked for yet says nothing of the thing.
            cached = {name for name, value in vars(kind).items() if isinstance(value, functools.cached_property)}
            inside |= {name: value for name, value in getattr(thing, "__dict__", {}).items() if name not in cached}
        pickled = ""
        if not inside:
            try:
                pickled = hashlib.sha256(pickle.dumps(thing, protocol=4)).hexdigest()
            except Exception:  # it holds what cannot be pickled, such as an optimizer's functions
                if id(thing) not in self._visited:  # it may be held by what it holds
                    self._visited[id(thing)] = (len(self._visited), thing)
                    # Of a lock or a stream, which holds nothing by name, its type says what can be said.
                    inside = dict(getattr(thing, "__dict__", {}))
        return self._users(self._of(kind), self._of(inside), pickled)  # it may hold anything

    def _class(self, cls: type) -> tuple[Hashable, ...]:
        """Describe a class of the user's: bases, fields, attributes and methods."""
        fields = [
            (field.name, bool(field.metadata.get("static")), self._of(field.default_factory))
            for field in getattr(cls, "__dataclass_fields__", {}).values()
        ]
        own = {
            name: value
            for name, value in vars(cls).items()
            if not name.startswith("__") or isinstance(value, types.FunctionType)
        }
        return (f"{cls.__module__}.{cls.__qualname__}", *map(self._of, cls.__bases__), *fields, self._of(own))

    def _function(self, function: types.FunctionType) -> tuple[Hashable, ...]:
        """Describe a function of the user's, with all that it uses: the globals and modules that it names."""
        names = sorted(_names(function.__code__))
        used = {name: function.__globals__.get(name, sys.modules.get(name)) for name in names}
        parts = *self._made(function), self._of(function.__kwdefaults__), self._of(vars(function))
        return (*parts, *((name, self._global(it, names)) for name, it in used.items()))

    def _global(self, value: Any, names: list[str]) -> Hashable:
        """Describe what a global stands for; of a module of the user's, the attributes that the code ``names``."""
        if not isinstance(value, types.ModuleType) or known(value):
            return self._of(value)
        return (value.__name__, self._of({name: vars(value)[name] for name in names if name in vars(value)}))


def _of_package(module: str | None) -> bool:
    return (module or "").partition(".")[0] in _KNOWN | OURS


def _written_in_package(function: types.FunctionType) -> bool:
    """Return whether a function is in a package's file, whatever it says of itself: `exec` and `functools.wraps` give
    other names."""
    name = function.__globals__.get("__name__", "")
    return _of_package(name) and function.__globals__ is getattr(sys.modules.get(name), "__dict__", None)


def _address(thing: Any) -> tuple[str | None, str | None]:
    """Return the module and the name by which a thing says that it can be found."""
    name = getattr(thing, "__qualname__", None) or getattr(thing, "__name__", None)
    return getattr(thing, "__module__", None), name


def _installed(thing: Any) -> tuple[Hashable, ...]:
    """Describe a class or function of an installed package by its name and its module's file; () for any other."""
    place = Path(getattr(sys.modules.get(thing.__module__), "__file__", None) or "")
    # Code at a prompt that a tool shows is in `__main__`, of which the tool is the file.
    if thing.__module__ == "__main__" or "<" in thing.__qualname__ or not set(SITES) & set(place.parts):
        return ()
    return (thing.__module__, thing.__qualname__, hashlib.sha256(place.read_bytes()).hexdigest())


def _around(function: types.FunctionType) -> list[Any]:
    """Return the values that a function is closed over."""
    values = []
    for cell in function.__closure__ or ():
        with contextlib.suppress(ValueError):  # not filled yet
            values.append(cell.cell_contents)
    return values


def _names(code: types.CodeType) -> frozenset[str]:
    """Return the names of globals, attributes and imported modules in a function and those within."""
    return frozenset(code.co_names).union(*(_names(it) for it in code.co_consts if isinstance(it, types.CodeType)))
