"""What a piece of code is: a description that differs where two classes, functions or values differ.

Python lets a name stand for another class later on, and a method read globals that change. A program that was traced
from such code is the right one only as long as all of it is the same, so its description is part of the program's key.
What ships with Python, JAX and this package is known by its name: the versions are in the key as well.
"""

import dis
import enum
import functools
import hashlib
import inspect
import sys
import types
from collections.abc import Hashable, Iterator
from typing import Any

import equinox as eqx
import jax
import numpy as np

PACKAGES = ("jax", "jaxlib", "equinox", "diffrax", "jaxtyping", "lineax", "numpy", "optax", "optimistix")
_KNOWN = frozenset(sys.stdlib_module_names) | {"jaxbuffer", *PACKAGES}
CAN_CHANGE = 1 << 9  # a class's flag, `Py_TPFLAGS_HEAPTYPE`: made as the program runs, rather than part of Python
_PLAIN = (type(None), bool, int, float, complex, str, bytes, type(Ellipsis), type(NotImplemented), range)
# Names by which code reaches what cannot be seen in it
_HIDDEN = frozenset(
    "eval exec getattr attrgetter globals locals vars open modules __import__ import_module "  # noqa: SIM905
    "__dict__ __globals__ environ getenv argv".split()
)
# What Python, dataclasses and Equinox write into a class by themselves, from what is described anyway
_MADE = frozenset(
    "__dict__ __weakref__ __doc__ __module__ __qualname__ __annotations__ __annotate_func__ "  # noqa: SIM905
    "__annotations_cache__ __dataclass_params__ __dataclass_fields__ __match_args__ __parameters__ __orig_bases__ "
    "__abstractmethods__ _abc_impl __abstractvars__ __abstractclassvars__ __firstlineno__ __static_attributes__".split()
)


Seen = dict[int, tuple[int, Any]]  # by identity: in which order it came, and the thing itself, which so stays alive


class Same:
    """An object that can't be described: equal to itself alone, in this process alone."""

    __slots__ = ("object",)

    def __init__(self, object: Any) -> None:
        self.object = object

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and other.object is self.object

    def __hash__(self) -> int:
        return id(self.object)


def fingerprint(*things: Any) -> Hashable:
    """A description of classes, functions and values: nested tuples that are equal where the things are alike.

    It holds a `Same` for each thing, or part of it, of which that can't be told: `lasting` then says no.
    """
    seen: Seen = {}
    return tuple(_described(thing, seen) for thing in things)


def lasting(description: Hashable) -> bool:
    """Whether a description means the same in another process."""
    return not any(isinstance(part, Same) for part in _parts(description))


def known(thing: Any) -> bool:
    """Whether a class, function, module or empty mark is found under its own name in a package whose version says what
    it is."""
    if isinstance(thing, types.ModuleType):
        return _known_package(thing.__name__)
    if isinstance(thing, type) and not thing.__flags__ & CAN_CHANGE:
        return True
    module, name = getattr(thing, "__module__", None), getattr(thing, "__qualname__", None) or _mark(thing)
    if not (isinstance(module, str) and isinstance(name, str) and _known_package(module)):
        return False
    found: Any = sys.modules.get(module)
    for part in name.split("."):
        found = getattr(found, part, None)
    return found is thing


def lasts(thing: Any) -> bool:
    """Whether a class, function or value stays what it is as long as the packages do."""
    kind = type(thing)
    if kind in _PLAIN or isinstance(thing, np.dtype):
        return True
    if kind is tuple or kind is list:
        return all(map(lasts, thing))
    if isinstance(thing, eqx.Module):
        return known(kind) and all(map(lasts, vars(thing).values()))
    return known(kind if isinstance(thing, enum.Enum) else thing)


def _mark(thing: Any) -> str | None:
    """The name of an object without content that its own module has as a mark, `dataclasses.MISSING` say."""
    if getattr(thing, "__dict__", None) != {} or isinstance(thing, type):
        return getattr(thing, "__name__", None)
    values = vars(sys.modules.get(type(thing).__module__, types)).items()
    return next((name for name, value in values if value is thing), None)


def _known_package(name: str) -> bool:
    return name.partition(".")[0] in _KNOWN


def _parts(description: Any) -> Iterator[Any]:
    if isinstance(description, tuple):
        for part in description:
            yield from _parts(part)
    else:
        yield description


def _described(thing: Any, seen: Seen) -> Hashable:
    kind = type(thing)
    if kind in _PLAIN:
        return (kind.__name__, repr(thing))
    if kind is tuple or kind is list:
        return (kind.__name__, *(_described(part, seen) for part in thing))
    if id(thing) in seen:  # code refers to its own class, and classes to each other
        return ("again", seen[id(thing)][0])
    seen[id(thing)] = (len(seen), thing)
    if known(thing):
        module, name = getattr(thing, "__module__", ""), getattr(thing, "__qualname__", None) or _mark(thing)
        return ("known", f"{module}.{name}")
    describe = next((describe for kinds, describe in _DESCRIBED if isinstance(thing, kinds)), None)
    return (kind.__name__, *describe(thing, seen)) if describe is not None else Same(thing)


def _mapping(mapping: Any, seen: Seen) -> tuple[Hashable, ...]:
    return tuple((_described(key, seen), _described(value, seen)) for key, value in mapping.items())


def _class(cls: type, seen: Seen) -> tuple[Hashable, ...]:
    fields = [
        (field.name, _described(dict(field.metadata), seen), _described(field.default_factory, seen))
        for field in getattr(cls, "__dataclass_fields__", {}).values()
    ]
    own = {name: value for name, value in vars(cls).items() if name not in _MADE}
    above = (_described(base, seen) for base in (type(cls), *cls.__bases__))
    return (f"{cls.__module__}.{cls.__qualname__}", *above, *fields, *_mapping(own, seen))


def _function(function: types.FunctionType, seen: Seen) -> tuple[Hashable, ...]:
    code = function.__code__
    names = _names(code)
    if not names.isdisjoint(_HIDDEN):
        return (Same(function),)
    read = {name: function.__globals__[name] for name in sorted(names) if name in function.__globals__}
    return (
        code.co_name,
        _code(code),
        _described(function.__defaults__, seen),
        _described(function.__kwdefaults__, seen),
        tuple(_cell(cell, seen) for cell in function.__closure__ or ()),
        _described(function.__dict__, seen),
        *((name, _global(value, names, seen)) for name, value in read.items()),
        *((name, _import(name, names, seen)) for name in sorted(_imported(code))),
    )


def _global(value: Any, names: frozenset[str], seen: Seen) -> Hashable:
    """What a global stands for; of a module of the user's, the attributes that the code names."""
    if not isinstance(value, types.ModuleType) or known(value):
        return _described(value, seen)
    used = {name: vars(value)[name] for name in sorted(names) if name in vars(value)}
    return ("module", value.__name__, *_mapping(used, seen))


def _import(name: str, names: frozenset[str], seen: Seen) -> Hashable:
    """What a module stands for that a function imports itself; a relative name can't be told."""
    if _known_package(name):
        return ("known", name)
    return _global(sys.modules[name], names, seen) if name in sys.modules else Same(object())


def _cell(cell: types.CellType, seen: Seen) -> Hashable:
    try:
        return _described(cell.cell_contents, seen)
    except ValueError:  # not filled yet
        return "empty"


@functools.lru_cache(maxsize=4096)
def _code(code: types.CodeType) -> tuple[Hashable, ...]:
    """The instructions and all that they name, but neither file nor lines."""
    constants = tuple(_code(c) if isinstance(c, types.CodeType) else _constant(c) for c in code.co_consts)
    words = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
    counts = (code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags)
    return (code.co_code, getattr(code, "co_exceptiontable", b""), words, counts, constants)


def _constant(value: Any) -> Hashable:
    if isinstance(value, tuple):
        return ("tuple", *map(_constant, value))
    if isinstance(value, frozenset):
        return ("frozenset", *sorted(map(repr, value)))
    return (type(value).__name__, repr(value))


@functools.lru_cache(maxsize=4096)
def _names(code: types.CodeType) -> frozenset[str]:
    """Names of globals and attributes in a function and those within."""
    return frozenset(code.co_names).union(*(_names(c) for c in code.co_consts if isinstance(c, types.CodeType)))


@functools.lru_cache(maxsize=4096)
def _imported(code: types.CodeType) -> frozenset[str]:
    """Modules that a function and those within import themselves."""
    own = {i.argval for i in dis.get_instructions(code) if i.opname == "IMPORT_NAME"}
    return frozenset(own).union(*(_imported(c) for c in code.co_consts if isinstance(c, types.CodeType)))


def _array(array: Any, seen: Seen) -> tuple[Hashable, ...]:
    if isinstance(array, jax.core.Tracer):
        return (Same(array),)
    numbers = np.asarray(array)
    if numbers.dtype.hasobject:
        return (Same(array),)
    return (str(numbers.dtype), numbers.shape, hashlib.sha256(np.ascontiguousarray(numbers).tobytes()).hexdigest())


def _unordered(group: Any, seen: Seen) -> tuple[Hashable, ...]:
    """A set, if all in it is plain."""
    if not all(type(part) in _PLAIN for part in group):
        return (Same(group),)
    return tuple(sorted((type(part).__name__, repr(part)) for part in group))


_DESCRIBED: tuple[tuple[Any, Any], ...] = (
    (enum.Enum, lambda x, seen: (_described(type(x), seen), x.name)),
    (type, _class),
    (types.FunctionType, _function),
    (types.MethodType, lambda x, seen: (_described(x.__func__, seen), _described(x.__self__, seen))),
    (property, lambda x, seen: tuple(_described(f, seen) for f in (x.fget, x.fset, x.fdel))),
    ((staticmethod, classmethod), lambda x, seen: (_described(x.__func__, seen),)),
    (functools.partial, lambda x, seen: tuple(_described(part, seen) for part in (x.func, x.args, x.keywords))),
    (functools.cached_property, lambda x, seen: (_described(x.func, seen),)),
    ((jax.custom_jvp, jax.custom_vjp), lambda x, seen: _mapping(vars(x), seen)),
    (type(jax.jit(lambda: None)), lambda x, seen: (_described(inspect.unwrap(x), seen),)),
    ((np.ndarray, np.generic, jax.Array), _array),
    (np.dtype, lambda x, seen: (x.str,)),
    ((dict, types.MappingProxyType), _mapping),
    ((set, frozenset), _unordered),
    (tuple, lambda x, seen: (_described(type(x), seen), *(_described(part, seen) for part in x))),
    (eqx.Module, lambda x, seen: (_described(type(x), seen), *_mapping(vars(x), seen))),
)
