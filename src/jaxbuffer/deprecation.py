"""Names of earlier releases: they work until the release that is named, and warn of the new one."""

import functools
import warnings
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


class Renamed(NamedTuple):
    """What became of a name: the ``new`` one, the release ``since`` which the old one is deprecated, and that in which
    it is ``removed``."""

    new: str
    since: str
    removed: str

    def warn(self, old: str, stacklevel: int) -> None:
        """Warn of the old name. ``stacklevel``: how many calls up the user's line is, as for `warnings.warn`."""
        text = f"{old} is deprecated since jaxbuffer {self.since} and goes in {self.removed}: use {self.new}"
        # A FutureWarning is shown to everybody, a DeprecationWarning to those alone who run tests.
        warnings.warn(text, FutureWarning, stacklevel=stacklevel + 1)


NAMES: Mapping[str, Renamed] = MappingProxyType({})
"""The public names of earlier releases, `jaxbuffer.NAME`; none so far."""


def renamed_keywords(**renamed: Renamed) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Let a function take keywords of earlier releases.

    **Arguments:** ``renamed``: what became of each, by its old name.

    **Returns:** a decorator, which passes an old keyword's value on under the new name and warns. Both at once are a
    `TypeError`, as any argument that is given twice.

    **Example:**

    >>> import warnings
    >>> from jaxbuffer.deprecation import Renamed, renamed_keywords
    >>> @renamed_keywords(length=Renamed("stroke", since="1.1", removed="2.0"))
    ... def energy(stroke, stiffness):
    ...     return 0.5 * stiffness * stroke**2
    >>> with warnings.catch_warnings(record=True) as caught:
    ...     energy(length=0.02, stiffness=500.0)
    0.1
    >>> print(caught[0].message)
    length of energy is deprecated since jaxbuffer 1.1 and goes in 2.0: use stroke
    """

    def decorated(function: Callable[P, R]) -> Callable[P, R]:
        name = getattr(function, "__name__", "")

        @functools.wraps(function)
        def called(*args: P.args, **kwargs: P.kwargs) -> R:
            for old in renamed.keys() & kwargs.keys():
                it = renamed[old]
                it.warn(f"{old} of {name}", stacklevel=2)
                if it.new in kwargs:
                    raise TypeError(f"{name} got both {old} and {it.new}, which are the same")
                kwargs[it.new] = kwargs.pop(old)
            return function(*args, **kwargs)

        return called

    return decorated


def by_former_name(name: str, names: Mapping[str, Renamed] = NAMES) -> str | None:
    """Return the present name of a public name of earlier releases, with a warning; None for any other."""
    if name not in names:
        return None
    names[name].warn(f"jaxbuffer.{name}", stacklevel=3)
    return names[name].new
