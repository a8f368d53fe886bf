"""`jaxbuffer fields`: what a mechanism's studies are written with."""

from typing import Annotated

import typer

from .exits import OK
from .streams import show


def fields(
    kind: Annotated[str, typer.Argument(metavar="KIND", help="A mechanism's name, as kind in CONFIG.toml.")] = "",
) -> int:
    """List a mechanism's fields with units, defaults and ranges, and the quantities of its runs; without KIND, the
    mechanisms there are.

    \b
    Example: jaxbuffer fields
    """
    from ..mechanisms import all_mechanisms, mechanism_named
    from ..mechanisms.described import described

    if kind:
        show(described(mechanism_named(kind)))
        return OK
    for known in all_mechanisms():
        show(f'kind = "{known.name}"  {known.view.title}')
    return OK
