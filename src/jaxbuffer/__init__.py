"""jaxbuffer: which spring, damper and tip mass behind a docking probe give the smallest impact force.

Public names are imported when they are first asked for: `import jaxbuffer` takes no time, and a command pays for what
it uses. They stand in `__init__.pyi`, once for Python and for type checkers.

**Example:** what the examples of all public names begin with.

>>> import jaxbuffer as jb
>>> jb.configure()
"""

from typing import Any

import lazy_loader

_lazy, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    if name == "__version__":  # read from the package's metadata, which takes longer than the import
        from .version import version

        return version()
    if name not in __all__:
        from .deprecation import by_former_name

        if (present := by_former_name(name)) is not None:
            return _lazy(present)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return _lazy(name)
